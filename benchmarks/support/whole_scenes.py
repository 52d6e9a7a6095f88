#!/usr/bin/env python3
"""Scenes to their last frame by some methods, and what `weft check` finds in every frame.

    whole_scenes.py WEFT SCENES RESULT.json --method M... [--fails SCENE]... [--jobs N]
                    [--device D] [--scratch DIR]
                                    runs the scenes of a folder, N at a time
    whole_scenes.py --table RESULT.json
                                    prints what became of them

A scene that a method refuses (exit code 2), or that ends with a failure (4), is listed with the
line that says why. Frames are deleted once they have been looked at. Exit code 4 if a frame was not
clean, or a run ended otherwise than with 0 or 2, or with 4 where --fails says so.
"""

import argparse
import concurrent.futures
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from markdown_table import markdown

REFUSED, FAILED = 2, 4


def one(arguments, scene, method):
    with tempfile.TemporaryDirectory(dir=arguments.scratch) as scratch:
        out = Path(scratch) / "run"
        start = time.monotonic()
        run = subprocess.run(
            [arguments.weft, "run", str(scene), "-o", str(out), "--no-preview", "--method", method,
             "--device", arguments.device], capture_output=True, text=True, check=False)
        result = {"scene": scene.stem, "method": method, "exit": run.returncode,
                  "wall_s": time.monotonic() - start}
        if run.returncode != 0:
            lines = run.stderr.strip().splitlines() or run.stdout.strip().splitlines() or [""]
            result["message"] = lines[-1].replace(str(scene), scene.name).split("; checkpoint ")[0]
        if run.returncode == REFUSED:
            return result
        report = json.loads((out / "report.json").read_text())
        result |= {key: report[key] for key in ("build", "device", "precision", "steps",
                                                "state_hash")}
        check = subprocess.run([arguments.weft, "check", str(out), "--json"], capture_output=True,
                               text=True, check=False)
        frames = json.loads(check.stdout)["frames"]
        result["frames"] = len(frames)
        result["clean"] = sum(frame["clean"] for frame in frames)
        result["check"] = check.returncode
        return result


def good(result, failing):
    if result["exit"] == REFUSED:
        return True
    return (result["exit"] == (FAILED if result["scene"] in failing else 0)
            and result["check"] == 0 and result["clean"] == result["frames"])


def run_all(arguments):
    scenes = sorted(p for p in arguments.scenes.glob("*.json") if "schema" not in p.name)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        runs = list(pool.map(lambda job: one(arguments, *job),
                             [(s, m) for m in arguments.method for s in scenes]))
    build = next((r["build"] for r in runs if "build" in r), None)
    for run in runs:
        run.pop("build", None)
    machine = subprocess.run([arguments.weft, "info"], capture_output=True, text=True, check=False)
    result = {"benchmark": "whole_scenes", "build": build, "command": sys.argv[1:],
              "machine": machine.stdout.splitlines(), "runs": runs}
    arguments.result.write_text(json.dumps(result, indent=1) + "\n")
    bad = [f"{r['scene']} by {r['method']}" for r in runs if not good(r, arguments.fails)]
    for name in bad:
        print(f"{name}: see {arguments.result}", file=sys.stderr)
    return 4 if bad else 0


def table(path):
    result = json.loads(path.read_text())
    methods = list(dict.fromkeys(r["method"] for r in result["runs"]))
    rows = {}
    for r in result["runs"]:
        if r["exit"] == REFUSED:
            text = "refused: " + r["message"].split(": ", 2)[-1]
        else:
            text = f"{r['clean']} of {r['frames']} frames clean"
            if r["exit"] != 0:
                text += f", ends with {r['exit']}: " + r["message"].split(": ", 1)[-1]
        rows.setdefault(r["scene"], {})[r["method"]] = text
    columns = [("scene", False, None)] + [(m, False, None) for m in methods]
    print(markdown(columns, [[s, *(texts.get(m, "") for m in methods)]
                             for s, texts in rows.items()]))
    build = result["build"]
    print(f"Commit {build['commit']}{' with changes' if build['dirty'] else ''}; "
          f"{' '.join(result['command'][3:])}.")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    if "--table" in sys.argv:
        parser.add_argument("--table", type=Path, metavar="RESULT")
        return table(parser.parse_args().table)
    parser.add_argument("weft", type=lambda text: shutil.which(text) or text)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("result", type=Path)
    parser.add_argument("--method", action="append", required=True)
    parser.add_argument("--fails", action="append", default=[], metavar="SCENE",
                        help="ends with a failure, as it should")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--device", default="cpu:1")
    parser.add_argument("--scratch", type=Path)
    return run_all(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
