#!/usr/bin/env python3
"""Makes pages that turn of pictures in README.md and docs/user-guide.md: docs_pages.py PSIVOX FOLDER.

NAME.html comes from the documented command that writes NAME.png from assets/, with fewer pixels.
"""
import pathlib
import re
import shlex
import subprocess
import sys

program, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:])
root = pathlib.Path(__file__).resolve().parent.parent
text = "".join((root / name).read_text() for name in ("README.md", "docs/user-guide.md"))
folder.mkdir(parents=True, exist_ok=True)
for name in ("blobs", "shells", "tinted"):
    command = re.search(rf"^psivox (render assets/.* -o (?:build/)?{name}\.png.*)$",
                        text.replace("\\\n", " "), re.M)[1]
    words = shlex.split(command)
    words[words.index("-o") + 1] = str(folder / f"{name}.html")
    subprocess.run([program, *words, "--resolution", "480x270", "--tolerance", "2e-3", "-q"],
                   check=True, cwd=root)
