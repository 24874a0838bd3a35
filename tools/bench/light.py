#!/usr/bin/env python3
"""Measures what light costs and misses.

    tools/bench/light.py [--rounds 5] [--tolerances 1e-3,1e-4] [--peer]

Draws lit scenes of ../shared/data at 1280x720, in rounds: with the light that the tolerance chooses
and with exact light. Prints medians of processor time [ms] of the light and of the march, and what
the picture misses against one of tolerance 1e-5 in exact light. --peer draws smoke by vdb_render
with shadows too (Debian: libopenvdb-tools)."""

import os
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

from measure import ROOT, parser_of, render, rms

LIGHT = "0.5,-1,-0.6"
SCENES = {
    "smoke": ["smoke.vdb", "--extinction", "0.28"],
    "cloud thin": ["cloud_tiles.vdb", "--extinction", "0.028"],
    "cloud dense": ["cloud_tiles.vdb", "--extinction", "0.28"],
    "fog": ["edge/sphere.vdb", "--extinction", "20"],
}
SMOKE_VOXEL = 0.4761905  # of smoke.vdb [world units]


def psivox(options, arguments, picture):
    return render(options, [*arguments, "--light", LIGHT], picture)


def table(options):
    print("| scene, tolerance | exact light | light | march | light / march | RMS | light by |")
    print("|---|---|---|---|---|---|---|")
    for name, (file, *more) in SCENES.items():
        scene = [options.data / file, *more]
        truth = options.out / "truth.exr"
        psivox(options, [*scene, "--tolerance", "1e-5", "--light-quality", "exact"], truth)
        for tolerance in options.tolerances.split(","):
            times = {"auto": [], "exact": []}
            march = []
            picture = options.out / "auto.exr"
            for _ in range(options.rounds):
                for quality in times:
                    to = picture if quality == "auto" else options.out / "exact.exr"
                    report = psivox(options, [*scene, "--tolerance", tolerance,
                                              "--light-quality", quality], to)
                    times[quality].append(report["times_ms"]["light_cpu"])
                    if quality == "auto":
                        march.append(report["times_ms"]["march_cpu"])
                        method = report["error"]["light_method"]
            light, exact, marched = map(statistics.median, (times["auto"], times["exact"], march))
            print(f"| {name}, {tolerance} | {exact:.0f} | {light:.0f} | {marched:.0f} | "
                  f"{light / marched:.2f} | {rms(options, picture, truth):.1e} | {method} |",
                  flush=True)


def peer(options):
    """smoke in its default frame by both, processes as a whole."""
    smoke = [options.data / "smoke.vdb", "--extinction", "0.28", "--resolution", "512x512",
             "--camera-position", "35,75,125", "--camera-target", "-8,40,0", "--fov", "45"]
    truth = options.out / "truth.exr"
    psivox(options, [*smoke, "--tolerance", "1e-6", "--light-quality", "exact"], truth)
    sigma = 0.28 * SMOKE_VOXEL

    def timed(command, picture):
        seconds = []
        for _ in range(options.rounds if command[0] != "vdb_render" else 1):
            before = os.times()
            start = time.perf_counter()
            subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            after = os.times()
            seconds.append((time.perf_counter() - start, after.children_user + after.children_system
                            - before.children_user - before.children_system))
        wall, cpu = (statistics.median(column) for column in zip(*seconds))
        print(f"{wall:8.2f} s wall {cpu:8.2f} s processor  RMS {rms(options, picture, truth):.2e}  "
              + picture.stem, flush=True)

    for tolerance in ("1e-2", "1e-3", "1e-4"):
        picture = options.out / f"psivox_{tolerance}.exr"
        timed([options.psivox, "render", *smoke, "--light", LIGHT, "--tolerance", tolerance, "-q",
               "-o", picture], picture)
    for step in (4, 2, 1):
        picture = options.out / f"vdb_render_{step}.exr"
        timed(["vdb_render", smoke[0], picture, "-res", "512x512", "-fov", "45", "-translate",
               "35,75,125", "-lookat", "-8,40,0", "-up", "0,1,0", "-absorb", "0,0,0", "-scatter",
               f"{sigma},{sigma},{sigma}", "-light", "-0.5,1,0.6,1,1,1", "-gain", "0", "-cutoff",
               "0", "-step", step, "-shadowstep", step, "-compression", "none"], picture)


def main():
    parser = parser_of(__doc__, "light")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--tolerances", default="1e-3,1e-4")
    parser.add_argument("--peer", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    table(options)
    if options.peer:
        if not shutil.which("vdb_render"):
            sys.exit("vdb_render is not installed (Debian: libopenvdb-tools)")
        peer(options)


if __name__ == "__main__":
    main()
