#!/usr/bin/env python3
"""Measures time against error for psivox and the installed peers, scene by scene, interleaved.

    tools/bench/compare_peers.py [--scenes A,B,smoke] [--rounds 5] [--size 512]

Builds the peers that it finds into build/peers, draws each scene by every method at several steps,
in rounds, and measures every picture against `psivox render --renderer reference`. For each scene
it prints the time at RMS 1e-2 to 1e-5, interpolated between the steps in logarithms. All numbers
are in build/peers/peers.csv. Scenes A and B need ../shared/peers, the others ../shared/data.
vdb_render, Blender's Cycles and VTK draw constant luminance, through the camera that `psivox study
--camera-for` prints; --study puts the peers' pictures and process times into a study of each scene."""

import argparse
import ctypes
import csv
import json
import math
import os
import re
import shlex
import shutil
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TARGETS = [1e-2, 1e-3, 1e-4, 1e-5]
TERMINATION = "1e-6"  # for all programs; smaller than any of the errors requires
TIMES = {
    "march_ms": "march in process",
    "march_cpu_ms": "march in process, processor time of all threads",
    "process_ms": "whole process",
    "process_cpu_ms": "whole process, processor time of all threads",
}
STEPS = [8, 4, 2, 1, 0.5, 0.25, 0.125]
FINE_STEPS = [0.0625, 0.03125]  # for the peer only: psivox has cells there

SMOKE = {"file": "smoke.vdb", "position": "35,75,125", "target": "-8,40,0", "fov": "45"}
CLOUD = {"file": "cloud_tiles.vdb", "position": "350,300,700", "target": "-11,71,-45", "fov": "40"}
FLAME = {"file": "heptane.vdb", "position": "470,345,760", "target": "150,150,150", "fov": "32"}
FOG = {"file": "scene.vdb", "position": "1.8,1.3,2.6", "target": "0,0,0", "fov": "35"}
# Luminance is `from` at density 0 and `to` at density 1, linear between.
SCENES = {
    "A": {**FOG, "extinction": 20, "from": "1,0.6,0.2", "to": "1,0.6,0.2"},
    "B": {**FOG, "extinction": 20, "from": "0.1,0.2,1", "to": "1,0.6,0.2"},
    "smoke": {**SMOKE, "extinction": 0.28, "from": "0,0,0", "to": "1,0.6,0.2"},
    "smoke dense": {**SMOKE, "extinction": 2.8, "from": "0,0,0", "to": "1,0.6,0.2"},
    "cloud": {**CLOUD, "extinction": 0.028, "from": "0,0,0", "to": "1,0.6,0.2"},
    "heptane": {**FLAME, "extinction": 0.15, "from": "0,0,0", "to": "1,0.6,0.2"},
    "cloud dense": {**CLOUD, "extinction": 0.28, "from": "0,0,0", "to": "1,0.6,0.2"},
}


def say(text):
    print(text, file=sys.stderr, flush=True)


def adopt_orphans():
    """From now on processes that a command leaves behind, as psivox's readers, are this one's."""
    pr_set_child_subreaper = 36
    ctypes.CDLL(None).prctl(pr_set_child_subreaper, 1, 0, 0, 0)


def cpu_of_orphans():
    """Waits for them. Their seconds."""
    seconds = 0
    while True:
        try:
            usage = os.wait3(0)[2]
        except ChildProcessError:
            return seconds
        seconds += usage.ru_utime + usage.ru_stime


def run(command):
    """Output, milliseconds and CPU milliseconds of a command; None if it fails."""
    start = time.perf_counter()
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    output, errors = process.stdout.read(), process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    wall = 1e3 * (time.perf_counter() - start)
    cpu = usage.ru_utime + usage.ru_stime + cpu_of_orphans()
    if process.returncode:
        say(f"failed: {' '.join(map(str, command))}\n{errors.strip()}")
        return None
    return output, wall, 1e3 * cpu


def timed(command):
    """Milliseconds of the march that a command prints, wall and CPU, and its own; None if it fails."""
    done = run(command)
    if not done:
        return None
    times = json.loads(done[0])
    return times["march_ms"], times["march_cpu_ms"], done[1], done[2]


