#!/usr/bin/env python3
"""Prints the tables of src/scene/colormap.cpp from matplotlib's tables (Debian: python3-matplotlib).

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


print("""#pragma once

namespace psivox {

/// A knot of a colour map: its place in 256 and its sRGB code.
struct ColormapKnot {
  int place;
  double red, green, blue;
};

/// From matplotlib's tables by tools/make_colormaps.py: linear radiance between knots is within half
/// an 8-bit step of them. viridis, inferno, magma, plasma: S. van der Walt and N. Smith (CC0);
/// cividis: J. Nunez, C. Anderton, R. Renslow 2018 (CC0); turbo: A. Mikhailov, Google 2019
/// (Apache 2.0).
// clang-format off""")
for name in MAPS:
    table = matplotlib.colormaps[name].colors
    knots = kept(table)
    print(f"inline constexpr ColormapKnot {name}_knots[] = {{")
    for row in range(0, len(knots), 2):
        print("  " + " ".join("{%d, %s}," % (i, ", ".join("%.6g" % c for c in table[i]))
                              for i in knots[row:row + 2]))
    print("};")
print("""// clang-format on

}  // namespace psivox""")
