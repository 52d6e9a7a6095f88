#!/usr/bin/env python3
"""Runs weft_bench_physics for every row of the table in docs/validation.md.

    physics_run.py PROGRAM FILE                 PROGRAM: weft_bench_physics; FILE: holds all results,
                                                an entry per case, in the order of the table
    physics_run.py PROGRAM FILE --only cantil   only cases whose name contains that; repeatable. The
                                                entries of the others stay
    physics_run.py PROGRAM FILE --jobs 2        so many at once; default: the cores of this machine
    physics_run.py PROGRAM FILE --write DOC     then writes the table there (physics_table.py)
    physics_run.py --list                       the cases and their commands

A case that fails or takes longer than its limit leaves an entry that says so. Exit code 1 if a case
misses its tolerance for no known reason, or keeps it although it is known to miss; 2 for bad input.
"""

import argparse
import datetime
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import physics_table
from markdown_table import BadInput, read_object, write_between
from suite_file import read_cases, write_cases

LIMIT_S = 300
MESHES = ("aligned", "rotated", "irregular", "random", "aniso")


def cases():
    """(test, overrides) of each row, in the order of the table."""
    for mesh in MESHES:
        for gamma in ("0.1", "1", "10", "100"):
            yield "cantilever", (f"gamma={gamma}", f"mesh={mesh}")
    for alpha in ("1", "2", "4"):
        yield "tip_load", (f"alpha={alpha}",)
    yield "roll_up", ()
    for nu in ("0", "0.35"):
        yield "lateral_limit", (f"nu={nu}",)
        for ratio in ("0.1", "0.25", "0.5", "1"):
            yield "lateral_buckling", (f"ratio={ratio}", f"nu={nu}")
        for mesh in ("rotated", "irregular", "random"):
            yield "lateral_buckling", ("ratio=0.5", f"nu={nu}", f"mesh={mesh}")
    for mesh in MESHES:
        yield "half_cylinder", (f"mesh={mesh}",)
    yield "half_cylinder", ("mesh=random", "bending=hinge")
    for mesh in MESHES:
        yield "half_cylinder_membrane", (f"mesh={mesh}",)
    for mode in ("1", "2", "3"):
        yield "plate_modes", (f"mode={mode}",)
    for mesh in MESHES:
        yield "patch", (f"mesh={mesh}",)
    yield "membrane_modes", ()
    yield "membrane_modes", ("mode=4",)
    yield "membrane_order", ()
    yield "hanging_sheet", ("mode=1",)
    yield "hanging_sheet", ("mode=2",)
    for nu in ("0", "0.3", "0.5"):
        yield "hencky", (f"nu={nu}",)
    yield "mylar_balloon", ()
    yield "catenary", ()
    yield "hanging_strip", ()
    yield "euler_buckling", ()
    for test in ("amplitude", "free_fall", "order"):
        for integrator in ("implicit_euler", "bdf2"):
            yield test, (f"integrator={integrator}",)
    yield "flight_momentum", ()
    yield "flight_energy", ()
    yield "folded_strip", ()
    yield "sliding_off", ()
    yield "incline_slides", ("mu=0.49",)
    yield "incline_holds", ("mu=0.51",)
    yield "stopping", ()
    yield "capstan", ()
    yield "stick_slip", ("mu=0.1",)
    for fabric in ("silk", "cotton", "denim"):
        yield "cusick_drape", (f"fabric={fabric}",)
        yield "cusick_refinement", (f"fabric={fabric}",)


def case_name(test, overrides):
    """<test>_<overrides>, letters, digits and points only."""
    text = "_".join([test, *(o.replace("=", "_") for o in overrides)])
    return re.sub(r"[^A-Za-z0-9.]+", "_", text)


def command_of(program, test, overrides):
    words = [str(program), test]
    for override in overrides:
        words += ["--set", override]
    return words