class Bench:
    def __init__(self, options):
        self.options = options
        self.out = options.out
        self.out.mkdir(parents=True, exist_ok=True)
        self.psivox = options.psivox

    def build(self, source, *flags):
        """The program of a source file, built if older; None, with a message, if that fails."""
        program = self.out / source.stem
        if not source.exists():
            say(f"skipped: {source.stem}: no {source}")
            return None
        if program.exists() and program.stat().st_mtime > source.stat().st_mtime:
            return program
        say(f"building {source.stem}")
        built = run(["g++", "-O3", "-DNDEBUG", "-march=native", "-std=c++20", source, "-o", program,
                     *flags, "-lopenvdb", "-ltbb"])
        return program if built else None

    def find_peers(self):
        """Builds the peers and makes scenes A and B; prints what is missing."""
        mkscene = self.build(self.options.peers / "mkscene.cpp")
        if mkscene and not (self.out / "scene.vdb").exists():
            run([mkscene, self.out / "scene"])
            (self.out / "scene.raw").unlink(missing_ok=True)
        self.nanovdb = None
        if Path("/usr/include/nanovdb/util/HDDA.h").exists():
            library = self.psivox.parents[1] / "src"
            self.nanovdb = self.build(ROOT / "tools/bench/nanovdb_march.cpp", "-ffast-math",
                                      f"-I{ROOT}/include", f"-I{ROOT}/src", f"-L{library}",
                                      "-lpsivox", f"-Wl,-rpath,{library}")
        else:
            say("skipped: NanoVDB: install libnanovdb-dev")
        xvfb, python = shutil.which("xvfb-run"), shutil.which("python3", path="/usr/bin")
        has_vtk = xvfb and run([python, "-c", "import vtk, pyopenvdb, OpenImageIO"])
        # method: camera's format, command before the camera's file, packages; all take steps
        peers = {"vdb_render": (shutil.which("vdb_render"), "libopenvdb-tools"),
                 "cycles": (shutil.which("blender"), "blender"),
                 "vtk": (has_vtk, "python3-vtk9 python3-openvdb python3-openimageio xvfb")}
        self.foreign = [name for name, (found, _) in peers.items() if found]
        for name, (found, packages) in peers.items():
            if not found:
                say(f"skipped: {name}: install {packages}")
        self.commands = {"cycles": ["blender", "-b", "--factory-startup", "-P",
                                    ROOT / "tools/bench/draw_in_cycles.py", "--"],
                         "vtk": [xvfb, "-a", python, ROOT / "tools/bench/draw_in_vtk.py"]}

    def file(self, scene):
        folder = self.out if scene["file"] == "scene.vdb" else self.options.data
        return folder / scene["file"]

    def scene_options(self, scene):
        command = [self.file(scene), "-q", "--look", "plain",
                   "--resolution", f"{self.options.size}x{self.options.size}",
                   f"--camera-position={scene['position']}", f"--camera-target={scene['target']}",
                   "--fov", scene["fov"], "--extinction", scene["extinction"],
                   "--early-termination", TERMINATION, "--luminance", scene["to"]]
        if scene["from"] == "0,0,0":
            return command + ["--luminance-grid", "density"]
        if scene["from"] == scene["to"]:
            return command
        ends = [{"value": v, "attenuation": v, "color": [float(x) for x in scene[end].split(",")]}
                for v, end in ((0, "from"), (1, "to"))]
        function = self.out / "transfer.json"
        function.write_text(json.dumps({"points": ends}))
        return command[:-2] + ["--transfer-function", function]

    def picture(self, name, method, parameter):
        return self.out / f"{name}-{method}-{parameter}.exr".replace(" ", "-")

    def psivox_command(self, scene, picture):
        return [self.psivox, "render", *self.scene_options(scene), "-o", picture]

    def psivox_method(self, *extra):
        def draw(scene, picture):
            done = run(self.psivox_command(scene, picture) + ["--stats", "-", *extra])
            if not done:
                return None
            times = json.loads(done[0])["times_ms"]
            return times["march"], times["march_cpu"], done[1], done[2]
        return draw

    def nanovdb_method(self, step):
        def draw(scene, picture):
            words = [f"{key}={scene[key]}" for key in ("extinction", "from", "to", "position",
                                                       "target", "fov")]
            return timed([self.nanovdb, self.file(scene), picture, f"step={step}",
                          f"size={self.options.size}", f"termination={TERMINATION}", *words])
        return draw

    def foreign_method(self, name, step):
        """Draws through the camera that psivox prints; the step is in voxels."""
        formats = {"cycles": "blender", "vtk": "paraview"}

        def draw(scene, picture):
            lines = run([self.psivox, "study", *self.scene_options(scene), "--camera-for",
                         formats.get(name, name)])[0]
            if name == "vdb_render":
                words = [str(picture) if word == "picture.exr" else word for word in shlex.split(lines)]
                done = run([*words, "-step", step, "-compression", "none"])
            else:
                camera = self.out / f"camera-{name}"
                camera.write_text(lines)
                world_step = step * self.voxel(scene)
                done = run([*self.commands[name], camera, self.file(scene), scene["extinction"],
                            scene["to"], world_step, picture])
            return (math.nan, math.nan, done[1], done[2]) if done else None
        return draw

    def voxel(self, scene):
        grids = json.loads(run([self.psivox, "info", self.file(scene), "--json"])[0])["grids"]
        return next(g["voxel_size"][0] for g in grids if g["name"] == "density")

    def study(self, name, rows):
        """Writes a study of the scene with the peers' pictures, and the list that it reads."""
        peers = [{"name": f"{row['method']} step {row['step']}", "picture": self.picture(name, row["method"], row["step"]).name,
                  "time_ms": row["process_ms"]}
                 for row in rows if not row["method"].startswith("psivox")]
        (self.out / f"peers-{name}.json").write_text(json.dumps(peers, indent=1))
        folder = self.out / f"study-{name}"
        shutil.rmtree(folder, ignore_errors=True)
        run([self.psivox, "study", *self.scene_options(SCENES[name]), "--no-split", "-o", folder,
             "--integrators", "porter-duff,midpoint,psi-balanced,psi-weighted,cell-exact",
             "--peers", self.out / f"peers-{name}.json"])
        say(f"scene {name}: {folder}/index.html")

    def methods(self, name):
        """(method, parameter, draw) for a scene."""
        result = []
        if self.nanovdb:
            result += [("NanoVDB loop", step, self.nanovdb_method(step)) for step in STEPS + FINE_STEPS]
        if SCENES[name]["from"] == SCENES[name]["to"]:
            result += [(peer, step, self.foreign_method(peer, step))
                       for peer in self.foreign for step in (4, 2, 1, 0.5, 0.25)]
        for rule in ("midpoint", "porter-duff", "psi-balanced"):
            result += [(f"psivox {rule}", step,
                        self.psivox_method("--integrator", rule, "--step", step))
                       for step in STEPS]
        for rule in ("psi-weighted", "cell-exact"):
            result.append((f"psivox {rule}, cells", "cells",
                           self.psivox_method("--sampling", "cells", "--integrator", rule)))
        for option in (("--filter", "hardware"), ("--texel", "code12")):
            result += [(f"psivox psi-balanced, {option[1]}", 1, self.psivox_method(
                "--integrator", "psi-balanced", "--step", 1, *option)),
                       (f"psivox psi-weighted, cells, {option[1]}", "cells", self.psivox_method(
                           "--sampling", "cells", "--integrator", "psi-weighted", *option))]
        if "--tolerance" in run([self.psivox, "render", "--help"])[0]:
            result += [("psivox --tolerance", target,
                        self.psivox_method("--tolerance", target)) for target in TARGETS]
        return result

    def rms(self, picture, reference):
        """RMS over R, G and B only: programs define alpha differently."""
        done = run([self.psivox, "compare", picture, reference])
        channels = re.search(r"\(R (\S+)  G (\S+)  B (\S+)  A", done[0]).groups()
        return math.sqrt(sum(float(c) ** 2 for c in channels) / 3)

    def measure(self, name):
        """Rows of the CSV."""
        scene = SCENES[name]
        if not self.file(scene).exists():
            say(f"skipped: scene {name}: no {self.file(scene)}")
            return []
        key = f"{name.replace(' ', '-')}-{self.options.size}"
        reference = self.out / f"reference-{key}.exr"
        if not reference.exists():
            say(f"scene {name}: the reference")
            run(self.psivox_command(scene, reference) + ["--renderer", "reference"])
        methods, times, errors = self.methods(name), defaultdict(list), {}
        for turn in range(self.options.rounds):
            say(f"scene {name}: round {turn + 1} of {self.options.rounds}")
            for method, parameter, draw in methods:
                picture = self.picture(name, method, parameter)
                took = draw(scene, picture)
                if not took:
                    continue
                times[method, parameter].append(took)
                if (method, parameter) not in errors:
                    errors[method, parameter] = self.rms(picture, reference)
        return [{"scene": name, "method": method, "step": parameter, "rms": errors[method, parameter],
                 **{what: statistics.median(column) for what, column in zip(TIMES, zip(*taken))},
                 "rounds": len(taken)}
                for (method, parameter), taken in times.items()]


