#!/usr/bin/env python3
"""Measures what a sequence saves against a loop of single renders.

    tools/bench/sequence.py [--frames 100] [--sizes 64,128,192] [--rounds 1] [--peer]

Makes plumes of smoke (make_assets --plume), and draws each at 512x512 by one `psivox render` and by
one for each frame, in turns. Prints frames a minute, their ratio, and how long the drawing thread
waited for reading and writing. --peer draws three frames by vdb_render with shadows too (Debian:
libopenvdb-tools)."""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def seconds(*commands):
    start = time.monotonic()
    for command in commands:
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
    return time.monotonic() - start


def cpu_seconds():
    times = os.times()
    return times.children_user + times.children_system


def measure(options, folder, files, look):
    scene = ["--resolution", "512x512", "-q", "--look", look]
    stats = folder / "stats.json"
    whole = [options.psivox, "render", folder / "plume.####.vdb", "-o", folder / "s.####.png",
             "--stats", stats, *scene]
    singles = [[options.psivox, "render", file, "-o", folder / "one.png", *scene] for file in files]
    rates = {"sequence": [], "loop": []}
    cpu = {"sequence": [], "loop": []}
    waited = []
    for _ in range(options.rounds):
        for name, commands in (("sequence", [whole]), ("loop", singles)):
            before = cpu_seconds()
            rates[name].append(60 * len(files) / seconds(*commands))
            cpu[name].append((cpu_seconds() - before) / len(files))
        took = json.loads(stats.read_text())["times_ms"]
        waited.append(took["waited"] / took["total"])
    one, many = (statistics.median(rates[name]) for name in ("loop", "sequence"))
    c_one, c_many = (statistics.median(cpu[name]) for name in ("loop", "sequence"))
    return (f"{many:.0f} | {one:.0f} | {many / one:.2f} | {c_many:.3f} | {c_one:.3f} | "
            f"{100 * statistics.median(waited):.0f} %")


def peer(options, folder, files):
    if not (options.peer and shutil.which("vdb_render")):
        return "-"
    took = [seconds(["vdb_render", file, folder / "peer.exr", "-res", "512x512", "-translate",
                     "0.5,1,3.3", "-lookat", "0.5,1,0.5"]) for file in files[:: len(files) // 3][:3]]
    return f"{60 / statistics.median(took):.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--psivox", type=Path, default=ROOT / "build/release/bin/psivox")
    parser.add_argument("--make-assets", type=Path, default=ROOT / "build/release/tools/make_assets")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--sizes", default="64,128,192")
    parser.add_argument("--looks", default="auto,plain")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--peer", action="store_true")
    options = parser.parse_args()
    print("| voxels high, look | sequence [frames/min] | loop | ratio | sequence [processor s/frame] "
          "| loop | waited | vdb_render's loop [frames/min] |\n|---|---|---|---|---|---|---|---|")
    for size in options.sizes.split(","):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            seconds([options.make_assets, "--plume", folder, options.frames, size])
            files = sorted(folder.glob("*.vdb"))
            other = peer(options, folder, files)
            for look in options.looks.split(","):
                print(f"| {size}, {look} | {measure(options, folder, files, look)} | {other} |",
                      flush=True)


if __name__ == "__main__":
    main()
