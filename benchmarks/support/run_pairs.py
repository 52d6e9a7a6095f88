"""Runs of scenes with and without something, by turns, for benchmarks that compare their steps."""

import argparse
import json
import os
import statistics
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def last_positions(folder):
    """Vertices in the last frame by the name of their cloth, in metres."""
    last = max((Path(folder) / "frames").glob("cloth_*.obj"))
    cloths, name = {}, ""
    for line in last.read_text().splitlines():
        if line[:2] in ("o ", "g "):
            name = line[2:].strip()
        elif line.startswith("v "):
            cloths.setdefault(name, []).append(tuple(map(float, line.split()[1:4])))
    return cloths


def run(program, scene, more, frames, folder):
    """Report, steps and last positions of a run on one rank of the host; exits where it fails.

    more: words of the command line
    """
    shutil.rmtree(folder, ignore_errors=True)  # what the run before has left
    words = [program, "run", scene, "-o", folder, "--no-preview", "--device", "cpu:1",
             "--frames", str(frames)]
    words += more
    done = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        print(f"{scene}: exit code {done.returncode}: {done.stderr.strip()}", file=sys.stderr)
        sys.exit(2)
    report = json.loads((Path(folder) / "report.json").read_text())
    steps = [json.loads(line) for line in (Path(folder) / "steps.jsonl").read_text().splitlines()]
    return report, steps, last_positions(folder)


def turns(arguments, scene, with_it, without_it):
    """Pairs of runs, with and without, each (report, steps, positions); who is first changes.

    with_it, without_it: words of the command line
    """
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(arguments.pairs):
            ends = {}
            for side in ((0, 1) if turn % 2 else (1, 0)):
                more = [word for text in arguments.set for word in ("--set", text)]
                more += (with_it, without_it)[side]
                ends[side] = run(arguments.program, scene, more, arguments.frames, folder)
            yield ends[0], ends[1]


def step_ms(step):
    return sum(step["stages_ms"].values())


def median(values):
    values = list(values)
    return statistics.median(values) if values else None


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown"


def measure_all(about, measure, pairs, frames):
    """Reads the command line, has each scene measured, and writes the file after each.
    measure(arguments, scene) returns build and line. Returns the lines."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("program")
    parser.add_argument("file")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--pairs", type=int, default=pairs)
    parser.add_argument("--frames", type=int, default=frames)
    parser.add_argument("--set", action="append", default=[])
    arguments = parser.parse_args()
    result = {"machine": {"cpu": processor(), "threads": os.cpu_count() or 1},
              "frames": arguments.frames, "overrides": arguments.set, "scenes": []}
    for scene in arguments.scenes:
        result["build"], line = measure(arguments, scene)
        line["load"] = os.getloadavg()[0]
        result["scenes"].append(line)
        print(json.dumps(line), flush=True)
        Path(arguments.file).write_text(json.dumps(result, indent=2) + "\n")
    return result["scenes"]
