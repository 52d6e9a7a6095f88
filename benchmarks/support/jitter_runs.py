#!/usr/bin/env python3
"""Runs whole scenes from jittered starts and has `weft check` validate every frame.

    jitter_runs.py PROGRAM FILE               PROGRAM: weft; FILE: the results, an entry per scene
    jitter_runs.py PROGRAM FILE twist cards   only these scenes; the entries of others stay
    jitter_runs.py PROGRAM FILE --jobs 16     so many runs at once, each on one thread

FILE is written after each run. A later start keeps the runs that it holds if they have the same
commit, jitter and length; those of a build with changes are repeated.
Exit code 0 if every run ended as it should and all its frames are clean, with bodies where the scene
puts them; 1 if not; 2 for bad input.
"""

import argparse
import datetime
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from markdown_table import BadInput
from suite_file import put_case, read_cases

# Longest first, so that none is left to run alone at the end.
SCENES = ("funnel", "stack", "dancer_skirt", "dress", "twist", "tablecloth", "bullet", "curtain",
          "cards", "mass_ratio", "needles", "plates")
# What a whole run ends with, where that is not 0, and what its message has to say.
ENDS = {"plates": (4, "pinched")}
LIMIT_S = 3600


class Book:
    """The results of one scene: its entry in the file, kept up to date."""

    lock = threading.Lock()  # all scenes share the file

    def __init__(self, path, head):
        self.path = path
        self.head = head
        self.runs = {}
        old = (read_cases(path) if path.exists() else {}).get(head["scene"])
        if not old or not head["commit"] or head["dirty"]:
            return
        same = ("commit", "dirty", "amplitude_m", "frames_asked", "overrides")
        if all(old.get(key) == head[key] for key in same):
            self.runs = {run["seed"]: run for run in old["runs"] if self.counts(run)}

    def counts(self, run):
        """Whether a run need not be repeated: more time would not change it."""
        return not run["timed_out"] or run["limit_s"] >= self.head["limit_s"]

    def add(self, run):
        """Adds a run and writes the file."""
        with self.lock:
            self.runs[run["seed"]] = run
            self.write()

    def write(self):
        runs = [self.runs[seed] for seed in sorted(self.runs)]
        result = {**self.head, "runs": runs, "passed": sum(run["passes"] for run in runs)}
        put_case(self.path, self.head["scene"], result)


def processor():
    """What this machine calls its processor."""
    try:
        found = re.search(r"^model name\s*: *(.*)$", Path("/proc/cpuinfo").read_text(), re.M)
    except OSError:
        found = None
    return found.group(1).strip() if found else "unknown"


def head_of(arguments, scene):
    """What a scene's entry says besides its runs."""
    try:
        told = subprocess.run([arguments.program, "info"], check=True, capture_output=True,
                              text=True, timeout=60).stdout
    except (OSError, subprocess.SubprocessError) as error:
        raise BadInput(f"{arguments.program}: {error}") from error
    built = re.search(r"^commit +([0-9a-f]*)(.*)$", told, re.M)
    compiler = re.search(r"^compiler +(.*)$", told, re.M)
    code, words = ENDS.get(scene, (0, ""))
    return {"benchmark": "jitter", "scene": scene,
            "command": ["benchmarks/support/jitter_runs.py", *map(without_folder, sys.argv[1:])],
            "commit": arguments.commit or (built.group(1) if built else ""),
            "dirty": not arguments.commit and bool(built and "changes" in built.group(2)),
            "compiler": compiler.group(1) if compiler else "",
            "machine": {"cpu": processor(), "threads": os.cpu_count() or 1},
            "amplitude_m": arguments.amplitude, "frames_asked": arguments.frames,
            "overrides": arguments.set, "limit_s": arguments.limit, "jobs": arguments.jobs,
            "expected": {"exit_code": code, "message": words}}


def call(words, limit):
    """Exit code (None: stopped after `limit` seconds), last line of its errors, seconds."""
    begin = time.monotonic()
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=limit)
        code, message = done.returncode, (done.stderr.strip().splitlines() or [""])[-1]
    except subprocess.TimeoutExpired:
        code, message = None, f"not done after {limit:g} s"
    except OSError as error:
        raise BadInput(f"{words[0]}: {error}") from error
    return code, message, time.monotonic() - begin


def loaded(path):
    """The JSON of a file; an empty object if there is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def slowest_step(path):
    """Seconds of the longest step of a run's log."""
    slowest = 0.0
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                slowest = max(slowest, json.loads(line)["wall_s"])
            except (ValueError, KeyError):
                continue  # cut off in the middle
    return slowest


def without_folder(word):
    """Absolute paths are those of a machine: their last name."""
    return Path(word).name if word.startswith("/") else word


def run_words(arguments, scene, seed, folder):
    words = [arguments.program, "run", str(arguments.scenes / f"{scene}.json"), "-o",
             str(folder), "--no-preview", "--device", "cpu:1",
             "--set", f"jitter.amplitude={arguments.amplitude:g}",
             "--experimental", f"jitter.seed={seed}"]
    for override in arguments.set:
        words += ["--set", override]
    return words + (["--frames", str(arguments.frames)] if arguments.frames else [])


