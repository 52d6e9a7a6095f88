#!/usr/bin/env python3
"""Prints the report.json files of finished runs as one Markdown table.

    report_table.py REPORT...                   REPORT: a report.json, or the directory of a run
    report_table.py --write README.md REPORT... replaces what stands in that file between the lines
                                                <!-- reports --> and <!-- /reports -->

Exit code 2 if a report cannot be read or lacks a figure, or the file has no such lines.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

BEGIN = "<!-- reports -->"
END = "<!-- /reports -->"

# Heading, whether it is a number, and how to get the text from a report.
COLUMNS = (
    ("scene", False, lambda r: r["scene"]),
    ("triangles", True, lambda r: f"{r['triangle_count']:,}"),
    ("device", False, lambda r: r["device"]),
    ("steps", True, lambda r: f"{r['steps']:,}"),
    ("wall s per simulated s", True, lambda r: f"{r['wall_s'] / r['simulated_s']:.3g}"),
    ("PCG iterations, mean", True, lambda r: f"{r['solver']['iterations_mean']:.1f}"),
    ("impacts", True, lambda r: f"{r['contacts']['impacts_total']:,}"),
    ("retries", True, lambda r: f"{r['contacts']['retries']:,}"),
    ("intersections", True, lambda r: f"{r['intersections']:,}"),
    ("state hash", False, lambda r: f"`{r['state_hash']}`"),
)


class BadInput(Exception):
    """One line for the user."""


def read_report(path):
    """The report at `path`, which may be the directory of a run."""
    if path.is_dir():
        path = path / "report.json"
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from error
    if not isinstance(report, dict):
        raise BadInput(f"{path}: not a JSON object")
    return path, report


def row(path, report):
    """The cells of one report. A run that stopped early says so beside its scene."""
    cells = []
    for heading, _, text in COLUMNS:
        try:
            cells.append(text(report).replace("|", "\\|"))
        except (KeyError, TypeError, ValueError, AttributeError, ZeroDivisionError) as error:
            raise BadInput(f"{path}: no figure for '{heading}': {error!r}") from error
    if "failure" in report:
        cells[0] += " (not finished)"
    return cells


def table(paths):
    rows = [row(*read_report(path)) for path in paths]
    lines = [[heading for heading, _, _ in COLUMNS],
             ["---:" if number else "---" for _, number, _ in COLUMNS], *rows]
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def write_between(path, text, begin, end):
    """Replaces what stands between the two marked lines, and the file as a whole or not at all."""
    try:
        old = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from error
    lines = old.splitlines(keepends=True)
    marks = [[i for i, line in enumerate(lines) if line.strip() == mark] for mark in (begin, end)]
    if [len(found) for found in marks] != [1, 1] or marks[0][0] >= marks[1][0]:
        raise BadInput(f"{path}: needs one line {begin} and after it one line {end}")
    new = "".join(lines[: marks[0][0] + 1]) + "\n" + text + "\n" + "".join(lines[marks[1][0]:])
    if new == old:
        return
    path = path.resolve()
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(new)
        os.chmod(temporary, path.stat().st_mode & 0o777)
        os.replace(temporary, path)
    except OSError as error:
        raise BadInput(f"{path}: {error}") from error


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("reports", nargs="+", type=Path, metavar="REPORT",
                        help="a report.json, or the directory of a run")
    parser.add_argument("--write", type=Path, metavar="FILE",
                        help=f"replace what stands between {BEGIN} and {END} there")
    arguments = parser.parse_args()
    try:
        text = table(arguments.reports)
        if arguments.write:
            write_between(arguments.write, text, BEGIN, END)
        else:
            sys.stdout.write(text)
    except BadInput as error:
        print(f"report_table.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
