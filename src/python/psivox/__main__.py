"""python -m psivox: the program, from a release's wheel or else from PATH."""

import os
import shutil
import sys


def main():
    own = os.path.join(os.path.dirname(__file__), "bin", "psivox")
    program = own if os.path.exists(own) else shutil.which("psivox")
    if not program:
        sys.exit("psivox: this Python package has no program; a release's wheel has one")
    os.execv(program, ["psivox", *sys.argv[1:]])


if __name__ == "__main__":
    main()