def run_seed(arguments, book, scene, seed, work):
    """One run and its check; what the scene's entry says of it."""
    folder = work / f"{scene}_{seed}"
    shutil.rmtree(folder, ignore_errors=True)
    words = run_words(arguments, scene, seed, folder)
    shown = [folder.name if word == str(folder) else without_folder(word) for word in words]
    code, message, wall = call(words, arguments.limit)
    verdict_file = work / f"{scene}_{seed}.json"
    checked, _, _ = call([arguments.program, "check", str(folder), "--quiet", "--json",
                          str(verdict_file)], arguments.limit)
    judged = loaded(verdict_file).get("summary", {})
    report = loaded(folder / "report.json")
    contacts = report.get("contacts", {})
    judged_frames = judged.get("frames", 0)
    displaced = judged.get("clean_against_displaced", 0)
    clean = judged_frames - judged.get("bad", 0) - judged.get("unreadable", 0) - displaced
    expected, words_expected = ENDS.get(scene, (0, ""))
    # A run that is cut short may end before what it leads to.
    ended = code == expected and words_expected in message or arguments.frames and code == 0
    entry = {"seed": seed, "exit_code": code, "timed_out": code is None, "message": message,
             "frames": report.get("frames"), "frames_judged": judged_frames, "frames_clean": clean,
             "frames_clean_against_displaced": displaced, "check_exit_code": checked,
             "passes": bool(ended and checked == 0 and clean > 0 and displaced == 0),
             "wall_s": round(wall, 3), "slowest_step_s": slowest_step(folder / "steps.jsonl"),
             "steps": report.get("steps"), "retries": contacts.get("retries"),
             "steps_at_fallback_level": contacts.get("steps_at_fallback_level"),
             "impacts": contacts.get("impacts_total"), "zones_max": contacts.get("zones_max"),
             "zone_largest": contacts.get("zone_largest"),
             "zone_rounds_max": contacts.get("zone_rounds_max"),
             "zones_unsolved": contacts.get("zones_unsolved_total"),
             "compliance_distance_max": contacts.get("compliance_distance_max"),
             "state_hash": report.get("state_hash"), "command": shlex.join(shown),
             "limit_s": arguments.limit,
             "finished": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")}
    book.add(entry)
    if not arguments.keep:
        shutil.rmtree(folder, ignore_errors=True)
        verdict_file.unlink(missing_ok=True)
    return entry


def run_all(arguments, work):
    """Runs what the file does not hold yet; returns how many runs of all are not as they should."""
    books = {scene: Book(arguments.file, head_of(arguments, scene)) for scene in arguments.scene}
    missing = [(scene, seed) for scene in arguments.scene for seed in arguments.seeds
               if seed not in books[scene].runs]
    kept = len(arguments.scene) * len(arguments.seeds) - len(missing)
    if kept:
        print(f"{kept} runs are there already", flush=True)

    def run_one(case):
        run = run_seed(arguments, books[case[0]], *case, work)
        verdict = "clean" if run["passes"] else "WRONG"
        print(f"{verdict}  {run['wall_s']:8.1f} s  {case[0]} {case[1]}"
              f"{': ' + run['message'] if run['message'] else ''}", flush=True)

    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(run_one, missing))
    return sum(not books[scene].runs[seed]["passes"] for scene in arguments.scene
               for seed in arguments.seeds)


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="weft")
    parser.add_argument("file", type=Path, help="the results")
    parser.add_argument("scene", nargs="*", help="default: all twelve of the contact suite")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="runs at once")
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="seconds a run")
    parser.add_argument("--frames", type=int, help="instead of each scene's own number")
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(1, 11)))
    parser.add_argument("--amplitude", type=float, default=1e-4, help="of the jitter [m]")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE",
                        help="override a value of the scenes; may be repeated")
    parser.add_argument("--commit", help="of the program; default: what it says itself")
    parser.add_argument("--scenes", type=Path, help="folder of the scene files",
                        default=Path(os.path.relpath(Path(__file__).resolve().parents[2] / "scenes")))
    parser.add_argument("--work", type=Path, help="folder for the runs; default: a temporary one")
    parser.add_argument("--keep", action="store_true", help="leave the runs in --work")
    arguments = parser.parse_args()
    arguments.scene = arguments.scene or list(SCENES)
    # As a program on PATH or a file, whichever is meant.
    arguments.program = shutil.which(arguments.program) or str(arguments.program)
    for scene in arguments.scene:
        if not (arguments.scenes / f"{scene}.json").exists():
            raise BadInput(f"{arguments.scenes / f'{scene}.json'}: no such file")
    for value, name in ((arguments.jobs, "--jobs"), (arguments.limit, "--limit"),
                        (1 if arguments.frames is None else arguments.frames, "--frames")):
        if value <= 0:
            raise BadInput(f"{name}: {value}; must be above 0")
    return arguments


def main():
    try:
        arguments = parse()
        begin = time.monotonic()
        if arguments.work:
            arguments.work.mkdir(parents=True, exist_ok=True)
            wrong = run_all(arguments, arguments.work)
        else:
            with tempfile.TemporaryDirectory(prefix="jitter_") as folder:
                wrong = run_all(arguments, Path(folder))
    except BadInput as error:
        print(f"jitter_runs.py: {error}", file=sys.stderr)
        return 2
    print(f"{len(arguments.scene) * len(arguments.seeds)} runs in {time.monotonic() - begin:.0f} s, "
          f"{wrong} not as they should")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
