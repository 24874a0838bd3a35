#!/usr/bin/env python3
"""Races psivox and a NanoVDB loop on a GPU: time against error, scene by scene.

    tools/bench/compare_gpu.py [--scenes A,B,smoke,cloud] [--size 1024] [--repeats 7]

Draws the scenes of compare_peers.py by a study, which takes the GPU's own times, and by
nanovdb_march.cu at steps of 8 to 1/32 voxels. For each scene it prints the GPU's time at RMS 1e-2
to 1e-5, interpolated between the steps in logarithms. The volumes that the loop marches are written
by `nanovdb_march FILE.vdb FILE.nvdb`; what is missing and can be built here is built, so that a
machine with the GPU alone needs build/peers of another one. Without nvcc psivox is drawn alone."""

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import compare_peers
from compare_peers import FINE_STEPS, ROOT, SCENES, STEPS, TARGETS, Bench, run, say

RULES = "midpoint,porter-duff,psi-balanced,cell-exact"


def build_cuda(bench):
    """The loop on CUDA, built if it is not there; None without nvcc."""
    program, library = bench.out / "nanovdb_march_cuda", bench.psivox.parents[1] / "src"
    if not program.exists() and not shutil.which("nvcc"):
        say("skipped: the loop: no nvcc")
        return None
    if not program.exists():
        run(["nvcc", "-std=c++20", "-O3", "-DNDEBUG", "--use_fast_math", "-arch=native",
             f"-I{ROOT}/include", f"-I{ROOT}/src", ROOT / "tools/bench/nanovdb_march.cu", "-o",
             program, f"-L{library}", "-lpsivox", "-Xlinker", f"-rpath={library}"])
    return program


def psivox_rows(bench, scene, folder):
    """Rows of the study: method, step or tolerance, RMS of radiance, the GPU's ms."""
    command = [bench.psivox, "study", *bench.scene_options(scene), "-o", folder, "--no-split",
               "--integrators", RULES, "--segments", 1, "--steps", ",".join(map(str, STEPS)),
               "--tolerances", ",".join(map(str, TARGETS)), "--repeats", bench.options.repeats]
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([str(word) for word in command], check=True)
    rows = []
    for row in csv.DictReader((folder / "results.csv").open()):
        by_tolerance = float(row["tolerance"]) > 0
        name = ("--tolerance" if by_tolerance else
                row["integrator"] + ("" if float(row["step"]) else ", cells"))
        rows.append({"method": f"psivox {name}", "rms": float(row["radiance_rms"]),
                     "march_gpu_ms": float(row["gpu_ms_median"]), "texel": row["texel"],
                     "step": row["tolerance"] if by_tolerance else row["step"] or "cells"})
    return rows


def nanovdb_rows(bench, program, scene, reference):
    grid = (bench.out / scene["file"]).with_suffix(".nvdb")
    if not grid.exists():
        if not (bench.out / "nanovdb_march").exists():
            say(f"skipped: the loop: no {grid}; compare_peers.py builds what writes it")
            return []
        run([bench.out / "nanovdb_march", bench.file(scene), grid])
    rows = []
    for step in STEPS + FINE_STEPS:
        picture = bench.out / "nanovdb-cuda.exr"
        words = [f"{key}={scene[key]}" for key in ("extinction", "from", "to", "position", "target",
                                                   "fov")]
        done = run([program, grid, picture, f"step={step}", f"size={bench.options.size}",
                    f"termination={compare_peers.TERMINATION}", *words])
        if done:
            rows.append({"method": "NanoVDB loop, CUDA", "rms": bench.rms(picture, reference),
                         "march_gpu_ms": json.loads(done[0])["march_ms"], "step": step})
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="A,B,smoke,cloud")
    parser.add_argument("--size", type=int, default=1024, help="pixels on a side")
    parser.add_argument("--repeats", type=int, default=7, help="draws of which the median counts")
    parser.add_argument("--psivox", type=Path, default=ROOT / "build/release/bin/psivox")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--out", type=Path, default=ROOT / "build/peers")
    options = parser.parse_args()
    bench = Bench(options)
    program = build_cuda(bench)
    compare_peers.TIMES["march_gpu_ms"] = "march, the GPU's time"
    rows = []
    for name in options.scenes.split(","):
        folder = options.out / f"gpu-{name}"
        say(f"scene {name}")
        own = psivox_rows(bench, SCENES[name], folder)
        if program:
            own += nanovdb_rows(bench, program, SCENES[name], folder / "reference.exr")
        rows += [{"scene": name, **row} for row in own]
        compare_peers.print_table(name, own, "march_gpu_ms", digits=2)
        sys.stdout.flush()
    (options.out / "gpu.json").write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
