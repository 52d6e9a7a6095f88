#!/usr/bin/env python3
"""What happens to a run from outside: kills, signals, a full disk, a second run in its directory.

usage: accidents.py --program WEFT --accident kill|signal|full_disk|two_runs
options: --sanitized (a build that is slow), --seed N (of the moments of kills), --keep
"""

import argparse
import contextlib
import json
import os
import pathlib
import random
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time

import sandbox
from sandbox import Sandbox

HERE = pathlib.Path(__file__).resolve().parent
STATE = re.compile(rb"state ([0-9a-f]{16})")
KILLS = 5
PATIENCE = 30  # s; for what has to happen at some time


class Wrong(Exception):
    """What a run did, and should not have done."""


def require(condition, what):
    if not condition:
        raise Wrong(what)


class Run:
    """A run of a scene into box.out."""

    def __init__(self, box, scene, *more):
        self.box = box
        self.started = time.monotonic()
        self.out, self.err = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        self.words = ["run", str(box.place(HERE / "scenes" / scene)), "-o", str(box.out),
                      "--no-preview", *more]
        print("weft", shlex.join(self.words), flush=True)
        self.process = box.start(self.words, stdout=self.out, stderr=self.err)

    def wait_for(self, file):
        """Until the run has written something into a file of its directory."""
        while self.process.poll() is None and time.monotonic() < self.started + PATIENCE * self.box.scale:
            with contextlib.suppress(FileNotFoundError):
                if os.stat(self.box.out / file).st_size > 0:
                    return
            time.sleep(0.005)
        self.process.kill()
        raise Wrong(f"there is no {file}: {self.end()}")

    def end(self, limit=PATIENCE):
        """@return exit code, standard output, lines on standard error that are no warnings"""
        try:
            self.process.wait(limit * self.box.scale)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise Wrong(f"did not end within {limit * self.box.scale:g} s") from None
        self.out.seek(0)
        self.err.seek(0)
        outcome = sandbox.Outcome(self.process.returncode, self.out.read(), self.err.read(), 0)
        problems = sandbox.told_problems(outcome)
        require(not problems, "; ".join(problems))
        return outcome.code, outcome.out, outcome.errors()

    def finished(self):
        """@return hash of the state at the end of a run that has to succeed"""
        code, out, errors = self.end()
        require(code == 0 and not errors, f"exit code {code}, not 0: {errors}")
        found = STATE.search(out)
        require(found, f"no state in {out!r}")
        return found.group(1)


def whole(box):
    """Nothing in the directory is half written."""
    problems = sandbox.output_problems(box.out)
    problems += [f"{p.name} was left behind" for p in sandbox.files_of(box.out) if p.suffix == ".tmp"]
    require(not problems, "; ".join(problems))


def checkpoints(box):
    return sorted(box.out.glob("checkpoint_*.weft"))


# --------------------------------------------------------------------------------------- accidents
def kill(new_box, options):
    """kill -9 at any moment loses nothing that a checkpoint has."""
    with new_box() as box:
        run = Run(box, "long.json")
        reference = run.finished()
        duration = time.monotonic() - run.started
    rng = random.Random(options.seed)
    for _ in range(KILLS):
        with new_box() as box:
            run = Run(box, "long.json")
            time.sleep(rng.uniform(0.02, 1.0) * duration)
            run.process.kill()
            run.process.wait()
            if checkpoints(box):
                state = Run(box, "long.json", "--resume", "latest").finished()
            else:
                state = Run(box, "long.json", "--overwrite").finished()
            require(state == reference, f"the state is {state}, without the kill {reference}")
            whole(box)


def signals(new_box, options):
    """A signal ends the run after the step, with a checkpoint and a report."""
    with new_box() as box:
        reference = Run(box, "long.json").finished()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        with new_box() as box:
            run = Run(box, "long.json")
            run.wait_for("steps.jsonl")
            run.process.send_signal(number)
            code, _, errors = run.end()
            stopped_well(box, number.name, code, errors)
            state = Run(box, "long.json", "--resume", "latest").finished()
            require(state == reference, f"the state is {state}, without the signal {reference}")
            whole(box)
    # Within a step that takes long: there is no line of a step yet.
    with new_box() as box:
        run = Run(box, "slow_step.json")
        run.wait_for("scene.json")
        time.sleep(0.1)
        run.process.send_signal(signal.SIGTERM)
        code, _, errors = run.end()
        stopped_well(box, "SIGTERM in a step", code, errors)


def stopped_well(box, name, code, errors):
    require(code == 130, f"exit code {code} after {name}, not 130: {errors}")
    require(len(errors) == 1, f"{len(errors)} lines after {name}, not 1: {errors}")
    require(checkpoints(box), f"no checkpoint after {name}")
    report = box.out / "report.json"
    require(report.is_file(), f"no report after {name}")
    json.loads(report.read_text("utf-8"))
    whole(box)


