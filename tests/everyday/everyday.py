#!/usr/bin/env python3
"""Runs set-ups that people try, and says which end as they should.

usage: everyday.py --program WEFT [SCENE...] [--quick] [--device cpu:1] [--limit SECONDS] [--list]

Without SCENE: all of index.json but its known misses; with --quick those marked quick. A scene ends as it should if it
ends within --limit seconds and either

- exits 0 with all seams closed and all frames clean, if need be against displaced bodies, no coordinate beyond `largest_coordinate`, the `mean_height` of free fall, and nothing
  prescribed further from its place than what the scene allows; or
- is refused by name, unless it has `must_pass`: exit 2 with one line, or exit 4 with one line, a checkpoint and clean
  frames.

An entry may run another `scene` than that of its name, with some `set`. `elastic_max` [J] bounds the elastic energy at the end of any frame, `solves_max` the
linear solves of all steps; layers beside each other are at least `layers_min` thicknesses apart at the end. `at` names
times of frames and, for each, ranges of the elastic energy, of the extents of all cloth along x, y, z [m], and of how far the mean of each cloth's
vertices has moved along x since the start [m].

A `miss` gives the reason why a scene does not end so today. `failed_at_2e91de6` says how a scene failed at that commit.

Exit code: 0 all do, 1 some do not.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "benchmarks" / "support"))
from layer_gaps import layer_gaps  # noqa: E402

THICKNESSES = 2  # that prescribed vertices may miss their places by


def vertices(frame):
    for line in frame.read_text().splitlines():
        if line.startswith("v "):
            yield [float(x) for x in line.split()[1:4]]


def cloths(frame):
    """places [m] of the vertices of each cloth, by its name"""
    places = {}
    for line in frame.read_text().splitlines():
        word, _, rest = line.partition(" ")
        if word == "o":
            name = rest.strip()
        elif word == "v":
            places.setdefault(name, []).append([float(x) for x in rest.split()[:3]])
    return places


def moved_x(directory, frame):
    """[m] by "moved_x_" and the name of a cloth"""
    def means(path):
        return {name: sum(x[0] for x in places) / len(places) for name, places in cloths(path).items()}
    first, last = means(directory / "frames" / "cloth_00000.obj"), means(frame)
    return {"moved_x_" + name: last[name] - first[name] for name in first}


def steps_of(directory):
    return [json.loads(line) for line in (directory / "steps.jsonl").read_text().splitlines()]


def frame_problem(directory, about, expected):
    """What is wrong with the frames of a run, or nothing.

    expected: how many there have to be; None: any number
    """
    frames = sorted((directory / "frames").glob("cloth_*.obj"))
    if expected is not None and len(frames) != expected:
        return f"{len(frames)} frames instead of {expected}"
    for frame in frames:
        for x in vertices(frame):
            if not max(abs(c) for c in x) <= about["largest_coordinate"]:
                return f"{frame.name}: a vertex at {x}"
    if expected is not None and "mean_height" in about:
        heights = [x[2] for x in vertices(frames[-1])]
        wanted, tolerance = about["mean_height"]
        mean = sum(heights) / len(heights)
        if not abs(mean - wanted) <= tolerance:
            return f"mean height {mean:.4f} m instead of {wanted}"
    return ""


def compliance_problem(directory):
    report = json.loads((directory / "report.json").read_text())
    thickness = json.loads((directory / "scene.json").read_text())["contact"]["thickness"]
    distance = report["contacts"]["compliance_distance_max"]
    if not distance <= THICKNESSES * thickness:
        return f"something prescribed is {distance:.3g} m from its place"
    return ""


def energy_problem(directory, about):
    if "elastic_max" not in about:
        return ""
    peak = max(step["energy"]["elastic"] for step in steps_of(directory) if "energy" in step)
    return "" if peak <= about["elastic_max"] else f"elastic energy of {peak:.4g} J"


def work_problem(directory, about):
    if "solves_max" not in about:
        return ""
    solves = sum(step["solves"] for step in steps_of(directory))
    return "" if solves <= about["solves_max"] else f"{solves} linear solves"


def layer_problem(directory, about):
    if "layers_min" not in about:
        return ""
    thickness = json.loads((directory / "scene.json").read_text())["contact"]["thickness"]
    gaps = layer_gaps(max((directory / "frames").glob("cloth_*.obj")), thickness)
    if not gaps:
        return "no layers beside each other"
    nearest = min(gaps) / thickness
    return "" if nearest >= about["layers_min"] else f"layers {nearest:.2f} thicknesses apart"


def seam_problem(directory):
    seams = json.loads((directory / "report.json").read_text()).get("seams", [])
    still_open = [seam for seam in seams if seam["open"] > 0]
    return f"{len(still_open)} of {len(seams)} seams open" if still_open else ""


def state_problem(directory, about):
    rate = json.loads((directory / "scene.json").read_text())["time"]["frame_rate"]
    steps = steps_of(directory)
    for time, ranges in about.get("at", {}).items():
        frame = directory / "frames" / f"cloth_{round(float(time) * rate):05}.obj"
        places = list(zip(*vertices(frame)))
        found = {"extent_" + axis: max(x) - min(x) for axis, x in zip("xyz", places)}
        if any(name.startswith("moved_x_") for name in ranges):
            found |= moved_x(directory, frame)
        found["elastic"] = next(step["energy"]["elastic"] for step in steps
                                if "energy" in step and abs(step["time"] - float(time)) < 1e-6)
        for name, (low, high) in ranges.items():
            if not low <= found[name] <= high:
                return f"{name} of {found[name]:.4g} at {time} s"
    return ""


def problem_of(args, name, about, directory):
    """What is wrong with how the scene ends, or nothing; and how it ended."""
    scene = HERE / "scenes" / (about.get("scene", name) + ".json")
    command = [args.program, "run", scene, "-o", directory, "--device", args.device, "--no-preview"]
    for override in about.get("set", []):
        command += ["--set", override]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=args.limit)
    except subprocess.TimeoutExpired:
        return f"no end within {args.limit:g} s", "killed"
    lines = [l for l in run.stderr.splitlines() if l.startswith("weft: ") and "warning" not in l]
    if run.returncode not in (0, 2, 4):
        return f"exit {run.returncode}: {run.stderr[-300:]}", "died"
    if run.returncode != 0:
        how = lines[0] if lines else ""
        if len(lines) != 1:
            return f"exit {run.returncode} with {len(lines)} lines", how
        if about.get("must_pass"):
            return "refused, but has to pass: " + how, how
        if run.returncode == 2:
            return "", how
        if not list(directory.glob("checkpoint*")):
            return "exit 4 without a checkpoint", how
    check = subprocess.run([args.program, "check", directory], capture_output=True, text=True)
    if check.returncode != 0:
        return "not clean: " + check.stdout.strip()[-300:], "ran"
    if run.returncode == 4:
        return frame_problem(directory, about, None), how
    frames = json.loads((directory / "scene.json").read_text())["time"]["frames"]
    return (frame_problem(directory, about, frames + 1) or compliance_problem(directory)
            or seam_problem(directory) or energy_problem(directory, about) or work_problem(directory, about)
            or layer_problem(directory, about) or state_problem(directory, about)), "ran to its end"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--program", required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--device", default="cpu:1")
    parser.add_argument("--limit", type=float, default=240)
    parser.add_argument("--list", action="store_true", help="print the names instead of running them")
    args = parser.parse_args()
    index = json.loads((HERE / "index.json").read_text())
    names = args.scenes or [n for n, about in index.items()
                            if "miss" not in about and (about.get("quick", False) or not args.quick)]
    if args.list:
        print("\n".join(names))
        return 0
    failed = 0
    for name in names:
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as scratch:
            problem, how = problem_of(args, name, index[name], pathlib.Path(scratch) / "run")
        failed += bool(problem)
        print(f"{'FAILED' if problem else 'ok':7}{time.monotonic() - start:7.1f} s  {name:32}{problem or how}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
