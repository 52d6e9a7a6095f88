#!/usr/bin/env python3
"""Prints the results of weft_bench_physics as one Markdown table.

    physics_table.py RESULT...                   RESULT: a file that --json or physics_run.py wrote
    physics_table.py --write DOCUMENT RESULT...  replaces the part of that file between the lines
                                                 <!-- physics --> and <!-- /physics -->

Rows stand in the order of the results. Exit code 2 if one cannot be read or lacks a figure, or the
document has no such lines.
"""

import shlex
import sys

from markdown_table import BadInput, main, markdown, row
from suite_file import read_cases

BEGIN = "<!-- physics -->"
END = "<!-- /physics -->"


def overrides(result):
    """The --set options of the command, "key=value" each."""
    command = result["command"]
    return [command[i + 1] if word == "--set" else word.removeprefix("--set=")
            for i, word in enumerate(command) if word == "--set" or word.startswith("--set=")]


def number(value, digits):
    return "" if value is None else f"{value:.{digits}g}"


def verdict(result):
    if result["tolerance"] is None:
        return "no tolerance"
    if result["passes"]:
        return "pass"
    return "**miss**: " + (result["known_miss"] or result.get("failure") or "reason not known")


def command_text(result):
    """The command as one would type it, without the file that it wrote."""
    words = [f"weft_bench_physics {shlex.quote(result['test'])}"]
    words += ["--set " + shlex.quote(text) for text in overrides(result)]
    return "`" + " ".join(words) + "`"


# Heading, whether it is a number, and how to get the text from a result.
COLUMNS = (
    ("test", False, lambda r: " ".join([r["test"], *overrides(r)])),
    ("what", False, lambda r: r["about"]),
    ("value", True, lambda r: number(r["value"], 7)),
    ("reference", True, lambda r: number(r["reference"], 7)),
    ("error", True, lambda r: number(r["error"], 2)),
    ("tolerance", True, lambda r: number(r["tolerance"] or None, 2)),
    ("verdict", False, verdict),
    ("s", True, lambda r: f"{r['wall_s']:.2g}"),
    ("command", False, command_text),
)


def read_results(path):
    """The results of a file, each with the words that name it in errors."""
    for case, result in read_cases(path).items():
        if not isinstance(result, dict) or result.get("benchmark") != "physics":
            raise BadInput(f"{path}: {case}: not a result of weft_bench_physics")
        yield f"{path}: {case}", result


def outcome(results):
    """How many results are within tolerance, and how many have one."""
    tested = [result for result in results if result["tolerance"] is not None]
    return sum(1 for result in tested if result["passes"]), len(tested)


def provenance(name, result):
    """Commit and machine of one result."""
    try:
        build, machine = result["build"], result["machine"]
        return (build["commit"] + (" with changes" if build["dirty"] else ""), build["compiler"],
                f"{machine['cpu']}, {machine['threads']} threads")
    except (KeyError, TypeError) as error:
        raise BadInput(f"{name}: no build or machine: {error!r}") from error


def table(paths):
    results = [found for path in paths for found in read_results(path)]
    text = markdown(COLUMNS, [row(COLUMNS, name, result) for name, result in results])
    passed, tested = outcome([result for _, result in results])
    sources = sorted({provenance(name, result) for name, result in results})
    origin = "; ".join(f"commit {commit} ({compiler}) on {machine}"
                       for commit, compiler, machine in sources)
    return text + f"\n{passed} of {tested} within tolerance. Measured at {origin}.\n"


if __name__ == "__main__":
    sys.exit(main("physics_table.py", __doc__,
                  "a file that --json or physics_run.py wrote", table, BEGIN, END))