def full_disk(new_box, options):
    """The last good checkpoint stays, and the run goes on from it once there is room."""
    with new_box() as box:
        reference = Run(box, "long.json").finished()
        pages = [-(-p.stat().st_size // 4096) + 1 for p in sandbox.files_of(box.out)]
    for share in (0.05, 0.4, 0.6, 0.8):
        with new_box() as box, Disk(box.results, int(sum(pages) * share) * 4096) as disk:
            code, _, errors = Run(box, "long.json").end()
            require(code == 2, f"exit code {code} on a full disk, not 2: {errors}")
            require(len(errors) == 1, f"{len(errors)} lines, not 1: {errors}")
            require(str(box.out) in errors[0], f"the line names no file of the run: {errors[0]}")
            require(all(p.suffix != ".tmp" for p in sandbox.files_of(box.out)),
                    "a temporary file was left behind")
            disk.enlarge()
            if checkpoints(box):
                state = Run(box, "long.json", "--resume", "latest").finished()
            else:
                state = Run(box, "long.json", "--overwrite").finished()
            require(state == reference, f"the state is {state}, with more room {reference}")
            whole(box)


class Disk:
    """A small file system, for as long as it is needed, that a filler leaves little room in."""

    SIZE = 64 << 20

    def __init__(self, folder, room):
        self.folder, self.filler, self.room = str(folder), folder / "filler", room

    def __enter__(self):
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={self.SIZE}", "tmpfs", self.folder],
                       check=True)
        with open(self.filler, "wb") as file:
            os.posix_fallocate(file.fileno(), 0, self.SIZE - self.room)
        return self

    def __exit__(self, *_):
        subprocess.run(["umount", self.folder], check=True)

    def enlarge(self):
        self.filler.unlink()


def two_runs(new_box, options):
    """A directory belongs to one run at a time, and to one run."""
    with new_box() as box:
        reference = Run(box, "long.json").finished()
        files = [p for p in sandbox.files_of(box.out) if p.name != ".weft.lock"]
        before = {p: p.read_bytes() for p in files}
        code, _, errors = Run(box, "long.json").end()
        require(code == 2 and len(errors) == 1, f"exit code {code}, not 2: {errors}")
        for text in (str(box.out), "--resume latest", "--overwrite"):
            require(text in errors[0], f"the line does not name {text}: {errors[0]}")
        after = {p: p.read_bytes() for p in files}
        require(before == after, "the files of the run before are others now")
        state = Run(box, "long.json", "--overwrite").finished()
        require(state == reference, f"the state is {state}, before {reference}")
        whole(box)
    with new_box() as box:
        first = Run(box, "long.json")
        first.wait_for("steps.jsonl")
        for more in ([], ["--overwrite"], ["--resume", "latest"]):
            code, _, errors = Run(box, "long.json", *more).end()
            require(first.process.poll() is None, "the first run was over too early for this test")
            require(code == 2 and len(errors) == 1, f"exit code {code} with {more}, not 2: {errors}")
            for text in (str(box.out), str(first.process.pid)):
                require(text in errors[0], f"the line with {more} does not name {text}: {errors[0]}")
        state = first.finished()
        require(state == reference, f"the state is {state}, alone {reference}")
        whole(box)


ACCIDENTS = {"kill": kill, "signal": signals, "full_disk": full_disk, "two_runs": two_runs}
SKIPPED = 77


def in_own_mounts():
    """Starts this script again where it may mount; what it mounts ends with it."""
    for words in (["unshare", "-m"], ["unshare", "-rm"]):
        with contextlib.suppress(FileNotFoundError):
            if subprocess.run(words + ["true"], stderr=subprocess.DEVNULL, check=False).returncode == 0:
                os.execvp(words[0], words + [sys.executable, *sys.argv, "--mounts"])
    print("SKIPPED: neither root nor user namespaces: no small disk can be made")
    sys.exit(SKIPPED)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--accident", choices=ACCIDENTS, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sanitized", action="store_true")
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--mounts", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.accident == "full_disk" and not options.mounts:
        in_own_mounts()

    @contextlib.contextmanager
    def new_box():
        box = Sandbox(options.program, 10.0 if options.sanitized else 1.0)
        try:
            yield box
        finally:
            if options.keep:
                print("sandbox:", box.root)
            else:
                box.remove()

    accident = ACCIDENTS[options.accident]
    try:
        accident(new_box, options)
    except Wrong as wrong:
        print(f"FAILED accident: {options.accident}\n  expected: {accident.__doc__}\n  found: {wrong}\n"
              f"  repeat: {shlex.join([sys.executable, *sys.argv])}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
