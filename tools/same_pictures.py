#!/usr/bin/env python3
"""Compares the pictures of two builds of psivox bit for bit.

    tools/same_pictures.py OLD NEW      draws every scene of the list below with both and compares
    tools/same_pictures.py --list       prints the scenes

OLD and NEW are psivox programs (build/release/bin/psivox), or folders in which an earlier
    tools/same_pictures.py --draw PROGRAM FOLDER
left its pictures. --only TEXT selects scenes whose command line contains TEXT; --keep FOLDER keeps
the pictures in FOLDER/old and FOLDER/new; --data FOLDER holds the real files (default: ../shared/data
beside the repository); scenes whose file is missing are skipped, and the last line counts them.

It compares every channel of every layer, but no metadata. A refactoring must leave all pictures the
same on one machine; after a change of formulas this lists the scenes that it affects.
Exit code: 0 all are the same, 1 some differ or were not drawn, 2 usage.
"""

import argparse
import concurrent.futures
import hashlib
import os
import pathlib
import shlex
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
LAYERS = "--aov depth,transmittance,steps,samples"
ORTHO = "--projection orthographic"
FLAME = "--transfer-function assets/flame.json"
SHELLS = "--transfer-function assets/shells.json"
SURFACES = "--transfer-function assets/isosurfaces.json"
HEAT = "--temperature-grid temperature --temperature-scale 4000 --temperature-offset 1500"
GLOW = "--emission-grid temperature --emission-scale 0.5"
OTHER = "--and 'assets/blobs.vdb extinction=4 rotate=0,30,0 translate=0.5,0.2,0 emission-grid=temperature'"
COLOR = "--luminance-grid color"
INSIDE = "--camera-position 0.1,0.2,0.05 --camera-target 1,0.5,0.3"
ABOVE = "--camera-position 2,3,4 --camera-target 0,0,0"
LIGHT = "--light 1,-2,0.5,3,2,1"

