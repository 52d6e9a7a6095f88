#!/usr/bin/env python3
"""Dresses a body in drafted patterns, and says which end clean and worn.

usage: garments.py --program WEFT [--body OBJ | --mannequin] [--triangles 6000] [--keep FOLDER] [--table FILE] [--limit SECONDS]
       [NAME...]

NAME is a pattern of patterns.py or a file NAME_specification.json; default: all of patterns.py. Each goes the way of a
user: `weft convert PATTERN scene.json --body OBJ`, `weft run`, `weft check`, `weft check --worn`; a pattern that is worn
over another one is dressed with it, by `weft convert INNER OUTER scene.json`. The edge length is chosen so that garments have about
--triangles. It passes if the cloth rests, no frame has an intersection, all seams are closed, and the garment is worn.

--body       default: garments/f_smpl_average_A40.obj in the folder that WEFT_TEST_DATA names; without it, exit code 77
--mannequin  the body of mannequin.py
--table      writes commit, machine, and rows of pattern, triangles, CPU seconds, time until rest, clean, worn as Markdown
Exit code: 0 all pass, 1 some do not.
"""
import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import mannequin  # noqa: E402
import patterns  # noqa: E402

DRAFT_EDGE = 0.03  # m


class Weft:
    """The program, in a folder; sums up the CPU time of its runs."""

    def __init__(self, program, folder, limit):
        self.program, self.folder, self.limit, self.seconds = str(pathlib.Path(program).resolve()), folder, limit, 0.0

    def __call__(self, *words):
        """Exit code and output."""
        before = os.times()
        try:
            done = subprocess.run([self.program, *map(str, words)], cwd=self.folder, capture_output=True, text=True,
                                  timeout=self.limit, check=False)
            code, out = done.returncode, done.stdout + done.stderr
        except subprocess.TimeoutExpired:
            code, out = 124, f"no end within {self.limit:g} s"
        after = os.times()
        self.seconds += after.children_user - before.children_user + after.children_system - before.children_system
        return code, out


def specification(name, folder):
    """The file of a pattern, drafted or given."""
    file = folder / f"{name}_specification.json"
    if name in patterns.PATTERNS:
        file.write_text(json.dumps(patterns.PATTERNS[name]().json(), indent=1))
    return file


def scene_of(weft, names, edge, body):
    """Writes scene.json. Names from the inside out."""
    files = [f"{name}_specification.json" for name in names]
    return weft("convert", *files, "scene.json", "--body", body, "--edge", edge)


def triangles_in(weft, names):
    """At the edge length DRAFT_EDGE."""
    count = 0
    for name in names:
        code, out = weft("convert", f"{name}_specification.json", "draft.json", "--edge", DRAFT_EDGE)
        if code != 0:
            return 0, out
        count += int(out.split(" triangles")[0].split()[-1])
    return count, ""


def dress(program, name, body, triangles, folder, limit):
    """A row: name, triangles, CPU seconds, seconds until rest, what is wrong."""
    names = [patterns.OVER[name], name] if name in patterns.OVER else [name]
    for each in names:
        if not specification(each, folder).exists():
            return [name, 0, 0, None, [f"there is no {each}_specification.json in {folder}"]]
    weft = Weft(program, folder, limit)
    count, problem = triangles_in(weft, names)
    if not count:
        return [name, 0, 0, None, [problem.strip()]]
    weft.seconds = 0
    edge = round(DRAFT_EDGE * math.sqrt(count / triangles), 4)
    for step, words in (("convert", None), ("run", ["run", "scene.json", "-o", "out", "--no-preview", "--device", "cpu:1"])):
        code, out = scene_of(weft, names, edge, body) if words is None else weft(*words)
        if code != 0:
            return [name, 0, weft.seconds, None, [f"{step}: {out.strip().splitlines()[-1]}"]]
    seconds = weft.seconds
    report = json.loads((folder / "out" / "report.json").read_text())
    wrong = [] if report["rested"] else ["it does not come to rest"]
    if any(seam["open"] for seam in report["seams"]):
        wrong.append("a seam is open")
    code, out = weft("check", "out", "--worn", "--allow-path", folder)
    if code == 2:
        wrong.append(out.strip())
    clean = "no intersection" in out or code == 0
    faults = [line for line in out.splitlines() if "garment" in line and not line.endswith(": worn")]
    if weft("check", "out")[0] != 0:
        wrong.append("it is not clean")
    if code == 1 and not faults and clean:
        wrong.append(out.strip().splitlines()[-1])
    frame = sorted((folder / "out" / "frames").glob("cloth_*.obj"))[-1]
    made = sum(line.startswith("f ") for line in frame.open())
    return [name, made, seconds, report["rested_at_s"], wrong + faults]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--program", required=True)
    parser.add_argument("--body")
    parser.add_argument("--mannequin", action="store_true")
    parser.add_argument("--triangles", type=int, default=6000)
    parser.add_argument("--keep")
    parser.add_argument("--table")
    parser.add_argument("--limit", type=float, default=600)
    given = parser.parse_args()
    body = given.body
    if body is None and not given.mannequin:
        body = pathlib.Path(os.environ.get("WEFT_TEST_DATA", "")) / "garments" / "f_smpl_average_A40.obj"
        if "WEFT_TEST_DATA" not in os.environ or not body.exists():
            print("skipped: WEFT_TEST_DATA holds no garments/f_smpl_average_A40.obj")
            return 77
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        if given.mannequin:
            body = pathlib.Path(scratch) / "mannequin.obj"
            mannequin.write(body, 0.03)
        body = pathlib.Path(body).resolve()
        for name in given.names or patterns.PATTERNS:
            stem = pathlib.Path(name).name.removesuffix("_specification.json")
            folder = pathlib.Path(given.keep or scratch).resolve() / stem
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            if stem not in patterns.PATTERNS and pathlib.Path(name).exists():
                shutil.copy(name, folder)
            row = dress(given.program, stem, body, given.triangles, folder, given.limit)
            rows.append(row)
            print(f"{row[0]:20} {row[1]:6} triangles {row[2]:6.1f} CPU s, rests at {row[3] or 0:5.2f} s:",
                  "; ".join(row[4]) or "clean and worn", flush=True)
    if given.table:
        info = subprocess.run([given.program, "info"], capture_output=True, text=True, check=True).stdout.splitlines()
        facts = [" ".join(line.split()) for line in info if line.startswith(("commit", "  cpu:"))]
        lines = ["# Garments from pattern to rest", "",
                 f"`garments.py --triangles {given.triangles}`. " + "; ".join(facts) + ".", "",
                 "| pattern | triangles | CPU s | rests at s | |", "|---|---:|---:|---:|---|"]
        lines += [f"| {name.replace('_', ' ')} | {count:,} | {seconds:.1f} | {rest or math.nan:.2f} | "
                  f"{'; '.join(wrong) or 'clean, worn'} |" for name, count, seconds, rest, wrong in rows]
        pathlib.Path(given.table).write_text("\n".join(lines) + "\n")
    failed = [row[0] for row in rows if row[4]]
    print(f"{len(rows) - len(failed)} of {len(rows)} pass" + (": not " + ", ".join(failed) if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
