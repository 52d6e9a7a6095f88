#!/usr/bin/env python3
"""Files of a stranger: refused with one line, or read, and nothing else happens.

usage: hostile.py --program WEFT --class CLASS [--case NAME]      the cases of CLASS/cases.json
       hostile.py --program WEFT --mutants KIND [--case NUMBER]   damaged copies of mutants.json
options: --count N --seed N (of mutants), --jobs N, --keep (the sandboxes of failures),
         --sanitized (a build that is slow and takes much address space)
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import random
import re
import shlex
import socket
import struct
import sys

import sandbox
from sandbox import Sandbox

HERE = pathlib.Path(__file__).resolve().parent
REFUSED, VALID, FAILED, STOPPED = 2, 0, 4, 130

# ------------------------------------------------------------------------------------- checkpoints
CHUNK = struct.Struct("<16sQQ")


def fnv(data):
    value = 14695981039346656037
    for byte in data:
        value = ((value ^ byte) * 1099511628211) & 0xFFFFFFFFFFFFFFFF
    return value


class Checkpoint:
    """A header of magic, version and count, then chunks: name, size, checksum, bytes."""

    def __init__(self, content):
        self.version, count = struct.unpack_from("<II", content, 4)
        self.chunks, at = [], 12
        for _ in range(count):
            name, size, _ = CHUNK.unpack_from(content, at)
            at += CHUNK.size
            self.chunks.append([name.rstrip(b"\0").decode(), bytearray(content[at:at + size])])
            at += size
        self.count, self.claimed = count, {}

    def chunk(self, name):
        return next(c for c in self.chunks if c[0] == name)

    def content(self):
        out = bytearray(b"WEFT" + struct.pack("<II", self.version, self.count))
        for name, data in self.chunks:
            size = self.claimed.get(name, len(data))
            out += CHUNK.pack(name.encode("utf-8", "surrogateescape")[:16], size, fnv(data)) + data
        return out

    def edit(self, change):
        """The keys of a case's "edit"."""
        if "version" in change:
            self.version = change["version"]
        for name in change.get("drop", []):
            self.chunks.remove(self.chunk(name))
            self.count -= 1
        for name in change.get("repeat", []):
            self.chunks.append([name, bytearray(self.chunk(name)[1])])
            self.count += 1
        for name, new in change.get("rename", {}).items():
            self.chunk(name)[0] = new
        for name, count in change.get("resize", {}).items():
            data = self.chunk(name)[1]
            data[:] = (data + bytes(max(0, count - len(data))))[:count]
        for name, at, content in change.get("patch", []):
            content = bytes.fromhex(content)
            data = self.chunk(name)[1]
            data[at:at + len(content)] = content
        self.claimed = change.get("claim", {})
        self.count = change.get("count", self.count)
        out = self.content()
        out = out[:change.get("truncate", len(out))]
        out += bytes.fromhex(change.get("append", ""))
        if "flip" in change:
            out[change["flip"]] ^= 0x40
        return bytes(out)


class Good:
    """A whole checkpoint and its run, made by the program itself, and only once."""

    def __init__(self, program, scale):
        with Sandbox(program, scale) as box:
            scene = box.place(HERE / "scenes" / "plain.json")
            outcome = box.run(["run", str(scene), "-o", "{out}", "--no-preview"])
            if outcome.code != VALID:
                raise SystemExit(f"scenes/plain.json does not run: {outcome.err.decode()}")
            self.files = {p.relative_to(box.out): p.read_bytes() for p in sandbox.files_of(box.out)}
        self.checkpoint = self.files[pathlib.Path("checkpoint_00002.weft")]

    def put(self, folder):
        for name, content in self.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)


# ------------------------------------------------------------------------------------------- cases
def make(box, step, good):
    """Makes what git cannot hold: one entry of a case's "make"."""
    (kind, value), = step.items()
    if kind == "run":
        good.put(box.path(value))
        return
    target = box.path(value if isinstance(value, str) else value[0])
    target.parent.mkdir(parents=True, exist_ok=True)
    name = os.fsencode(target)
    if kind in ("fifo", "socket", "link", "hard") and os.path.isfile(name):
        os.unlink(name)
    if kind == "fifo":
        os.mkfifo(name)
    elif kind == "socket":
        # The name of a socket is short, that of the sandbox may not be.
        here = os.open(os.path.dirname(name), os.O_RDONLY)
        with socket.socket(socket.AF_UNIX) as s:
            s.bind(f"/proc/self/fd/{here}/{target.name}")
        os.close(here)
    elif kind == "folder":
        os.makedirs(name, exist_ok=True)
    elif kind == "link":
        os.symlink(os.fsencode(box.filled(value[1])), name)
    elif kind == "hard":
        os.link(os.fsencode(box.path(value[1])), name)
    elif kind == "sparse":
        with open(name, "ab") as file:
            file.truncate(value[1])
    elif kind == "mode":
        os.chmod(name, int(value[1], 8))
        box.give_away()
    elif kind == "copy":
        box.place(HERE / value[1], str(target))
    elif kind == "repeat":
        with open(name, "w", encoding="utf-8") as file:
            file.write(value[1] + value[2] * value[3] + value[4])
    elif kind == "checkpoint":
        with open(name, "wb") as file:
            file.write(Checkpoint(good.checkpoint).edit(value[1]))
    else:
        raise SystemExit(f"make: {kind} is not known")


