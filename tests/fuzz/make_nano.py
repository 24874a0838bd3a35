#!/usr/bin/env python3
"""make_nano.py FOLDER FILE.nvdb...: packs the grids of each file for corpus/nano, as
unpacked_grid in packed_grid.h unpacks them. The files must be uncompressed."""
import os
import re
import sys


def pack(grid):
    return re.sub(rb"\0{1,65535}", lambda run: b"\0" + len(run[0]).to_bytes(2, "little"), grid)


def main():
    for path in sys.argv[2:]:
        with open(path, "rb") as file:
            data = file.read()
        grid = data[max(0, data.find(b"NanoVDB", 8)):]  # behind the header and entry, if any
        name = os.path.splitext(os.path.basename(path))[0]
        with open(os.path.join(sys.argv[1], name), "wb") as out:
            out.write(pack(b"NanoVDB1" + grid[8:]))


main()
