#!/usr/bin/env python3
"""Compares two programs bit by bit: state hashes and frames of every scene with every method.

    compare_bits.py OLD NEW              runs both programs on every scene of the repository
    compare_bits.py OLD --save FILE      runs OLD alone and keeps its results
    compare_bits.py NEW --against FILE   runs NEW alone and compares with kept results

Prints one line per scene and method. Exit code 1 if anything differs, 2 if the arguments are wrong.
Both programs get the same arguments. Where keys of the scene format have changed, each program takes
its own copy of the scenes (--old-scenes, --new-scenes). Bits depend on the compiler and on the kind
of device, so both runs belong on one machine.
"""

import argparse
import concurrent.futures
import hashlib
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

METHODS = ("implicit", "adaptive", "view", "asynchronous", "time_parallel")
TRIANGLES_KEY = re.compile(r'^\s*"triangles"\s*:', re.MULTILINE)
# A method that accepts other integrators than the scene's gets its own, else most scenes test nothing.
EXTRA = {"asynchronous": ("method.integrator=implicit_euler",)}


def scene_names(folder):
    """Names of the scene files in a folder, without the suffix."""
    files = sorted(p for p in folder.glob("*.json") if not p.name.endswith(".schema.json"))
    return [p.stem for p in files]


def settings_of(scene_file, method, arguments):
    """The overrides of a run, the same for both programs."""
    settings = [f"time.frames={arguments.frames}", f"method.type={method}"]
    if arguments.triangles and TRIANGLES_KEY.search(scene_file.read_text(encoding="utf-8")):
        settings.append(f"triangles={arguments.triangles}")
    settings.extend(EXTRA.get(method, ()))
    return settings


def outcome(program, scene_file, method, arguments):
    """Runs a scene. Returns {"status": ..., ...}:

    "done" with "hash" and "frames" (SHA-256 of each file by name); "refused" (exit code 2),
    "failed" (any other) and "timeout", with the program's message where there is one.
    """
    if not scene_file.is_file():
        return {"status": "missing", "message": str(scene_file)}
    with tempfile.TemporaryDirectory(prefix="compare_bits.") as folder:
        out = Path(folder) / "run"
        command = [program, "run", str(scene_file), "-o", str(out), "--no-preview"]
        command += ["--device", arguments.device]
        for setting in settings_of(scene_file, method, arguments):
            command += ["--set", setting]
        try:
            run = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=arguments.timeout
            )
        except subprocess.TimeoutExpired:
            return {"status": "timeout"}
        report = out / "report.json"
        if run.returncode != 0 or not report.is_file():
            lines = [line for line in run.stderr.splitlines() if line.startswith("weft: ")]
            lines = [line for line in lines if not line.startswith("weft: warning")]
            message = lines[-1].removeprefix("weft: ") if lines else f"exit code {run.returncode}"
            message = message.removeprefix(f"{scene_file}: ")
            status = "refused" if run.returncode == 2 else "failed"
            return {"status": status, "message": message, "code": run.returncode}
        frames = {
            path.relative_to(out / "frames").as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted((out / "frames").rglob("*"))
            if path.is_file()
        }
        state = json.loads(report.read_text(encoding="utf-8")).get("state_hash")
        return {"status": "done", "hash": state, "frames": frames}


def verdict(old, new):
    """What two outcomes say about each other: (text, whether it is a difference)."""
    statuses = (old["status"], new["status"])
    if statuses == ("done", "done"):
        if old["hash"] is None or not old["frames"]:
            return "DIFFERENT: nothing to compare: a report without state_hash, or no frames", True
        if old["hash"] != new["hash"]:
            return f"DIFFERENT: state {old['hash']}, now {new['hash']}", True
        wrong = sorted(
            name
            for name in old["frames"].keys() | new["frames"].keys()
            if old["frames"].get(name) != new["frames"].get(name)
        )
        if wrong:
            return f"DIFFERENT: {len(wrong)} frame files, the first is {wrong[0]}", True
        return "same", False
    if old["status"] == "timeout":
        return "not compared: time-out" + (" of both" if new["status"] == "timeout" else " of OLD"), False
    if statuses == ("refused", "refused"):
        return f"refused by both: {new['message']}", False
    if statuses == ("failed", "failed") and old["code"] == new["code"]:
        return f"failed in both: {new['message']}", False
    if "refused" in statuses:
        by = "OLD" if old["status"] == "refused" else "NEW"
        message = (old if by == "OLD" else new)["message"]
        return f"refused by one ({by}): {message}", True
    return f"DIFFERENT: OLD {described(old)}, NEW {described(new)}", True


