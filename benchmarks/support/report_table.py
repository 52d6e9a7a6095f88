#!/usr/bin/env python3
"""Prints the report.json files of finished runs as one Markdown table.

    report_table.py REPORT...                   REPORT: a report.json, the directory of a run, or
                                                several reports as suite_file.py writes them
    report_table.py --write DOCUMENT REPORT...  replaces the part of that file between the lines
                                                <!-- reports --> and <!-- /reports -->

Exit code 2 if a report cannot be read or lacks a figure, or the file has no such lines.
"""

import sys

from markdown_table import main, markdown, row
from suite_file import read_cases

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


def read_reports(path):
    """The reports at `path`, which may be the directory of a run."""
    return read_cases(path / "report.json" if path.is_dir() else path).items()


def cells(path, report):
    """The cells of one report. A run that stopped early says so beside its scene."""
    texts = row(COLUMNS, path, report)
    if "failure" in report:
        texts[0] += " (not finished)"
    return texts


def table(paths):
    return markdown(COLUMNS, [cells(f"{path}: {case}", report) for path in paths
                              for case, report in read_reports(path)])


if __name__ == "__main__":
    sys.exit(main("report_table.py", __doc__,
                  "a report.json, the directory of a run, or several reports", table, BEGIN, END))
