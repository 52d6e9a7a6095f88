#!/usr/bin/env python3
"""Runs a scene whole on some devices, and in slices of time, and notes the speed-up of each.

    time_parallel_devices.py WEFT SCENE FILE --whole cuda:0 --whole cuda:0,1 --sliced cuda:0,1 2
                                      FILE: where the result goes, as the entry of that
                                      scene; written after each run

Speed-up is over the first --whole. --sliced names the devices of `weft run` and the number of
slices: each of a card, or of what cpu:N is. On cards they run with recovery of detail and without,
since that is on the CPU. The last partition is repeated on the first device, two slices at a time,
which has to give the same bits. Exit code 0 if all runs came to their end and those bits are the
same; 1 if not; 2 for bad input.
"""

import argparse
import datetime
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from jitter_runs import processor
from markdown_table import BadInput
from suite_file import put_case


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="weft")
    parser.add_argument("scene", type=Path, help="scene file")
    parser.add_argument("file", type=Path, help="where the result goes")
    parser.add_argument("--whole", action="append", required=True, metavar="DEVICE",
                        help="of a run by the method \"implicit\"; may be repeated")
    parser.add_argument("--sliced", nargs=2, action="append", required=True,
                        metavar=("DEVICE", "SLICES"), help="of a run in slices; may be repeated")
    parser.add_argument("--no-repeat", action="store_true",
                        help="leave out the last partition on the first device")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE",
                        help="override a value of the scene; may be repeated")
    parser.add_argument("--limit", type=float, default=300, help="seconds a run")
    parser.add_argument("--commit", help="of the program; default: what it says itself")
    return parser.parse_args()


def head_of(arguments):
    """What the file says besides its runs."""
    told = subprocess.run([arguments.program, "info"], check=True, capture_output=True, text=True,
                          timeout=60).stdout
    built = re.search(r"^commit +([0-9a-f]*)(.*)$", told, re.M)
    return {"benchmark": "time_parallel_devices", "scene": arguments.scene.stem,
            "command": ["benchmarks/support/time_parallel_devices.py",
                        *(Path(w).name if w.startswith("/") else w for w in sys.argv[1:])],
            "commit": arguments.commit or (built.group(1) if built else ""),
            "dirty": not arguments.commit and bool(built and "changes" in built.group(2)),
            "machine": {"cpu": processor(), "threads": os.cpu_count() or 1,
                        "load_average_before": list(os.getloadavg()),
                        "devices": sorted(set(re.findall(r"NVIDIA [^,\n(]*", told)))},
            "overrides": arguments.set}


def run(arguments, folder, device, words):
    """One run: what it was, what it took, and its report."""
    call = [arguments.program, "run", str(arguments.scene), "-o", str(folder), "--no-preview",
            "--device", device, *words]
    for override in arguments.set:
        call += ["--set", override]
    entry = {"device": device, "options": [w for w in words if not w.startswith("/")],
             "finished": None}
    begin = time.monotonic()
    try:
        done = subprocess.run(call, capture_output=True, text=True, timeout=arguments.limit)
        entry["exit_code"] = done.returncode
        entry["message"] = (done.stderr.strip().splitlines() or [""])[-1]
    except subprocess.TimeoutExpired:
        entry["exit_code"], entry["message"] = None, f"not done after {arguments.limit:g} s"
    entry["process_s"] = time.monotonic() - begin
    entry["finished"] = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    if entry["exit_code"] != 0:
        return entry, {}
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    for key in ("triangle_count", "steps", "simulated_s", "wall_s", "state_hash"):
        entry[key] = report[key]
    sliced = report.get("time_parallel")
    if sliced:
        entry["speedup_by_formulas"] = sliced["speedup"]["by_clock"]
        entry["fine_steps_s"] = sum(s["steps_s"] for s in sliced["slices"])
        entry["starts_s"] = [s["start_s"] for s in sliced["slices"]]
        entry["iterations"] = [s["recovery"]["iterations"] for s in sliced["slices"][1:]]
        entry["coarse"] = sliced["coarse"]
        entry["jump_over_frame_change"] = [s["jump_over_frame_change"] for s in sliced["slice_boundaries"]]
    return entry, report


def run_all(arguments, work):
    """Runs everything; returns whether all is as it should be."""
    result = {**head_of(arguments), "runs": []}

    def add(kind, folder, device, words, slices=1):
        entry, _ = run(arguments, work / folder, device, words)
        entry = {"kind": kind, "slices": slices, **entry}
        one = result["runs"][0] if result["runs"] else entry
        if "wall_s" in entry and "wall_s" in one:
            entry["speedup"] = one["wall_s"] / entry["wall_s"]
        result["runs"].append(entry)
        put_case(arguments.file, arguments.scene.stem, result)
        print(f"{kind:<24} {device:<14} {slices} slices: "
              f"{entry.get('wall_s', float('nan')):8.2f} s, {entry.get('speedup', 0):5.2f}x"
              f"{': ' + entry['message'] if entry['exit_code'] else ''}", flush=True)
        return entry

    for number, device in enumerate(arguments.whole):
        add("whole", f"whole_{number}", device, ["--method", "implicit"])
    last = None
    for device, slices in arguments.sliced:
        common = ["--method", "time_parallel", "--workers", str(int(slices) + 1), "--set",
                  f"method.time_parallel.slices={slices}"]
        last = add("slices", f"slices_{slices}", device, common, int(slices))
        if device.startswith("cuda"):
            add("slices, no recovery", "no_recovery", device,
                [*common, "--experimental", "method.time_parallel.recovery.iterations=0"], int(slices))
    good = all(entry["exit_code"] == 0 for entry in result["runs"])
    if arguments.no_repeat or not good:
        return good
    slices = arguments.sliced[-1][1]
    again = add("the same slices", "again", arguments.whole[0],
                ["--method", "time_parallel", "--workers", "2", "--set",
                 f"method.time_parallel.slices={slices}", "--partition",
                 str(work / f"slices_{slices}" / "partition.json")], int(slices))
    same = again.get("state_hash") == last["state_hash"]
    print("the same bits" if same else "OTHER BITS")
    return same


def main():
    arguments = parse()
    arguments.program = shutil.which(arguments.program) or arguments.program
    try:
        with tempfile.TemporaryDirectory(prefix="time_parallel_devices_") as folder:
            return 0 if run_all(arguments, Path(folder)) else 1
    except (BadInput, OSError, ValueError, subprocess.SubprocessError) as error:
        print(f"time_parallel_devices.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
