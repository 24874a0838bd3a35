#!/usr/bin/env python3
"""Counts how busy the lanes of a GPU are, without one.

    tools/bench/lanes.py [SCENE.json ...]      default: some of tools/bench/scenes

A warp of 32 rays takes as long as its longest ray. This prints, for pictures of 1024x1024, the mean
of a ray's look-ups over the mean of each warp's most, for warps of 8x4, 4x8, 32x1 pixels and of rays
in the order of their look-ups; then the same for the whole GPU: the work over the time until the
last of 132 multiprocessors is done, with 32 warps on each at a time, in the order of rows. Turns
that only pass an empty brick read nothing and are not counted.
Needs the Python package: PYTHONPATH=build/release/python, in the folder of the sources.
"""

import heapq
import json
import pathlib
import sys

import numpy as np
import psivox

SCENES = pathlib.Path(__file__).resolve().parent / "scenes"
NAMES = ["smoke-dense", "smoke-dense-inside", "cloud-thin", "fog-a"]
SIDE, WARP, SLOTS = 1024, 32, 132 * 32


def warps(turns, width, height):
    """The rays of each warp, shape (warps, 32)."""
    tiles = turns.reshape(SIDE // height, height, SIDE // width, width)
    return tiles.transpose(0, 2, 1, 3).reshape(-1, WARP)


def busy_lanes(of_warps):
    return of_warps.mean() / of_warps.max(axis=1).mean()


def busy_slots(of_warps):
    """Each slot takes the next warp when it is done."""
    longest = of_warps.max(axis=1)
    free_at = [0.0] * SLOTS
    for turns in longest:
        heapq.heapreplace(free_at, free_at[0] + turns)
    return longest.sum() / SLOTS / max(free_at)


def main():
    files = [pathlib.Path(name) for name in sys.argv[1:]] or [SCENES / f"{n}.json" for n in NAMES]
    print("| scene | tolerance | look-ups | 8x4 | 4x8 | 32x1 | sorted | multiprocessors |")
    print("|---|---|---|---|---|---|---|---|")
    for file in files:
        words = {key.replace("-", "_"): value for key, value in json.loads(file.read_text()).items()}
        volume = words.pop("input")
        for tolerance in (1e-2, 1e-3, 1e-5):
            image = psivox.render(volume, **words, resolution=(SIDE, SIDE), tolerance=tolerance,
                                  aov=["samples"])
            turns = np.asarray(image["samples"], float)
            shapes = [warps(turns, *size) for size in ((8, 4), (4, 8), (32, 1))]
            shapes.append(np.sort(turns, axis=None)[::-1].reshape(-1, WARP))
            columns = [f"{busy_lanes(shape):.2f}" for shape in shapes]
            print(f"| {file.stem} | {tolerance:g} | {turns.mean():.0f} | {' | '.join(columns)} | "
                  f"{busy_slots(shapes[0]):.2f} |", flush=True)


if __name__ == "__main__":
    main()