def provenance(program):
    """Build and machine, from the program's quickest run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "smoke.json"
        try:
            subprocess.run([program, "--smoke", "--json", path], check=True, capture_output=True,
                           timeout=LIMIT_S)
            return json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError, subprocess.SubprocessError) as error:
            raise BadInput(f"{program}: {error}") from error


def failed(test, overrides, seconds, failure, origin):
    """The result of a case that has none."""
    return {"benchmark": "physics", "test": test, "about": origin["abouts"].get(test, ""),
            "parameters": dict(o.split("=", 1) for o in overrides), "value": None,
            "reference": None, "error": None, "tolerance": 0, "passes": False, "known_miss": None,
            "failure": failure, "more": {}, "wall_s": seconds,
            "command": command_of("weft_bench_physics", test, overrides),
            "build": origin["build"], "machine": origin["machine"],
            "finished": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")}


def abouts(program):
    """What each test is, from the program's list."""
    listed = subprocess.run([program, "--list"], check=True, capture_output=True, text=True)
    found = re.findall(r"^(\w+): (.*)$", listed.stdout, flags=re.MULTILINE)
    return dict(found)


def run_case(program, folder, case, limit, origin):
    """Runs a case with `folder` for its output, and returns the result."""
    test, overrides = case
    path = folder / f"{case_name(test, overrides)}.json"
    command = [*command_of(program, test, overrides), "--json", str(path)]
    begin = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
        failure = (done.stderr.strip().splitlines() or ["no message"])[-1] if done.returncode else ""
    except subprocess.TimeoutExpired:
        failure = f"not done after {limit} s"
    except OSError as error:
        raise BadInput(f"{program}: {error}") from error
    if failure:
        return failed(test, overrides, time.monotonic() - begin, failure, origin)
    # Where the result was written to is of no use to those who repeat it.
    return {**read_object(path), "command": command_of("weft_bench_physics", test, overrides)}


def unexpected(result):
    """Whether a result is neither within its tolerance nor known to miss it."""
    return bool(result["passes"]) == (result["known_miss"] is not None)


def run_all(arguments, chosen):
    """Runs the chosen cases; returns how many came out otherwise than known."""
    origin = provenance(arguments.program)
    origin["abouts"] = abouts(arguments.program)
    known = read_cases(arguments.file) if arguments.file.exists() else {}
    order = [case_name(*case) for case in cases()]
    lock = threading.Lock()
    wrong = []

    def run_one(case, folder):
        result = run_case(arguments.program, Path(folder), case, arguments.limit, origin)
        with lock:
            known[case_name(*case)] = result
            write_cases(arguments.file, {name: known[name] for name in order if name in known})
            wrong.extend([case] if unexpected(result) else [])
            print(f"{physics_table.verdict(result):8.40}  {result['wall_s']:7.1f} s  "
                  f"{' '.join([case[0], *case[1]])}", flush=True)

    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(lambda case: run_one(case, folder), chosen))
    return len(wrong)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", nargs="?", type=Path, help="weft_bench_physics")
    parser.add_argument("file", nargs="?", type=Path, help="holds the results")
    parser.add_argument("--list", action="store_true", help="print the cases")
    parser.add_argument("--only", action="append", default=[], metavar="TEXT",
                        help="only cases whose name contains this; may be repeated")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="cases at once")
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="seconds a case")
    parser.add_argument("--write", type=Path, metavar="FILE", help="then write the table there")
    arguments = parser.parse_args()
    chosen = [case for case in cases()
              if not arguments.only or any(text in case_name(*case) for text in arguments.only)]
    if arguments.list:
        for case in chosen:
            print(shlex.join(command_of("weft_bench_physics", *case)))
        return 0
    try:
        if not arguments.program or not arguments.file:
            raise BadInput("PROGRAM and FILE are missing; --help says more")
        if not chosen:
            raise BadInput("no case is called that; --list shows all")
        begin = time.monotonic()
        wrong = run_all(arguments, chosen)
        print(f"{len(chosen)} cases in {time.monotonic() - begin:.0f} s, {wrong} not as known")
        if arguments.write:
            write_between(arguments.write, physics_table.table([arguments.file]),
                          physics_table.BEGIN, physics_table.END)
    except BadInput as error:
        print(f"physics_run.py: {error}", file=sys.stderr)
        return 2
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