# How a file is given to the program, by the key of the case that names it: scene and setting.
USES = {
    "cloth": ("cloth.json", "cloths.0.mesh"),
    "obstacle": ("obstacle.json", "obstacles.0.mesh"),
    "capture": ("capture.json", "obstacles.0.capture.file"),
    "cache": ("cache.json", "obstacles.0.sequence.points"),
    "skinned": ("skinned.json", "obstacles.0.skinned.file"),
    "sequence": ("sequence.json", "obstacles.0.sequence.files"),
}


def arguments_of(case, box):
    """The command line of a case; what it needs is placed."""
    output = [] if case.get("output") == "default" else ["-o", "{out}"]
    end = output + ["--no-preview"]
    if "command" in case:
        return case["command"]
    for key, (scene, setting) in USES.items():
        if key in case:
            box.place(HERE / "scenes" / scene)
            value = json.dumps(box.filled(case[key]))
            return ["run", "{in}/" + scene, "--set", f"{setting}={value}"] + end
    if "resume" in case:
        box.place(HERE / "scenes" / "plain.json")
        return ["run", "{in}/plain.json", "--frames", "3", "--resume", case["resume"]] + end
    if "convert" in case:
        return ["convert", "{in}/" + case["convert"], "{out}/converted_%05d.obj"]
    if "check" in case:
        return ["check", "{in}/" + case["check"]]
    if "set" in case:
        box.place(HERE / "scenes" / "plain.json")
        return ["run", "{in}/plain.json"] + [w for s in case["set"] for w in ("--set", s)] + end
    return ["run", "{in}/" + case["scene"]] + end


def limits_problems(outcome, box):
    if outcome.stopped:
        return [f"did not end within {sandbox.WALL_LIMIT * sandbox.CPU_LIMIT * box.scale:g} s"]
    if outcome.cpu > sandbox.CPU_LIMIT * box.scale:
        return [f"took {outcome.cpu:.2f} s of the processor"]
    return []


def outcome_problems(outcome, codes, says):
    """Exit code, and how many lines there are on standard error."""
    problems = []
    errors = outcome.errors()
    if outcome.code not in codes:
        problems.append(f"exit code {outcome.code}")
    lines = 0 if outcome.code == VALID else 1
    if len(errors) != lines:
        problems.append(f"{len(errors)} lines on standard error, not {lines}")
    if outcome.code == REFUSED:
        for texts in says:
            if not any(text in line for line in errors for text in texts):
                problems.append(f"the line does not name {' or '.join(texts)}")
    return problems


class Cases:
    def __init__(self, options):
        self.options = options
        self.folder = HERE / options.hazard
        self.cases = {c["name"]: c for c in json.loads((self.folder / "cases.json").read_text())["cases"]}
        self.good = None
        if any("checkpoint" in s or "run" in s for c in self.cases.values()
               for s in c.get("make", [])):
            self.good = Good(options.program, options.scale)
        self.label = options.hazard

    def names(self):
        return list(self.cases)

    def expected(self, name):
        case = self.cases[name]
        if case.get("expect", "refused") == "refused":
            return "exit 2 with one line" + "".join(f", which names {t}" for t in case.get("says", []))
        return "exit 0, and outputs that parse" if case["expect"] == "valid" else \
            "exit 0, 2 or 4, and nothing else happens"

    def run(self, name, box):
        """@return problems and the outcome of the last command"""
        case = self.cases[name]
        if case.get("output") == "default":
            box.out = box.work / "out"
        for file in [case.get("scene"), case.get("convert"), case.get("check"),
                     *case.get("with", []), *(case.get(use) for use in USES)]:
            if file and (self.folder / file).is_file():
                box.place(self.folder / file, file)
        arguments = arguments_of(case, box)
        for step in case.get("make", []):
            make(box, step, self.good)
        if case.get("convert"):
            box.out.mkdir(exist_ok=True)
        codes = {"refused": (REFUSED,), "valid": (VALID,), "either": (VALID, REFUSED, FAILED)}[
            case.get("expect", "refused")]
        # A list names alternatives.
        says = [[box.filled(t) for t in ([text] if isinstance(text, str) else text)]
                for text in case.get("says", [])]
        output = box.path(case["writes"]) if "writes" in case else box.out
        before = box.snapshot(output)
        problems = []
        commands = [(arguments, codes, says)] + [(c, (VALID,), []) for c in case.get("then", [])]
        for words, allowed, needed in commands:
            outcome = box.run(words)
            found = limits_problems(outcome, box) + sandbox.told_problems(outcome)
            found += outcome_problems(outcome, allowed, needed)
            found += sandbox.leaks(outcome, output)
            problems += [f"{words[0]}: {problem}" for problem in found]
            if found:
                break
        problems += box.changes(before, box.snapshot(output))
        return problems + sandbox.output_problems(output), arguments, outcome


