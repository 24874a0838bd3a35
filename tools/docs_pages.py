#!/usr/bin/env python3
"""Makes the pages in docs/pages of which README.md and docs/user-guide.md have a link and the command.

  docs_pages.py PSIVOX

The command of pages/NAME.html is the one that writes NAME.png from assets/, with fewer pixels and bytes.
"""
import pathlib
import re
import shlex
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
for text in (root / "README.md", root / "docs/user-guide.md"):
    text = text.read_text().replace("\\\n", " ")
    for name in sorted(set(re.findall(r"\((?:docs/)?pages/([\w-]+)\.html\)", text))):
        command = re.search(rf"^psivox (render assets/.* -o {name}\.png.*)$", text, re.M)[1]
        words = shlex.split(command.replace(f"-o {name}.png", f"-o docs/pages/{name}.html"))
        subprocess.run([sys.argv[1], *words, "--resolution", "480x270",
                        "--tolerance", "2e-3", "-q"], check=True, cwd=root)