def time_at(rows, target, what):
    """Least time for an error of at most `target`, over the points and over the lines between
    neighbouring steps, on which log time is linear in log error."""
    points = [(row["rms"], row[what]) for row in rows if not math.isnan(row[what])]
    found = [t for rms, t in points if rms <= target]
    for (a, s), (b, t) in zip(points, points[1:]):
        if min(a, b) <= target < max(a, b) and min(a, b) > 0:
            part = math.log(target / a) / math.log(b / a)
            found.append(math.exp((1 - part) * math.log(s) + part * math.log(t)))
    return min(found, default=math.nan)


def print_table(name, rows, what, digits=0):
    print(f"\nscene {name}, {TIMES[what]} [ms] at RMS\n")
    print("| method | " + " | ".join(f"{target:.0e}" for target in TARGETS) + " |")
    print("|---" * (len(TARGETS) + 1) + "|")
    methods = list(dict.fromkeys(row["method"] for row in rows))
    for method in methods:
        own = [row for row in rows if row["method"] == method]
        cells = [time_at(own, target, what) for target in TARGETS]
        if all(math.isnan(row[what]) for row in own):
            continue
        print(f"| {method} | " + " | ".join("–" if math.isnan(t) else f"{t:.{digits}f}" for t in cells)
              + " |")