# ----------------------------------------------------------------------------------------- mutants
NUMBERS = ["0", "-1", "-0.0", "1e-320", "1e39", "1e300", "1e400", "-1e308", "NaN", "Infinity", "inf",
           "0x10", "007", "2147483647", "2147483648", "4294967296", "9223372036854775808",
           "18446744073709551616", "1e-300", "true", "null", '"1"', "[]", "{}", "[0, 0]", "",
           '"a\\u0000b"', '"../../x"', '"/dev/zero"', "-2147483649", "1" * 400]
WORDS = NUMBERS + ["v", "f", "f 1 1 1", "f -1 -2 -3", "end_header", "element face 4000000000", "}", "{",
                   "]", '"', "\\", "\0", "\x1b[2J", "\u202e", "\ufeff", "JOINT", "End Site", "Frames:"]
BYTES = [struct.pack("<i", n) for n in (0, -1, 2**31 - 1, -2**31, 65536)] + [
    struct.pack("<f", float(t)) for t in ("nan", "inf", "1e38", "1e-45", "-0.0")] + [
    struct.pack("<q", 2**63 - 1), struct.pack("<d", float("nan")), struct.pack("<d", 1e300)]
TOKEN = re.compile(rb"[A-Za-z0-9_.+-]+")


def bit_flips(data, other, rng):
    for _ in range(rng.randrange(1, 9)):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def truncation(data, other, rng):
    del data[rng.randrange(len(data)):]


def duplication(data, other, rng):
    at, size = rng.randrange(len(data)), rng.randrange(1, 200)
    data[at:at] = data[at:at + size] * rng.randrange(1, 20)


def removal(data, other, rng):
    at = rng.randrange(len(data))
    del data[at:at + rng.randrange(1, 60)]


def replacement(data, other, rng):
    for _ in range(rng.randrange(1, 4)):
        tokens = list(TOKEN.finditer(data))
        if not tokens:
            return
        numeric = [t for t in tokens if t.group()[:1].isdigit()]
        token = rng.choice(numeric if numeric and rng.random() < 0.7 else tokens)
        word = rng.choice(NUMBERS if rng.random() < 0.7 else WORDS)
        data[token.start():token.end()] = word.encode()


def overwriting(data, other, rng):
    content = rng.choice(BYTES)
    at = rng.randrange(len(data))
    at -= at % 4 if rng.random() < 0.8 else 0
    data[at:at + len(content)] = content


def splice(data, other, rng):
    at, of = rng.randrange(len(data)), rng.randrange(len(other))
    data[at:] = other[of:] if rng.random() < 0.5 else other[of:of + 100] + data[at:]


TEXT = [bit_flips, truncation, duplication, removal, replacement, replacement, replacement, splice]
BINARY = [bit_flips, truncation, duplication, removal, overwriting, overwriting, splice]