# One scene a line: the file, then options of `psivox render`. DATA/ is the folder of real files.
SCENES = f"""
blobs {LAYERS}
blobs --mode back-to-front {COLOR} --aov transmittance,steps,samples
blobs --mode mip {LAYERS}
blobs --mode lmip --lmip-threshold 0.3 {LAYERS}
blobs --mode isosurface --isovalue 0.4 {LAYERS}
blobs --mode isosurface --isovalue 0.4 {FLAME} {LIGHT} {ABOVE}
blobs --mode xray {LAYERS}
blobs --mode mip --step 0.7 {FLAME} {LAYERS}
blobs --mode mip --sampling template {ORTHO} {LAYERS}
blobs --mode back-to-front --step 1.3 {GLOW} {COLOR}
blobs {COLOR} --integrator porter-duff --step 1.5
blobs {COLOR} --integrator midpoint --step 1.5 {LAYERS}
blobs {COLOR} --integrator midpoint {LAYERS}
blobs {COLOR} --integrator average
blobs {COLOR} --integrator linear-luminance
blobs {COLOR} --integrator opacity-linear --opacity-unit 2
blobs {COLOR} --integrator psi-weighted --step 2 {LAYERS}
blobs {COLOR} --integrator psi-balanced --step 2 {LAYERS}
blobs {COLOR} --integrator psi-balanced --step 2 --end-corrections=false
blobs {COLOR} --integrator psi-exact --segments 3
blobs {HEAT} --integrator psi-fit
blobs {HEAT} --integrator psi-table --segments 1
blobs {HEAT} --integrator linear-source --step 0.9
blobs {OTHER} {LAYERS}
blobs {OTHER} {GLOW} {COLOR} --tolerance 1e-3
blobs {OTHER} {GLOW} {LIGHT} --renderer march-double --resolution 32x24
blobs {COLOR} --integrator cell-exact {GLOW} {LAYERS}
blobs {COLOR} --integrator cell-exact --mode back-to-front
blobs {HEAT} --integrator cell-exact {LAYERS}
blobs {FLAME} --integrator preintegrated {LAYERS}
blobs {FLAME} --integrator preintegrated --step 1.5
blobs {FLAME} --integrator preintegrated-fast {LAYERS}
blobs {FLAME} --integrator preintegrated-fast --step 1.5
blobs {FLAME} --split-knots {LAYERS}
blobs {FLAME} --integrator cell-exact {LAYERS}
blobs {SHELLS} {LAYERS}
blobs {SHELLS} --split-knots --integrator psi-exact
blobs {SHELLS} --step 0.5 {ABOVE} {LAYERS}
blobs {SHELLS} {GLOW} --step 0.8 {LAYERS}
blobs {SHELLS} {GLOW} --integrator cell-exact
blobs {SURFACES} {LAYERS}
blobs {SURFACES} --segments 4 {GLOW}
blobs {SURFACES} --step 0.6 {LAYERS}
blobs {SURFACES} --sampling template {ORTHO} {ABOVE}
blobs {SURFACES} --filter hardware
blobs --colormap viridis --classification pre
blobs --colormap turbo --range 0.1,0.8 --integrator linear-luminance
blobs --colormap inferno --split-knots --resolution 32x24 {LAYERS}
blobs --mode isosurface --isovalue 0.5 --colormap inferno --split-knots {LAYERS}
blobs --look plain --sampling template {ORTHO} {LAYERS}
blobs --sampling template {ORTHO} {ABOVE} {FLAME} --connectivity 6 --integrator psi-exact
blobs --look plain --sampling template {ORTHO} {LIGHT} --connectivity 18
blobs {GLOW} {LAYERS}
blobs {GLOW} --extinction 0 --step 1
blobs {GLOW} {HEAT} --mode xray
blobs {COLOR} {GLOW} --step 0.75 --integrator midpoint {LAYERS}
blobs {COLOR} {GLOW} --step 0.005 --resolution 24x16 {LAYERS}
blobs {COLOR} --step 0.004 --resolution 24x16 {INSIDE} {LAYERS}
blobs {LIGHT} {LAYERS}
blobs {LIGHT} --phase-g 0.6 --albedo 0.8
blobs {LIGHT} {FLAME} --step 1
blobs {LIGHT} {SURFACES} --phase-g -0.3
blobs {LIGHT} {COLOR} --tolerance 1e-3
blobs --tolerance 1e-2 {COLOR} --aov error
blobs --tolerance 1e-3 {FLAME} --aov depth,error
blobs --tolerance 1e-4 {SHELLS}
blobs --tolerance 1e-5 {HEAT} {GLOW}
blobs --tolerance 1e-5 {SURFACES}
blobs --filter hardware {COLOR} {LAYERS}
blobs --filter hardware --step 0.7 {HEAT} {LAYERS}
blobs --look plain --filter hardware --sampling template {ORTHO}
blobs --texel code7 {COLOR} {GLOW} {LAYERS}
blobs --texel code16 --step 1 {LIGHT}
blobs {INSIDE} {COLOR} {LAYERS}
blobs {INSIDE} {COLOR} --step 1.2 {LAYERS}
blobs {INSIDE} {ORTHO} {HEAT} --integrator cell-exact
blobs --pixel-samples 4 {COLOR} {LAYERS}
blobs --background 0.1,0.2,0.3 --early-termination 0 --fov 30
blobs --integrator cell-exact {SHELLS} --renderer march-double --resolution 32x24 {LAYERS}
blobs {COLOR} {GLOW} --renderer march-double --resolution 32x24 {LAYERS}
blobs {LIGHT} {COLOR} --step 1.5 --renderer march-double --resolution 32x24 --pixel-samples 2
blobs {SURFACES} --sampling template {ORTHO} --renderer march-double --resolution 32x24
blobs --mode isosurface --renderer march-double --resolution 32x24 {LAYERS}
blobs --tolerance 1e-4 {FLAME} --renderer march-double --resolution 32x24
blobs {COLOR} --renderer reference --resolution 16x12
rotated --integrator cell-exact {LAYERS}
rotated --step 1 --camera-position 3,2,4 --camera-target 0,0,0 {LAYERS}
rotated --sampling template {ORTHO} {LIGHT}
ramp --extinction 200 --step 3 {LAYERS}
ramp --extinction 200 --integrator cell-exact --luminance 1,0.5,0.2
single_voxel --camera-position 0,0,5 --camera-target 0,0,0 {LAYERS}
slab --grid density_tiles {LAYERS}
slab --grid density_tiles --step 2 {LAYERS}
slab --grid density_tiles --integrator cell-exact --mode back-to-front
slab --grid density_tiles {FLAME} --step 1.5 {LAYERS}
tiles --step 1.7 {LAYERS}
tiles {COLOR.replace("color", "density")} --integrator cell-exact
tiles --colormap magma --tolerance 1e-3
DATA/cloud_tiles {LAYERS}
DATA/cloud_tiles --tolerance 1e-3 {LIGHT} --phase-g 0.7
DATA/cloud_tiles --step 2 --extinction 3
DATA/carotid --luminance-grid velocity --luminance-scale 0.01 --integrator cell-exact
DATA/neghip --colormap coolwarm --step 1
DATA/mri_t1 {SURFACES} --tolerance 1e-2
DATA/smoke --tolerance 1e-4 {LAYERS}
DATA/edge/levelset_sphere --mode isosurface {LIGHT}
"""


