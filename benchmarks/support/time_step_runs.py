#!/usr/bin/env python3
"""Runs set-ups at time steps from short to very long, each with something that has to hold.

    time_step_runs.py PROGRAM FILE [SETUP...]                --device cuda:0, --limit SECONDS
    time_step_table.py --write docs/accuracy.md FILE...      the table

PROGRAM: weft. FILE: the results, an entry per set-up; kept up to date, those of other set-ups
stay. Exit code 0, also if something does not hold; 2 for bad input.
"""

import argparse
import datetime
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from jitter_runs import processor
from layer_gaps import FAR, layer_gaps
from markdown_table import BadInput
from suite_file import put_case

ROOT = Path(__file__).resolve().parents[2]
EVERYDAY = ROOT / "tests/everyday/scenes"
NEWTON = "solver.newton_iterations=20"


class Run:
    """A run that has ended, and what it has left."""

    def __init__(self, arguments, scene, sets, frames=None, experimental=()):
        self.folder = Path(tempfile.mkdtemp(prefix="time_step_"))
        command = [arguments.program, "run", str(scene), "-o", str(self.folder / "run"),
                   "--device", arguments.device, "--no-preview"]
        command += ["--frames", str(frames)] if frames else []
        for text in sets:
            command += ["--set", text]
        for text in experimental:
            command += ["--experimental", text]
        begin = time.monotonic()
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False,
                                  timeout=arguments.limit)
            self.exit_code, lines = done.returncode, done.stderr.strip().splitlines()
        except subprocess.TimeoutExpired:
            self.exit_code, lines = None, [f"no end within {arguments.limit} s"]
        self.message = lines[-1] if lines and self.exit_code != 0 else ""
        self.wall_s = round(time.monotonic() - begin, 2)
        steps = self.folder / "run/steps.jsonl"
        self.steps = []
        if steps.exists():
            self.steps = [json.loads(line) for line in steps.read_text().splitlines()]
        report = self.folder / "run/report.json"
        self.report = json.loads(report.read_text()) if report.exists() else {}

    def remove(self):
        shutil.rmtree(self.folder)

    def total(self, key):
        return sum(step[key] for step in self.steps)

    def elastic(self, at=None):
        """[J] the largest at any frame, or that at a time"""
        found = [step["energy"]["elastic"] for step in self.steps
                 if "energy" in step and (at is None or abs(step["time"] - at) < 1e-9)]
        return max(found, default=float("nan"))

    def vertices(self, frame):
        """[m] the cloths' vertices by name, of a frame"""
        cloths, current = {}, None
        for line in (self.folder / f"run/frames/cloth_{frame:05d}.obj").read_text().splitlines():
            word, _, rest = line.partition(" ")
            if word == "o":
                current = cloths.setdefault(rest.strip(), [])
            elif word == "v":
                if current is None:
                    current = cloths.setdefault("", [])
                current.append([float(x) for x in rest.split()])
        return cloths

    def extent(self, frame, axis):
        """[m]"""
        all_of_it = [x[axis] for cloth in self.vertices(frame).values() for x in cloth]
        return max(all_of_it) - min(all_of_it)


def strain_limits(run, arguments, step):
    reference = Run(arguments, EVERYDAY / "strain_limit_start.json", [f"time.step={step}", NEWTON])
    peak, bound = run.elastic(), reference.elastic()
    reference.remove()
    return f"{peak:.3g} J, Newton {bound:.3g} J", bound / 2 <= peak <= 2 * bound


def held_arch(run, arguments, _step):
    reference = Run(arguments, EVERYDAY / "held_arch.json", ["time.step=0.002", NEWTON])
    values = [(r.extent(20, 2), r.elastic(0.4), r.extent(28, 0)) for r in (run, reference)]
    reference.remove()
    (height, energy, length), (right_height, right_energy, _) = values
    holds = (abs(height / right_height - 1) <= 0.03 and abs(energy / right_energy - 1) <= 0.05
             and length >= 0.087)
    return (f"{height:.4f} m ({right_height:.4f}), {energy:.4f} J ({right_energy:.4f}), "
            f"{length:.4f} m"), holds


STARTS = 5
JITTER_M = 1e-5


def starts(arguments, scene, sets, frames=None, experimental=()):
    """A run from each jittered start, to be removed by the caller; fails if one does."""
    for seed in range(1, STARTS + 1):
        moved = sets + [f"jitter.amplitude={JITTER_M}"]
        run = Run(arguments, scene, moved, frames, [*experimental, f"jitter.seed={seed}"])
        if run.exit_code != 0:
            raise BadInput(f"{scene.stem} with {', '.join(moved)}, start {seed}: {run.message}")
        yield run
        run.remove()


def spun_sphere(run, arguments, step):
    jittered = [one.elastic() for one in
                starts(arguments, EVERYDAY / "spun_sphere.json", [f"time.step={step}"])]
    most = max(run.elastic(), *jittered)
    return f"{most:.3g} J", most <= 0.05


def mean_solves(arguments, step, experimental=()):
    scene = EVERYDAY / "wrung_tube.json"
    return sum(run.total("solves") for run in
               starts(arguments, scene, [f"time.step={step}"], None, experimental)) / STARTS


def wrung_tube(_run, arguments, step):
    solves = {}
    for stiffness in (30, 100, 300, 1000, 3000):
        try:
            found = mean_solves(arguments, step, [f"contact.stiffness={stiffness}"])
        except BadInput:
            continue
        solves[found] = stiffness
    best, own = min(solves), mean_solves(arguments, step)
    return (f"{own:.0f} solves; {best:.0f} with a contact stiffness of {solves[best]}",
            own <= 1.5 * best)


