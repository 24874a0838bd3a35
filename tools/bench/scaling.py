#!/usr/bin/env python3
"""Measures how the march's time grows with pixels, voxels, the active fraction, the optical depth
and the tolerance, and how memory grows with active voxels.

    tools/bench/scaling.py [--rounds 5]

It needs numpy. The fields are fog, seven soft spheres times value noise, and white noise in a part
of the blocks of 8^3 voxels; each is its own luminance. The points of a curve take turns in rounds;
results are medians of processor time [ms], with the look-ups that psivox counted."""

import statistics

import numpy

from measure import parser_of, render

SPHERES = [((0, 0, 0), .42, .8), ((.42, .18, -.20), .34, .9), ((-.40, -.25, .22), .38, .75),
           ((.05, .50, .30), .28, 1), ((-.30, .42, -.38), .24, 1), ((.38, -.46, .34), .26, .9),
           ((-.02, -.38, -.50), .30, .7)]
FOG_EXTINCTION = 20


def value_noise(p):
    """Hashed lattice values, interpolated smoothly, at points of N x 3."""
    cell = numpy.floor(p).astype("i4")
    f = p - cell
    u = f ** 3 * (f * (f * 6 - 15) + 10)

    def lattice(corner):
        x, y, z = (cell + corner).astype("u4").T
        n = x * numpy.uint32(0x8da6b343) ^ y * numpy.uint32(0xd8163841) ^ z * numpy.uint32(0xcb1ab31f)
        for shift, factor in ((15, 0x2c1b3c6d), (12, 0x297a2d39)):
            n = (n ^ n >> shift) * numpy.uint32(factor)
        return (n ^ n >> 15) / 4294967295

    def along(axis, corner):
        if axis < 0:
            return lattice(corner)
        low, high = (along(axis - 1, corner + [side * (i == axis) for i in range(3)])
                     for side in (0, 1))
        return low + u[:, axis] * (high - low)
    return along(2, numpy.zeros(3, "i4"))


def make_fog(n):
    """n^3 voxels of width 2/n around the origin, about 20 % of them active: at n = 256 the scene
    that other renderers are measured on."""
    axis = (numpy.arange(n) - n // 2) * (2 / n)
    x, y, z = numpy.meshgrid(axis, axis, axis, indexing="ij", sparse=True)
    density = numpy.zeros((n, n, n))
    for (a, b, c), radius, peak in SPHERES:
        q = ((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / radius ** 2
        density += peak * numpy.maximum(1 - q, 0) ** 2
    inside = numpy.nonzero(density)
    p = numpy.stack([axis[i] for i in inside], 1) * 6 + 100
    total, amplitude = 0, 0.5
    for _ in range(4):
        total = total + amplitude * value_noise(p)
        amplitude *= 0.5
        p = p * (2.02, 2.03, 2.01) + (17.3, 5.1, -9.7)
    noise = total / 0.9375
    density[inside] = numpy.minimum(density[inside] * numpy.maximum(noise - 0.3, 0) * 2.6, 1)
    density[density < 1e-3] = 0
    return density


def make_blocks(n, part):
    random = numpy.random.default_rng(1)
    chosen = random.random((n // 8,) * 3) < part
    return random.random((n, n, n)) * chosen.repeat(8, 0).repeat(8, 1).repeat(8, 2)


def write(path, values, width):
    """NRRD, x fastest, around the origin."""
    n = len(values)
    header = (f"NRRD0004\ntype: float\ndimension: 3\nsizes: {n} {n} {n}\nencoding: raw\n"
              f"endian: little\nspace dimension: 3\nspace origin: ({-n / 2 * width},"
              f"{-n / 2 * width},{-n / 2 * width})\nspace directions: ({width},0,0) (0,{width},0) "
              f"(0,0,{width})\n\n")
    path.write_bytes(header.encode() + values.astype("<f4").tobytes(order="F"))


class Field:
    def __init__(self, options, name, values, width, extinction):
        self.options, self.name, self.active = options, name, int(numpy.count_nonzero(values))
        self.path = options.out / (name.replace(" ", "-") + ".nrrd")
        write(self.path, values, width)
        self.extinction = extinction

    def draw(self, side, *more):
        return render(self.options, [
            self.path, "--look", "plain", "--luminance-grid", "image", "--extinction",
            self.extinction, "--resolution", f"{side}x{side}", *more], self.options.out / "p.exr")


CELLS, UNIFORM = ("--sampling", "cells"), ("--step", "1")


def print_curve(options, title, points):
    """points: name, and a function that draws."""
    print(f"\n| {title} | march, CPU ms | look-ups, M | M look-ups/s | chosen |\n|---|---|---|---|---|")
    reports = {name: [] for name, _ in points}
    for _ in range(options.rounds):
        for name, draw in points:
            reports[name].append(draw())
    for name, found in reports.items():
        work = statistics.median(report["times_ms"]["march_cpu"] for report in found)
        samples = found[0]["counts"]["samples"]
        method = found[0]["error"] and found[0]["error"].get("method", "")
        print(f"| {name} | {work:.0f} | {samples / 1e6:.3g} | {samples / work / 1e3:.1f} | "
              f"{method or ''} |", flush=True)


def both(fields):
    """Points of uniform steps and of cells: (name, field, side, options)."""
    return [(f"{name}, {how[1] if how is CELLS else 'uniform'}",
             lambda field=field, side=side, how=how, more=more: field.draw(side, *how, *more))
            for name, field, side, *more in fields for how in (CELLS, UNIFORM)]


def main():
    parser = parser_of(__doc__, "scaling")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    fogs = {n: Field(options, f"fog {n}^3", make_fog(n), 2 / n, FOG_EXTINCTION)
            for n in (64, 128, 256)}
    fog = fogs[256]
    # a ray through the full cube, of mean 1/2, has depth 3, whatever fraction is active
    blocks = {part: Field(options, f"blocks {100 * part:.0f} %", make_blocks(128, part), 1,
                          3 / 64) for part in (0.01, 0.03, 0.1, 0.3, 1)}
    print_curve(options, "fog 256^3, pixels",
                both([(f"{n}x{n}", fog, n) for n in (128, 256, 512, 1024)]))
    print_curve(options, "512x512, voxels", both([(f.name, f, 512) for f in fogs.values()]))
    print_curve(options, "noise in a part of the blocks of 128^3, 512x512",
                both([(f.name, f, 512) for f in blocks.values()]))
    print_curve(options, "fog 256^3, 512x512, extinction",
                both([(x, fog, 512, "--extinction", x) for x in (0.2, 2, 20, 200, 2000)]))
    print_curve(options, "fog 256^3, 512x512, tolerance",
                [(t, lambda t=t: fog.draw(512, "--tolerance", t))
                 for t in ("1e-1", "1e-2", "1e-3", "1e-4", "1e-5")])
    print("\n| | active voxels | atlas, MiB | bytes an active voxel |\n|---|---|---|---|")
    for field in [*fogs.values(), *blocks.values()]:
        size = field.draw(64, *CELLS)["bytes"]["atlas"]
        print(f"| {field.name} | {field.active} | {size / 2 ** 20:.2f} | {size / field.active:.1f} |")


if __name__ == "__main__":
    main()
