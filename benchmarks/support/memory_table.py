#!/usr/bin/env python3
"""Prints what device memory is for as a Markdown table, a row a use, a column a result.

    memory_table.py RESULT...                   RESULT: a report.json, a file that --json of
                                                weft_bench_drape or weft_bench_roofline wrote, or
                                                several of these as suite_file.py writes them
    memory_table.py --write NOTES RESULT...     replaces the part of that file between the lines
                                                <!-- memory --> and <!-- /memory -->

Figures are MB, at most held by any rank; a drape on several sets of devices has a column a set. Exit
code 2 if a file cannot be read or lacks the figures, or there are no such lines.
"""

import sys

from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN = "<!-- memory -->"
END = "<!-- /memory -->"


def heading(result, device):
    return f"{result.get('scene', '?')}, {result['triangle_count']:,} triangles, {device}"


def columns_of(path, result):
    """(heading, the uses of each rank) of each set of devices in a result."""
    try:
        if "series" in result:
            return [(heading(result, series["device"]),
                     series["samples"][0]["peak_device_bytes_by_use"])
                    for series in result["series"]]
        if "peak_bytes" in result:
            ranks = result["peak_bytes"]["device_by_use"]
        else:
            ranks = [result["peak_device_bytes_by_use"]]
        return [(heading(result, result["device"]), ranks)]
    except (KeyError, TypeError, IndexError) as error:
        raise BadInput(f"{path}: no figures of memory: {error!r}") from error


def table(paths):
    found = [column for path in paths for case, result in read_cases(path).items()
             for column in columns_of(f"{path}: {case}", result)]
    # Of each use the rank with most, and of the sums.
    most = [{use: max(rank.get(use, 0) for rank in ranks) for rank_ in ranks for use in rank_}
            for _, ranks in found]
    uses = sorted({use for column in most for use in column},
                  key=lambda use: -max(column.get(use, 0) for column in most))
    number = lambda count: f"{1e-6 * count:,.1f}"
    rows = [[use] + [number(column.get(use, 0)) for column in most] for use in uses]
    rows.append(["all"] + [number(max(sum(rank.values()) for rank in ranks))
                           for _, ranks in found])
    columns = [("MB", False, None)] + [(title, True, None) for title, _ in found]
    return markdown(columns, rows)


if __name__ == "__main__":
    sys.exit(main("memory_table.py", __doc__, "a report.json, or what a benchmark wrote", table,
                  BEGIN, END))
