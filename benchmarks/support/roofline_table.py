#!/usr/bin/env python3
"""Prints a JSON file of weft_bench_roofline as a Markdown table, a row a kernel.

    roofline_table.py RESULT...               RESULT: a file that --json or suite_file.py wrote; a
                                              table per case, one below the other
    roofline_table.py --write NOTES RESULT... replaces the part of that file between the lines
                                              <!-- roofline --> and <!-- /roofline -->

Exit code 2 if a file cannot be read or lacks a figure, or there are no such lines.
"""

import sys

from markdown_table import BadInput, main, markdown, row
from suite_file import read_cases

BEGIN = "<!-- roofline -->"
END = "<!-- /roofline -->"


def number(value, digits):
    """"-" for what is not known."""
    return "-" if value is None else f"{value:,.{digits}f}"


# Heading, whether it is a number, and how to get the text from a kernel.
COLUMNS = (
    ("kernel", False, lambda k: k["kernel"]),
    ("launches a step", True, lambda k: number(k["launches_per_step"], 1)),
    ("MB", True, lambda k: "-" if k["bytes"] is None else number(1e-6 * k["bytes"], 2)),
    ("floor, us", True, lambda k: number(k["floor_us"], 1)),
    ("measured, us", True, lambda k: number(k["us"], 1)),
    ("x of floor", True, lambda k: number(k["ratio"], 2)),
    ("ms a step", True, lambda k: number(k["ms_per_step"], 3)),
)


def about(path, result):
    """What the table is of, in a line."""
    try:
        step = result["step"]
        cloth = result["resolved_scene"]["cloths"][0]
        kernels = sum(kernel["ms_per_step"] for kernel in result["kernels"])
        return (
            f"`{result['scene']}`, {result['triangle_count']:,} triangles of `{cloth['material']}`, "
            f"{step['steps']} steps from {result['from_s']:g} s on, `{result['device']}`, commit "
            f"{result['build']['commit'][:7]}: {step['iterations']:.0f} iterations, "
            f"{step['contacts_max']:,} contacts and {step['pairs_max']:,} pairs a step; "
            f"copies move {result['copy_tb_per_s']:.2f} TB/s, an empty launch takes "
            f"{result['empty_launch_us']:.1f} us, a step without clocks "
            f"{step['ms_without_clocks']:.2f} ms, its kernels {kernels:.2f} ms.\n\n")
    except (KeyError, TypeError, IndexError, ValueError) as error:
        raise BadInput(f"{path}: no figure: {error!r}") from error


def table(paths):
    tables = []
    for path in paths:
        for case, result in read_cases(path).items():
            name = f"{path}: {case}"
            text = about(name, result)
            rows = [row(COLUMNS, name, kernel) for kernel in result["kernels"]]
            tables.append(text + markdown(COLUMNS, rows))
    return "\n".join(tables)


if __name__ == "__main__":
    sys.exit(main("roofline_table.py", __doc__, "a file that weft_bench_roofline --json wrote", table,
                  BEGIN, END))
