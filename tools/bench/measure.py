"""What the measurements of this folder share: runs of psivox, and what it says of them."""

import argparse
import json
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def parser_of(description, out):
    """A parser with options for the program and for a folder of pictures."""
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--psivox", default=ROOT / "build/release/bin/psivox")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / out)
    return parser


def render(options, arguments, picture):
    """Draws a picture; returns what --stats writes."""
    stats = options.out / "stats.json"
    subprocess.run([str(word) for word in (options.psivox, "render", *arguments, "-o", picture,
                                           "-q", "--stats", stats)], check=True)
    return json.loads(stats.read_text())
