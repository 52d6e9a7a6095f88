#!/usr/bin/env python3
"""Prints the JSON files of weft_bench_physics as one Markdown table.

    physics_table.py RESULT...                   RESULT: a file that --json wrote, or a directory, whose
                                                 physics_*.json count
    physics_table.py --write README.md RESULT... replaces what stands in that file between the lines
                                                 <!-- physics --> and <!-- /physics -->

Results stand in the order in which they are named, those of a directory by file name. Exit code 2 if
one cannot be read or lacks a figure, or the file has no such lines.
"""

import shlex
import sys

from markdown_table import BadInput, main, markdown, read_object, row

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
        return "not judged"
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


def find_results(paths):
    for path in paths:
        if path.is_dir():
            found = sorted(path.glob("physics_*.json"))
            if not found:
                raise BadInput(f"{path}: holds no physics_*.json")
            yield from found
        else:
            yield path


def read_result(path):
    result = read_object(path)
    if result.get("benchmark") != "physics":
        raise BadInput(f"{path}: not a result of weft_bench_physics")
    return result


def provenance(path, result):
    """Commit and machine of one result."""
    try:
        build, machine = result["build"], result["machine"]
        return (build["commit"] + (" with changes" if build["dirty"] else ""), build["compiler"],
                f"{machine['cpu']}, {machine['threads']} threads")
    except (KeyError, TypeError) as error:
        raise BadInput(f"{path}: no build or machine: {error!r}") from error


def table(paths):
    results = [(path, read_result(path)) for path in find_results(paths)]
    text = markdown(COLUMNS, [row(COLUMNS, path, result) for path, result in results])
    judged = [result for _, result in results if result["tolerance"] is not None]
    passed = sum(1 for result in judged if result["passes"])
    sources = sorted({provenance(path, result) for path, result in results})
    origin = "; ".join(f"commit {commit} ({compiler}) on {machine}"
                       for commit, compiler, machine in sources)
    return text + f"\n{passed} of {len(judged)} within tolerance. Measured at {origin}.\n"


if __name__ == "__main__":
    sys.exit(main("physics_table.py", __doc__,
                  "a file that --json wrote, or a directory of them", table, BEGIN, END))