def wrung_neck(run, _arguments, _step):
    thickness = json.loads((run.folder / "run/scene.json").read_text())["contact"]["thickness"]
    gaps = layer_gaps(max((run.folder / "run/frames").glob("cloth_*.obj")), thickness)
    nearest = min(gaps, default=float("inf")) / thickness
    closer = sum(gap < thickness / 2 for gap in gaps) / max(1, len(gaps))
    return f"{nearest:.2f} thicknesses; {100 * closer:.1f} % closer than half", nearest >= 0.5


FINEST = 0.00125
TABLECLOTH_FRAMES = 22


def travels(run):
    """[m] along x, by name"""
    def means(frame):
        return {name: sum(x[0] for x in cloth) / len(cloth)
                for name, cloth in run.vertices(frame).items() if name != "cloth"}
    first, last = means(0), means(TABLECLOTH_FRAMES)
    return {name: last[name] - first[name] for name in first}


def mean_travels(arguments, step):
    """Those of all jittered starts: their means, smallest and largest [m] by name."""
    found = [travels(run) for run in
             starts(arguments, ROOT / "scenes/tablecloth.json", [f"time.step={step}"],
                    TABLECLOTH_FRAMES)]
    return {name: (sum(one[name] for one in found) / STARTS, min(one[name] for one in found),
                   max(one[name] for one in found)) for name in found[0]}


def tablecloth(_run, arguments, step):
    right, found = mean_travels(arguments, FINEST), mean_travels(arguments, step)
    holds = all(abs(found[name][0] - right[name][0]) <= max(0.2 * abs(right[name][0]), 0.01)
                for name in right)
    return ", ".join(
        f"{name} {100 * found[name][0]:.1f} ({100 * right[name][0]:.1f}) cm"
        f" [{100 * found[name][1]:.1f} to {100 * found[name][2]:.1f}]" for name in right), holds


# name: scene, frames (None: all), steps [s], what has to hold, what judges it
SETUPS = {
    "strain_limit_start": (
        EVERYDAY / "strain_limit_start.json", None, (0.04, 0.02, 0.01, 0.004),
        "largest elastic energy within a factor of 2 of that of Newton's method at the same step",
        strain_limits),
    "held_arch": (
        EVERYDAY / "held_arch.json", None, (0.02, 0.01, 0.002),
        "height at 0.4 s within 3 % and elastic energy within 5 % of those of Newton's method at "
        "0.002 s; at least 0.087 m long 0.06 s after the release", held_arch),
    "spun_sphere": (
        EVERYDAY / "spun_sphere.json", None, (0.04, 0.02, 0.01, 0.005),
        f"elastic energy at most 0.05 J, the most of the scene's start and {STARTS} that differ by "
        f"{JITTER_M:g} m", spun_sphere),
    "wrung_tube": (
        EVERYDAY / "wrung_tube.json", None, (0.04,),
        f"at most 1.5 times the linear solves that the best contact stiffness needs, means over {STARTS} "
        f"starts that differ by {JITTER_M:g} m", wrung_tube),
    "wrung_neck": (
        EVERYDAY / "wrung_tube.json", None, (0.04,),
        f"layers of the neck of the wrung tube keep half of the thickness at the end: nearest, and "
        f"share of the vertices within {FAR} thicknesses of another layer", wrung_neck),
    "tablecloth": (
        ROOT / "scenes/tablecloth.json", TABLECLOTH_FRAMES, (0.0025, 0.005, 0.01),
        f"plates and cups travel as far as at {FINEST} s within 20 % or 1 cm, means over {STARTS} "
        f"starts that differ by {JITTER_M:g} m [least to most]", tablecloth),
}


def device_of(arguments):
    """The device as `weft info` describes it."""
    told = subprocess.run([arguments.program, "info"], capture_output=True, text=True, check=True)
    for line in told.stdout.splitlines():
        if line.strip().startswith(arguments.device.split(",")[0] + ":"):
            return line.strip()
    return arguments.device


def measure(arguments, name):
    """The entry of a set-up."""
    scene, frames, steps, about, judge = SETUPS[name]
    rows, report = [], {}
    for step in steps:
        run = Run(arguments, scene, [f"time.step={step}"], frames)
        report = run.report or report
        found, holds = run.message, False
        if run.exit_code == 0:
            found, holds = judge(run, arguments, step)
        rows.append({"step_s": step, "found": found, "holds": holds, "wall_s": run.wall_s,
                     "solves": run.total("solves"), "retries": run.total("retries")})
        run.remove()
        print(f"{'holds' if holds else 'MISSES'}  {name} at {step} s: {found}", flush=True)
    return {"benchmark": "time_step", "setup": name, "about": about, "rows": rows,
            "device": device_of(arguments), "build": report.get("build"),
            "machine": {"cpu": processor(), "threads": os.cpu_count() or 1},
            "finished": datetime.datetime.now(datetime.timezone.utc).strftime("%FT%TZ")}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("file", type=Path)
    parser.add_argument("setup", nargs="*", help=f"default: all of {', '.join(SETUPS)}")
    parser.add_argument("--device", default="cpu:1")
    parser.add_argument("--limit", type=float, default=600, help="seconds a run")
    arguments = parser.parse_args()
    try:
        if shutil.which(arguments.program) is None:
            raise BadInput(f"{arguments.program}: no such program")
        for name in arguments.setup or SETUPS:
            if name not in SETUPS:
                raise BadInput(f"{name}: not one of {', '.join(SETUPS)}")
            put_case(arguments.file, name, measure(arguments, name))
    except BadInput as error:
        print(f"time_step_runs.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
