#!/usr/bin/env python3
"""Puts results into a file of a suite of benchmarks: one suite, one machine, an entry per case.

    suite_file.py FILE CASE=RESULT...    RESULT: a file that --json of a benchmark wrote

FILE is {"suite": NAME, "cases": {CASE: RESULT, ...}} with one line per case, and is made if it is
missing; a case that it holds already is replaced. Exit code 2 if a file cannot be read or written.
"""

import argparse
import json
import sys
from pathlib import Path

from markdown_table import BadInput, read_object, replace_file


def read_cases(path):
    """The results of a file by case. A file that holds one bare result has one case, its name."""
    found = read_object(path)
    if "cases" not in found or "suite" not in found:
        return {path.stem: found}
    if not isinstance(found["cases"], dict):
        raise BadInput(f"{path}: \"cases\" is no JSON object")
    return found["cases"]


def write_cases(path, cases):
    """Writes all cases of a suite, which is called like its file."""
    lines = ",\n".join(f" {json.dumps(name)}: {json.dumps(result)}" for name, result in cases.items())
    replace_file(path, f'{{"suite": {json.dumps(path.stem)}, "cases": {{\n{lines}\n}}}}\n')


def put_case(path, case, result):
    """Adds a case to the file of a suite, or replaces it there."""
    cases = read_cases(path) if path.exists() else {}
    cases[case] = result
    write_cases(path, cases)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("cases", nargs="+", metavar="CASE=RESULT")
    arguments = parser.parse_args()
    try:
        for text in arguments.cases:
            case, equals, result = text.partition("=")
            if not (case and equals and result):
                raise BadInput(f"{text}: is not CASE=RESULT")
            put_case(arguments.file, case, read_object(Path(result)))
    except BadInput as error:
        print(f"suite_file.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
