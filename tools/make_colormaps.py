#!/usr/bin/env python3
"""Prints assets/colors/colormaps.json from matplotlib's tables (Debian: python3-matplotlib).

It keeps as few of a table's 256 sRGB codes as possible: linear radiance between those kept must
reproduce all others within half an 8-bit step."""

import matplotlib

MAPS = ["viridis", "inferno", "magma", "plasma", "cividis", "turbo"]
TOLERANCE = 0.5 / 255


def linear(code):  # IEC 61966-2-1
    return code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def code(light):
    return 12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055


def fits(table, a, b):
    """Whether linear radiance from entry a to entry b reproduces all entries between them."""
    for i in range(a + 1, b):
        t = (i - a) / (b - a)
        for channel in range(3):
            light = (1 - t) * linear(table[a][channel]) + t * linear(table[b][channel])
            if abs(code(light) - table[i][channel]) > TOLERANCE:
                return False
    return True


def kept(table):
    last = len(table) - 1
    knots = [0]
    while knots[-1] < last:
        knots.append(max(b for b in range(knots[-1] + 1, last + 1) if fits(table, knots[-1], b)))
    return knots


tables = []
for name in MAPS:
    table = matplotlib.colormaps[name].colors
    rows = ["[%s]" % ", ".join([str(i)] + ["%.6g" % c for c in table[i]]) for i in kept(table)]
    lines = ["    " + ", ".join(rows[i:i + 2]) for i in range(0, len(rows), 2)]
    tables.append('  "%s": [\n%s\n  ]' % (name, ",\n".join(lines)))
print("{\n" + ",\n".join(tables) + "\n}")
