#!/usr/bin/env python3
"""What contact.self_certificate saves, or costs: scenes with and without it, by turns.

    certificate_pairs.py PROGRAM FILE.json SCENE...          such as scenes/flag.json
    certificate_pairs.py PROGRAM FILE.json --pairs 5 --frames 10 --set triangles=10000 SCENE...

One rank of the host. A step's time is compared with that of the same step without, so that what
else the machine does hits both; the medians over all steps of all pairs stand in the file, with
build and machine. Exit code 0; 1 if a pair ends in different states; 2 for bad input.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path


def run(program, scene, arguments, certificate, folder):
    """Report and steps of a run; exits where it fails."""
    words = [program, "run", scene, "-o", folder, "--no-preview", "--device", "cpu:1",
             "--frames", str(arguments.frames),
             "--set", f"contact.self_certificate={'true' if certificate else 'false'}"]
    for override in arguments.set:
        words += ["--set", override]
    done = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        print(f"{scene}: exit code {done.returncode}: {done.stderr.strip()}", file=sys.stderr)
        sys.exit(2)
    report = json.loads((Path(folder) / "report.json").read_text())
    steps = [json.loads(line) for line in (Path(folder) / "steps.jsonl").read_text().splitlines()]
    return report, steps


def contact_ms(step):
    return step["stages_ms"]["contacts"] + step["stages_ms"]["certify"]


def step_ms(step):
    return sum(step["stages_ms"].values())


def median(values):
    values = list(values)
    return statistics.median(values) if values else None


def measure(program, scene, arguments):
    """One scene's line of the result."""
    pairs, same, build = [], True, None
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(arguments.pairs):
            ends = {}
            for certificate in ((True, False) if turn % 2 else (False, True)):
                ends[certificate] = run(program, scene, arguments, certificate, folder)
            same = same and ends[True][0]["state_hash"] == ends[False][0]["state_hash"]
            build = ends[True][0]["build"]
            pairs += zip(ends[True][1], ends[False][1])
    held = [(a, b) for a, b in pairs if a["self_certified"]]
    not_held = [(a, b) for a, b in pairs if not a["self_certified"]]
    return build, {
        "scene": Path(scene).stem, "same_state": same,
        "triangles": ends[True][0]["triangle_count"],
        "steps": len(pairs), "certified": len(held),
        "asked": sum(a["certificate_ms"] > 0 for a, _ in pairs),
        "certificate_ms": median(a["certificate_ms"] for a, _ in pairs if a["certificate_ms"] > 0),
        "certified_contact_ms": [median(contact_ms(p[k]) for p in held) for k in range(2)],
        "certified_step_ms": [median(step_ms(p[k]) for p in held) for k in range(2)],
        "certified_step_ratio": median(step_ms(a) / step_ms(b) for a, b in held),
        "other_step_ratio": median(step_ms(a) / step_ms(b) for a, b in not_held)}


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("file")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--set", action="append", default=[])
    arguments = parser.parse_args()
    result = {"machine": {"cpu": processor(), "threads": os.cpu_count() or 1},
              "frames": arguments.frames, "overrides": arguments.set, "scenes": []}
    for scene in arguments.scenes:
        result["build"], line = measure(arguments.program, scene, arguments)
        line["load"] = os.getloadavg()[0]
        result["scenes"].append(line)
        print(json.dumps(line), flush=True)
        Path(arguments.file).write_text(json.dumps(result, indent=2) + "\n")
    return 0 if all(line["same_state"] for line in result["scenes"]) else 1


if __name__ == "__main__":
    sys.exit(main())
