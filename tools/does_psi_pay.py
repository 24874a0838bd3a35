#!/usr/bin/env python3
"""Runs the studies of docs/does-psi-pay.md into DIR, and prints the page's tables.

  does_psi_pay.py DIR [PSIVOX [FOLDER of .vdb files]]

A second run keeps finished studies.
"""
import json
import math
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SMOOTH = "--luminance-grid density".split()
# name: centre and width of the view from outside; point and width of that from inside; options
VOLUMES = {
    "smoke": ((-7.4, 40.5, 0.5), 90, (-7.4, 40.5, 0.5), 25, SMOOTH),
    "cloud_tiles": ((-11.7, 71.7, -45), 480, (60, 95, 30), 120, [*SMOOTH, "--extinction", "0.28"]),
    "heptane": ((163, 150.5, 150.5), 330, (163, 150.5, 150.5), 120,
                ["--transfer-function", ROOT / "assets/flame.json"]),
    "mri_t1": ((61.5, 80.5, 68), 190, (61.5, 80.5, 68), 60, SMOOTH),
}
# Rays are parallel, so that templates can be drawn too; oblique, so that no lattice beats with the
# voxels'; and end at 1e-6 of the light.
SWEEP = """--resume -q --no-split --integrators all --samplings all --segments 1,4,16
  --steps 4,2,1,0.5,0.25,0.125,0.0625,0.03125 --tolerances 1e-2,1e-3,1e-4,1e-5
  --early-termination 1e-6 --projection orthographic --resolution 128x128""".split()
ERRORS = (1e-2, 1e-3, 1e-4, 1e-5)


def along(point, n):
    return ",".join(f"{a + n * b:.9g}" for a, b in zip(point, (30, 17, 33)))


def study(psivox, data, out, name, view):
    centre, width, inside, inside_width, options = VOLUMES[name]
    camera = (along(centre, 30), along(centre, 0), width) if view == "outside" else \
        (along(inside, 0), along(inside, -1), inside_width)
    folder = out / f"{view}-{name}"
    if not (folder / "index.html").exists():
        subprocess.run([psivox, "study", data / f"{name}.vdb", "-o", folder, *SWEEP, *options,
                        "--camera-position", camera[0], "--camera-target", camera[1],
                        "--ortho-width", str(camera[2])], check=True)
    return json.loads((folder / "results.json").read_text())["points"]


def curves_of(points):
    """Points of one rule under one sampling, from coarse to fine, with their costs."""
    curves = {}
    for p in sorted(points, key=lambda p: (-p.get("step", 0), p.get("segments", 0),
                                           -p.get("tolerance", 0))):
        name = "chosen by tolerance" if "tolerance" in p else f"{p['integrator']}, {p['sampling']}"
        time = statistics.median(t["cpu"] for t in p["times_ms"])
        curves.setdefault(name, []).append((p["error"]["rms"], p["samples_per_ray"], time))
    return curves


def need(curve, rms, cost):
    """The cost at an RMS, linear in the logarithms between points, and whether it is less."""
    fine = next((i for i, p in enumerate(curve) if p[0] <= rms), None)
    if fine is None:
        return None, False
    (error, b), a = (curve[fine][0], curve[fine][cost]), curve[fine - 1]
    if fine == 0 or error <= 0:
        return b, fine == 0
    u = math.log(rms / a[0]) / math.log(error / a[0])
    return a[cost] * (b / a[cost]) ** u, False


def cell(curve, cost, unit):
    texts = []
    for rms in ERRORS:
        amount, at_most = need(curve, rms, cost)
        texts.append("–" if amount is None else
                     f"{'≤' * at_most}{amount / unit:.{0 if cost == 1 else 2}f}")
    return " / ".join(texts)


def main(out, psivox=ROOT / "build/release/bin/psivox", data=ROOT.parent / "shared/data"):
    for view in ("outside", "inside"):
        studies = {name: curves_of(study(psivox, data, out, name, view)) for name in VOLUMES}
        rules = dict.fromkeys(rule for curves in studies.values() for rule in curves)
        for cost, title in ((1, "look-ups a ray"), (2, "processor time")):
            print(f"\n**{title}, from {view}**\n\n| rule |", *(f"{name} |" for name in studies))
            print("|---" * (len(studies) + 1) + "|")
            for rule in rules:
                print(f"| {rule} |", *(
                    cell(curves[rule], cost, 1 if cost == 1 else
                         need(curves["midpoint, uniform"], 1e-3, 2)[0]) + " |"
                    if rule in curves else "– |" for curves in studies.values()))


if __name__ == "__main__":
    main(*(pathlib.Path(word).resolve() for word in sys.argv[1:]))