def described(result):
    return result["status"] + (f" ({result['message']})" if "message" in result else "")


def parsed():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n", 1)[0],
        epilog="OLD alone goes with --save, NEW alone with --against.",
    )
    parser.add_argument("programs", nargs="+", metavar="PROGRAM", help="OLD and NEW")
    parser.add_argument("--old-scenes", type=Path, metavar="DIR", help="default: scenes/ of this repository")
    parser.add_argument("--new-scenes", type=Path, metavar="DIR", help="default: scenes/ of this repository")
    parser.add_argument("--scenes", nargs="+", metavar="NAME", help="default: all of the folder")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=METHODS)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--frames", type=int, default=2)
    parser.add_argument("--triangles", type=int, default=2000, help="for scenes with that key; 0: as they are")
    parser.add_argument("--timeout", type=float, default=60, help="seconds per run")
    parser.add_argument("--jobs", type=int, default=1, help="runs at the same time")
    kept = parser.add_mutually_exclusive_group()
    kept.add_argument("--save", type=Path, metavar="FILE", help="keep the results of OLD")
    kept.add_argument("--against", type=Path, metavar="FILE", help="compare with kept results")
    arguments = parser.parse_args()
    wanted = 1 if arguments.against else 2
    if len(arguments.programs) != wanted and not (arguments.save and len(arguments.programs) == 1):
        parser.error(f"{wanted} programs wanted, not {len(arguments.programs)}")
    for program in arguments.programs:
        if not Path(program).is_file():
            parser.error(f"{program}: no such file")
    scenes = Path(__file__).resolve().parents[2] / "scenes"
    arguments.old_scenes = arguments.old_scenes or scenes
    arguments.new_scenes = arguments.new_scenes or scenes
    return parser, arguments


def main():
    parser, arguments = parsed()
    conditions = {key: getattr(arguments, key) for key in ("device", "frames", "triangles")}
    kept = None
    if arguments.against:
        document = json.loads(arguments.against.read_text(encoding="utf-8"))
        if document["conditions"] != conditions:
            parser.error(f"{arguments.against} was kept with {document['conditions']}, not {conditions}")
        kept = document["results"]
    old = None if kept is not None else str(Path(arguments.programs[0]).resolve())
    new = str(Path(arguments.programs[-1]).resolve())
    if arguments.save and len(arguments.programs) == 1:
        new = None

    names = arguments.scenes or scene_names(arguments.old_scenes if new is None else arguments.new_scenes)
    if arguments.scenes is None and kept is not None:
        names = sorted(set(names) | {key.split()[0] for key in kept})
    if not names:
        parser.error("no scenes")
    cases = [(name, method) for name in names for method in arguments.methods]

    def compared(case):
        name, method = case
        before = None
        if old is not None:
            before = outcome(old, arguments.old_scenes / f"{name}.json", method, arguments)
        elif kept is not None:
            before = kept.get(f"{name} {method}", {"status": "missing", "message": "not among the kept results"})
        if new is None:
            return before, None
        return before, outcome(new, arguments.new_scenes / f"{name}.json", method, arguments)

    results = {}
    counts = {}
    differences = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for (name, method), (before, after) in zip(cases, pool.map(compared, cases)):
            results[f"{name} {method}"] = before
            text, different = (described(before), False) if after is None else verdict(before, after)
            differences += different
            kind = text.split(":")[0]
            counts[kind] = counts.get(kind, 0) + 1
            print(f"{name:16} {method:14} {text}", flush=True)
            if arguments.save:
                kept_now = {"conditions": conditions, "results": results}
                arguments.save.write_text(json.dumps(kept_now, indent=1) + "\n", encoding="utf-8")
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