def scenes(only):
    lines = [line for line in SCENES.strip().splitlines() if only in line]
    return list(dict.fromkeys(lines))


def file_of(line, data):
    name = line.split()[0]
    return data / (name[5:] + ".vdb") if name.startswith("DATA/") else ROOT / "assets" / (name + ".vdb")


def draw(program, line, data, output):
    """Draws a scene. Returns None, or why there is no picture."""
    words = shlex.split(line)[1:]
    size = [] if "--resolution" in words else ["--resolution", "96x64"]
    environment = dict(os.environ, LP_NUM_THREADS="1")
    library = pathlib.Path(program).resolve().parent.parent / "src"
    if list(library.glob("libpsivox.*")):  # a build folder, whose library path may point elsewhere
        environment["LD_LIBRARY_PATH"] = str(library)
    command = [program, "render", file_of(line, data), "-q", *size, *words, "-o", output]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    return None if done.returncode == 0 else done.stderr.strip() or f"exit code {done.returncode}"


def attributes(exr):
    """The attributes of a single-part file's header, and the offset of its end."""
    at, found = 8, {}
    while exr[at]:
        end = exr.index(0, at)
        name = exr[at:end].decode()
        end = exr.index(0, end + 1)
        (size,) = struct.unpack_from("<i", exr, end + 1)
        found[name] = exr[end + 5:end + 5 + size]
        at = end + 5 + size
    return found, at + 1


def pixels(path):
    """The data that determines every channel's values: their names, types and the chunks' bytes."""
    exr = path.read_bytes()
    header, end = attributes(exr)
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    rows = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    chunks = []
    for at in struct.unpack_from(f"<{-(-(y1 - y0 + 1) // rows)}Q", exr, end):
        y, size = struct.unpack_from("<2i", exr, at)
        data = exr[at + 8:at + 8 + size]
        try:  # a chunk that zlib would not shorten is stored uncompressed
            data = zlib.decompress(data)
        except zlib.error:
            pass
        chunks.append((y, data))
    return header["channels"], (x0, y0, x1, y1), rows, chunks


def check(program, folder, line, data):
    """The picture of a scene in a folder, drawn now or by an earlier run."""
    path = folder / (hashlib.sha1(line.encode()).hexdigest()[:12] + ".exr")
    problem = draw(program, line, data, path) if program else None
    if problem is None and not path.exists():
        problem = "no picture"
    return path, problem


def compare(line, old, new, data):
    """'same', 'differs', 'skipped' or why a picture is missing."""
    if not file_of(line, data).exists():
        return "skipped"
    (a, old_problem), (b, new_problem) = (check(*side, line, data) for side in (old, new))
    if old_problem or new_problem:
        both = old_problem and new_problem
        return f"{'neither draws' if both else 'old fails' if old_problem else 'NEW FAILS'}: " + (
            new_problem or old_problem)
    return "same" if pixels(a) == pixels(b) else "DIFFERS"


def side_of(text, folder):
    """(program or None, folder of pictures)"""
    path = pathlib.Path(text)
    if path.is_dir():
        return None, path
    folder.mkdir(parents=True, exist_ok=True)
    return path.resolve(), folder


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", nargs="?")
    parser.add_argument("new", nargs="?")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--draw", nargs=2, metavar=("PROGRAM", "FOLDER"))
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--keep", metavar="FOLDER")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared" / "data")
    options = parser.parse_args()
    listed = scenes(options.only)
    if options.list:
        print("\n".join(listed))
        return 0
    pool = concurrent.futures.ThreadPoolExecutor(options.jobs)
    data = options.data.resolve()
    if options.draw:
        side = side_of(options.draw[0], pathlib.Path(options.draw[1]))
        jobs = [pool.submit(check, *side, line, data) for line in listed
                if file_of(line, data).exists()]
        problems = [problem for problem in (job.result()[1] for job in jobs) if problem]
        print("\n".join(problems + [f"{len(jobs) - len(problems)} pictures"]))
        return bool(problems)
    if not options.new:
        parser.print_usage(sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as temporary:
        base = pathlib.Path(options.keep or temporary).resolve()
        old, new = side_of(options.old, base / "old"), side_of(options.new, base / "new")
        jobs = [pool.submit(compare, line, old, new, data) for line in listed]
        results = [job.result() for job in jobs]
    for line, result in zip(listed, results):
        if result not in ("same", "skipped"):
            print(f"{result}\n    {line}")
    same, skipped = results.count("same"), results.count("skipped")
    print(f"{same} of {len(listed)} pictures are the same, {skipped} skipped")
    return same + skipped < len(listed)


if __name__ == "__main__":
    sys.exit(main())
