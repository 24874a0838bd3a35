#!/usr/bin/env python3
"""Measures pictures drawn to a tolerance.

    tools/bench/tolerance.py [--side 256] [--rounds 3] tools/bench/scenes/*.json

For each scene and tolerance it prints the method chosen, the error reached, and look-ups and
processor time of the best uniform rule and step that meet the tolerance, relative to these. That
step is found by drawing: it halves 8 repeatedly, then searches between the two steps that enclose
the tolerance. Times are medians of rounds in which all pictures take turns. It needs numpy and the
Python package (build/release/python)."""

import json
import math
import statistics
import sys
from pathlib import Path

import numpy

from measure import ROOT, parser_of, render

sys.path.insert(0, str(ROOT / "build/release/python"))
import psivox  # noqa: E402

TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-5]
EXACT = {"sampling": "cells", "integrator": "cell-exact"}
RULES = ("psi-balanced", "midpoint", "porter-duff")


class Drawn:
    """A picture by one method: its errors, look-ups a ray, and processor times of the march."""

    def __init__(self, scene, **how):
        self.scene, self.how, self.times = scene, how, []
        self.report = self.draw()
        off = numpy.abs(scene.pixels(**how) - scene.truth)
        self.rms, self.max = math.sqrt(numpy.mean(off ** 2)), off.max()
        # the error that 99.9 % of the pixels stay within, by their worst channels
        worst = numpy.sort(off.max(-1), None)
        self.tail = worst[math.ceil(0.999 * worst.size) - 1]
        self.samples = self.report["counts"]["samples_per_ray"]

    def draw(self):
        return self.scene.draw(**self.how)

    def time(self):
        self.times.append(self.draw()["times_ms"]["march_cpu"])

    @property
    def ms(self):
        return statistics.median(self.times)


class Scene:
    def __init__(self, options, file):
        self.options, self.file = options, file
        self.session = psivox.Session(json.loads(Path(file).read_text())["input"], scene=file,
                                      look="plain", resolution=(options.side, options.side))
        self.truth = self.pixels(renderer="march-double", early_termination=0, **EXACT)

    def draw(self, **how):
        side = self.options.side
        words = [f"--{name}={value}" for name, value in how.items()]
        return render(self.options, ["--scene", self.file, "--look", "plain", "--resolution",
                                     f"{side}x{side}", *words], self.options.out / "picture.exr")

    def pixels(self, **how):
        return numpy.asarray(self.session.render(**how)).astype("f8")

    def uniform(self, rule, step):
        return Drawn(self, integrator=rule, step=step)

    def curve(self, rule):
        """One uniform rule, from wide steps to narrow ones: (step, Drawn)."""
        points, step = [], 8.0
        while step > 0.03 and not (points and points[-1][1].rms < 5e-6):
            points.append((step, self.uniform(rule, step)))
            step /= 2
        # the error need not grow with the step, so the widest step is found by drawing
        for tolerance in TOLERANCES:
            for _ in range(3):
                fine = next((i for i, (_, p) in enumerate(points) if p.rms <= tolerance), 0)
                if fine == 0:
                    break
                (wide, coarse), (narrow, good) = points[fine - 1], points[fine]
                part = math.log(good.rms / tolerance) / math.log(good.rms / coarse.rms)
                if part < 0.05:
                    break
                step = narrow * (wide / narrow) ** (0.97 * part)
                points.insert(fine, (step, self.uniform(rule, step)))
        return points


def ratio(curves, error, tail, cost, own):
    """Least cost of the rules for an error and a tail over `own`; if no point meets both, that of
    the narrowest step, behind a >."""
    met = [cost(p) for curve in curves for _, p in curve if p.rms <= error and p.tail <= tail]
    narrowest = [cost(curve[-1][1]) for curve in curves]
    return f"{'' if met else '>'}{min(met or narrowest) / own:.2f}"


def measure(options, file):
    scene = Scene(options, file)
    curves = [scene.curve(rule) for rule in RULES]
    asked = [Drawn(scene, tolerance=tolerance) for tolerance in TOLERANCES]
    exact = Drawn(scene, **EXACT)
    every = [p for curve in curves for _, p in curve] + asked + [exact]
    for _ in range(options.rounds):
        for drawn in every:
            drawn.time()
    print(f"{Path(file).stem}: cell-exact {exact.samples:.1f} look-ups, {exact.ms:.0f} ms")
    for rule, curve in zip(RULES, curves):
        print(f"  {rule:14}", *(f"{step:.3g}: {p.rms:.1e}/{p.samples:.1f}/{p.ms:.0f}"
                                for step, p in curve))
    for tolerance, a in zip(TOLERANCES, asked):
        choice, ratios = a.report["error"], []
        for tail in (math.inf, max(a.tail, 5 * tolerance)):
            ratios.append(ratio(curves, tolerance, tail, lambda p: p.samples, a.samples) + " " +
                          ratio(curves, tolerance, tail, lambda p: p.ms, a.ms))
        print(f"  E {tolerance:.0e}  {choice['method']:34} rms/E {a.rms / tolerance:.3f} "
              f"(est {choice['estimated_rms'] / tolerance:.3f}) p99.9/E {a.tail / tolerance:.1f} "
              f"max/E {a.max / tolerance:.1f}  look-ups {a.samples:.1f} ms {a.ms:.0f} hindsight "
              f"over these {ratios[0]}, with this tail {ratios[1]}  plan "
              f"{a.report['times_ms']['plan_cpu']:.0f} ms, {len(choice['trials'])} trials",
              flush=True)


def main():
    parser = parser_of(__doc__, "tolerance")
    parser.add_argument("--side", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("scenes", nargs="+", metavar="SCENE.json")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for file in options.scenes:
        volume = Path(json.loads(Path(file).read_text())["input"])
        if volume.exists():
            measure(options, file)
        else:
            print(f"skipped: {Path(file).stem}: no {volume}"
                  + ("; tools/bench/compare_peers.py makes it" if volume.name == "scene.vdb" else ""))


if __name__ == "__main__":
    main()