def main():
    adopt_orphans()
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default=",".join(SCENES), help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=int, default=512, help="pixels on a side")
    parser.add_argument("--psivox", type=Path, default=ROOT / "build/release/bin/psivox")
    parser.add_argument("--peers", type=Path, default=ROOT.parent / "shared/peers")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--out", type=Path, default=ROOT / "build/peers")
    parser.add_argument("--study", action="store_true", help="also write a study of each scene")
    parser.add_argument("--times", default="march_ms,process_ms",
                        help="columns to print, march_cpu_ms and process_cpu_ms on a busy machine; "
                        "default: %(default)s")
    options = parser.parse_args()
    names = options.scenes.split(",")
    for name in names:
        if name not in SCENES:
            parser.error(f"no scene '{name}'; there are {', '.join(SCENES)}")
    for what in options.times.split(","):
        if what not in TIMES:
            parser.error(f"no time '{what}'; there are {', '.join(TIMES)}")
    if not options.psivox.exists():
        parser.error(f"no {options.psivox}: build it, or give --psivox")

    bench = Bench(options)
    bench.find_peers()
    rows = []
    for name in names:
        own = bench.measure(name)
        rows += own
        with open(options.out / "peers.csv", "w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, ["scene", "method", "step", "rms", *TIMES, "rounds"])
            table.writeheader()
            table.writerows(rows)
        for what in options.times.split(",") if own else ():
            print_table(name, own, what)
        if options.study and own:
            bench.study(name, own)
        sys.stdout.flush()


if __name__ == "__main__":
    main()
