#!/usr/bin/env python3
"""Checks that no identifier has a name that docs/glossary.md has replaced.

    check_glossary.py ROOT         prints one line per violation; exit code 1 if there is any
    check_glossary.py --self-test  shows that the check finds each banned name

Only the names listed here are banned, each with its successor. Common words such as `end`, `near`,
`front`, `link` or `factor` are right or wrong where they stand, so they are not listed.
"""

import re
import sys
import tempfile
from pathlib import Path

FOLDERS = ("host", "cuda", "include", "tests", "benchmarks")
SUFFIXES = {".hpp", ".cpp", ".cu", ".cuh", ".h", ".py", ".txt", ".cmake"}
# Files that hold old names on purpose: this list, and the test that old keys are refused.
EXCEPT = ("tests/support/check_glossary.py", "tests/golden/renamed_keys.cpp", "host/io/json/json_fields.cpp")

BANNED = {
}


def violations(root, banned):
    """Yields one message per banned identifier and line of the tree at `root`."""
    if not banned:
        return
    pattern = re.compile(r"(?<!\w)(" + "|".join(sorted(banned, key=len, reverse=True)) + r")(?!\w)")
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            own = path.relative_to(root).as_posix()
            if path.suffix not in SUFFIXES or not path.is_file() or own in EXCEPT:
                continue
            text = path.read_text(encoding="utf-8", errors="replace")
            for match in pattern.finditer(text):
                line = text.count("\n", 0, match.start()) + 1
                yield f"{own}:{line}: {match.group(1)} is now {banned[match.group(1)]}"


def self_test():
    """Plants each banned name; returns the exit code."""
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve()
        (root / "host").mkdir()
        for old in BANNED or ["none"]:
            (root / "host/planted.cpp").write_text(f"int {old} = 0;\nint {old}_more = 0;\n")
            banned = BANNED or {"none": "some"}
            if len(list(violations(root, banned))) != 1:
                print(f"not caught: {old}")
                failures += 1
    print(f"{len(BANNED)} names, {failures} failures")
    return 1 if failures else 0


def main():
    if "--self-test" in sys.argv[1:]:
        return self_test()
    root = Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    messages = list(violations(root, BANNED))
    for message in messages:
        print(message)
    print(f"{len(BANNED)} banned names, {len(messages)} violations")
    return 1 if messages else 0


if __name__ == "__main__":
    sys.exit(main())
