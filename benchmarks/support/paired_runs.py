#!/usr/bin/env python3
"""Two builds of weft side by side: the drapes and garments of the speed targets, on one host.

    paired_runs.py OLD NEW FILE [--only NAME]... [--devices 1,2] [--limit S]
                            runs them, and puts a case per run into FILE
    paired_runs.py --table FILE     prints the tables of such a file

OLD and NEW are source trees whose build/cuda-release/bin has weft_bench_drape and
weft_bench_roofline; each runs the scenes of its own tree. On one device both run at the same time,
the old build on cuda:0 and the new one on cuda:1; on two devices they take turns.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from markdown_table import BadInput, markdown, row
from suite_file import put_case, read_cases

SHEET = ["--frames", "40", "--set", "cloths.0.grid.cells=[{0},{0}]"]
INTERLOCK = ["--set", "cloths.0.material=interlock"]


def sheet(cells):
    return [text.format(cells) for text in SHEET]


# Name: scene, arguments of weft_bench_drape.
RUNS = {
    "sphere_498_stiff": ("sphere", sheet(499)),
    "sphere_498_interlock": ("sphere", sheet(499) + INTERLOCK),
    "sphere_977_stiff": ("sphere", sheet(699)),
    "sphere_977_interlock": ("sphere", sheet(699) + INTERLOCK),
    "stack_200": ("stack", ["--triangles", "200000"]),
    "dress_200": ("dress", ["--triangles", "200000", "--frames", "30"]),
    "funnel_200": ("funnel", ["--triangles", "200000", "--frames", "40"]),
    "dancer_skirt_200": ("dancer_skirt", ["--triangles", "200000", "--frames", "40"]),
    "curtain_1000": ("curtain", ["--triangles", "1000000", "--frames", "10"]),
}
# What conjugate gradients cost: the same sheet at the time when it is folded.
ROOFLINE = {
    "roofline_498": ["--set", "cloths.0.grid.cells=[499,499]", "--at", "0.75"],
    "roofline_977": ["--set", "cloths.0.grid.cells=[699,699]", "--at", "0.75"],
}


def command(tree, program, scene, device, rest, result):
    return [str(tree / "build/cuda-release/bin" / program), "--scene",
            str(tree / "scenes" / f"{scene}.json"), "--device", device, *rest, "--json",
            str(result)]


def run_all(commands, limit):
    """Runs commands at the same time. @return whether each ended well"""
    running = [subprocess.Popen(c, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
               for c in commands]
    good = []
    for process in running:
        try:
            _, error = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            process.kill()
            error = f"took longer than {limit} s"
        if process.returncode != 0:
            print(f"  {error.strip()[-300:]}", file=sys.stderr)
        good.append(process.returncode == 0)
    return good


def figures(path):
    """What the tables need of a result, without the scene."""
    found = json.loads(path.read_text())
    if found["benchmark"] == "roofline":
        pcg = [k for k in found["kernels"] if k["kernel"] == "solve/pcg"]
        step = found["step"]
        return {"build": found["build"], "triangle_count": found["triangle_count"],
                "step": step, "pcg": pcg[0] if pcg else None, "machine": found["machine"]}
    series = found["series"][0]
    return {"build": found["build"], "triangle_count": found["triangle_count"],
            "frames": found["frames"], "device": series["device"],
            "clean": all(f["clean"] for f in series["frames_judged"]),
            "sample": {k: v for k, v in series["samples"][0].items()
                       if k != "peak_device_bytes_by_use"}}


def run_case(name, old, new, devices, limit, folder):
    """@return {"old": figures, "new": figures} of those that ended"""
    results = {"old": folder / f"{name}_old.json", "new": folder / f"{name}_new.json"}
    roofline = name in ROOFLINE
    scene, rest = ("sphere", ROOFLINE[name]) if roofline else RUNS[name]
    program = "weft_bench_roofline" if roofline else "weft_bench_drape"
    if devices == 1:
        run_all([command(old, program, scene, "cuda:0", rest, results["old"]),
                 command(new, program, scene, "cuda:1", rest, results["new"])], limit)
    else:
        for tree, age in ((old, "old"), (new, "new")):
            run_all([command(tree, program, scene, "cuda:0,1", rest, results[age])], limit)
    return {age: figures(path) for age, path in results.items() if path.exists()}


def cell(case, age, text):
    return text(case[age]) if age in case else "-"


def speed(case):
    seconds = {age: case[age]["sample"]["wall_s_per_simulated_s"] for age in case}
    return f"{seconds['old'] / seconds['new']:.2f}" if len(seconds) == 2 else "-"


def pair(case, text):
    return f"{cell(case, 'old', text)} / {cell(case, 'new', text)}"


def of_sample(key, form="{:,.0f}"):
    return lambda c: pair(c, lambda r: form.format(r["sample"][key]))


def of_stage(name):
    """ms per step in a stage."""
    return lambda c: pair(c, lambda r: f"{r['sample']['stages_ms'][name] / r['sample']['steps']:.1f}")


COLUMNS = [
    ("triangles", True, lambda c: f"{next(iter(c.values()))['triangle_count']:,}"),
    ("s per simulated s, old / new", True, of_sample("wall_s_per_simulated_s", "{:.2f}")),
    ("times as fast", True, speed),
    ("solves", True, of_sample("solves")),
    ("iterations", True, of_sample("iterations")),
    ("solve, ms per step", True, of_stage("solve")),
    ("collision response, ms per step", True, of_stage("certify")),
    ("impacts", True, of_sample("impacts")),
    ("set-up, s", True, of_sample("setup_s", "{:.1f}")),
]


def table(path):
    cases = {name: case for name, case in read_cases(path).items() if {*case} <= {"old", "new"}}
    columns = [("run", False, lambda named: named[0]),
               *[(heading, number, lambda named, text=text: text(named[1]))
                 for heading, number, text in COLUMNS]]
    print(markdown(columns, [row(columns, path, named) for named in cases.items()
                             if "sample" in next(iter(named[1].values()), {})]))
    for name, case in cases.items():
        for age, found in case.items():
            if "pcg" not in found:
                continue
            pcg, step = found["pcg"], found["step"]
            print(f"{name}, {age}: {step['iterations']:.0f} iterations in {step['solves']:.2f} "
                  f"solves per step" + (f", conjugate gradients {pcg['ms_per_step']:.2f} ms per "
                                        f"step, {pcg['ratio'] or 0:.2f} times their bytes"
                                        if pcg else ""))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="+", type=Path, metavar="OLD NEW FILE | FILE")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--only", action="append", metavar="NAME")
    parser.add_argument("--devices", default="1,2", help="numbers of GPUs")
    parser.add_argument("--limit", type=float, default=200, help="[s] for a run")
    arguments = parser.parse_args()
    try:
        if arguments.table:
            return table(arguments.paths[0])
        if len(arguments.paths) != 3:
            raise BadInput("two source trees and a file are needed")
        old, new, path = arguments.paths
        for count in map(int, arguments.devices.split(",")):
            for name in [*RUNS, *(ROOFLINE if count == 1 else ())]:
                if arguments.only and name not in arguments.only:
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    case = run_case(name, old, new, count, arguments.limit, Path(folder))
                put_case(path, f"paired_{name}_{count}" if count > 1 else f"paired_{name}", case)
                if name in RUNS:
                    print(f"{name} on {count}: {speed(case)} times as fast", flush=True)
    except BadInput as error:
        print(f"paired_runs.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