class Mutants:
    """Mutant n of a seed is the same on every machine."""

    def __init__(self, options):
        self.options = options
        self.label = "mutants " + options.mutants
        kinds = json.loads((HERE / "mutants.json").read_text())
        if options.mutants not in kinds:
            raise SystemExit(f"--mutants: {options.mutants} is not one of {', '.join(kinds)}")
        self.seeds = kinds[options.mutants]
        self.good = Good(options.program, options.scale)

    def names(self):
        # The seeds themselves are whole, or their mutants would tell nothing.
        return ["whole " + s["as"] for s in self.seeds] + [str(n) for n in range(self.options.count)]

    def expected(self, name):
        return "exit 0" if name.startswith("whole ") else \
            "exit 0, or 2 or 4 with one line, and nothing else happens"

    def content_of(self, seed):
        return self.good.checkpoint if "checkpoint" in seed else (HERE / seed["file"]).read_bytes()

    def mutant(self, seed, rng):
        data = bytearray(self.content_of(seed))
        other = self.content_of(rng.choice(self.seeds))
        if "checkpoint" in seed and rng.random() < 0.6:
            # With right checksums, so that the damage is not found by these.
            whole = Checkpoint(data)
            chunk = rng.choice([c for c in whole.chunks if c[1]])[1]
            rng.choice(BINARY)(chunk, bytes(chunk), rng)
            return bytes(whole.content())
        text = b"\0" not in data
        for _ in range(rng.choice((1, 1, 1, 2, 3))):
            if data:
                rng.choice(TEXT if text else BINARY)(data, other, rng)
        return bytes(data)

    def run(self, name, box):
        rng = random.Random(f"{self.options.mutants} {self.options.seed} {name}")
        undamaged = name.startswith("whole ")
        if undamaged:
            seed = next(s for s in self.seeds if name == "whole " + s["as"])
            content = self.content_of(seed)
        else:
            seed = rng.choice(self.seeds)
            content = self.mutant(seed, rng)
        case = {seed["use"]: seed["as"]}
        for file in seed.get("with", []):
            box.place(HERE / file)
        arguments = arguments_of(case, box)
        if "checkpoint" in seed:
            self.good.put(box.out)
            box.path(seed["as"]).unlink()
        box.path(seed["as"]).write_bytes(content)
        if "convert" in case:
            box.out.mkdir()
        before = box.snapshot(box.out)
        seconds = seed.get("seconds", sandbox.CPU_LIMIT)
        outcome = box.run(arguments, True, seconds)
        problems = sandbox.told_problems(outcome) + sandbox.leaks(outcome, box.out)
        codes = [VALID] if undamaged else [VALID, REFUSED, FAILED]
        if outcome.stopped and not undamaged:
            # A scene may ask for many steps: then it has begun, and ends when it is told to. It may
            # also reach its end at that moment, but not long after.
            late = outcome.code != STOPPED and outcome.cpu > 1.5 * seconds * self.options.scale
            if late or not (box.out / "steps.jsonl").is_file():
                problems.append("took too long, and does no steps")
            codes.append(STOPPED)
        problems += outcome_problems(outcome, codes, [])
        problems += box.changes(before, box.snapshot(box.out))
        return problems + sandbox.output_problems(box.out), arguments, outcome


# ------------------------------------------------------------------------------------------ report
def report(suite, name, problems, arguments, outcome, box, options):
    again = [sys.executable, __file__, "--program", options.program]
    again += ["--class", options.hazard] if options.hazard else \
        ["--mutants", options.mutants, "--seed", str(options.seed), "--count", str(options.count)]
    again += ["--case", name, "--keep"] + (["--sanitized"] if options.sanitized else [])
    lines = [f"FAILED {suite.label}: {name}", f"  expected: {suite.expected(name)}"]
    lines += [f"  found: {problem!s}"[:400] for problem in problems]
    lines += [f"  standard error: {line!r}"[:400] for line in outcome.err.splitlines()[:3]]
    lines += [f"  command: weft {shlex.join(box.filled(a) for a in arguments)}"[:600],
              f"  repeat: {shlex.join(again)}"]
    if options.keep:
        lines.append(f"  sandbox: {box.root}")
    print("\n".join(lines).encode("utf-8", "backslashreplace").decode(), flush=True)


def run_one(suite, name, options):
    """@return whether all is well"""
    box = Sandbox(options.program, options.scale)
    try:
        problems, arguments, outcome = suite.run(name, box)
        if problems:
            report(suite, name, problems, arguments, outcome, box, options)
        return not problems
    except PermissionError as error:
        # The program lies where the user whom permissions bind may not go.
        print(f"skipped {suite.label}: {name}: {error}")
        return True
    finally:
        if not options.keep:
            box.remove()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--class", dest="hazard")
    what.add_argument("--mutants")
    parser.add_argument("--case")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--sanitized", action="store_true")
    options = parser.parse_args()
    options.scale = 10.0 if options.sanitized else 1.0
    if not options.sanitized:
        sandbox.limit_memory()
    suite = Cases(options) if options.hazard else Mutants(options)
    names = [options.case] if options.case else suite.names()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        good = list(pool.map(lambda name: run_one(suite, name, options), names))
    print(f"{suite.label}: {len(good)} cases, {good.count(False)} failed")
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
