#!/usr/bin/env python3
"""Prints charts of speed against accuracy as Markdown: the picture, and what is on the front.

    chart_table.py CHART...                   CHART: a folder with the chart.json of `weft chart`,
                                              and chart.svg, which `weft chart --draw CHART` draws
    chart_table.py --write DOCUMENT CHART...  replaces the part of that file between the lines
                                              <!-- charts --> and <!-- /charts -->

Exit code 2 if a chart cannot be read, has no picture or lacks a figure, or there are no such lines.
"""

import os
import sys

from markdown_table import BadInput, main, markdown, read_object

BEGIN = "<!-- charts -->"
END = "<!-- /charts -->"
LIMITS = (0.1, 0.01, 0.001)
HEADS = (("method", False, None), ("to 10 %", False, None), ("to 1 %", False, None),
         ("to 0.1 %", False, None))


def median(point):
    return point["seconds"][len(point["seconds"]) // 2]


def is_drawn(point):
    return not point["failure"] and point["error"] is not None and point["seconds"]


def best(points, limit):
    """The fastest point up to an error, as text."""
    good = [p for p in points if is_drawn(p) and p["error"] <= limit and p["series"] != "planned"]
    if not good:
        return "none"
    p = min(good, key=median)
    label = "as it is" if p["series"] == "scene" else f"{p['series']}: {p['label']}"
    return f"{median(p):.3g} s ({label}, {100 * p['error']:.2g} %)".replace("|", "\\|")


def commits(points):
    return ", ".join(sorted({p["commit"] for p in points if p.get("commit")}))


def chart_text(folder, base):
    """The text about a chart; `base` is the folder from which it names the picture."""
    chart = read_object(folder / "chart.json")
    if not (folder / "chart.svg").is_file():
        raise BadInput(f"{folder}: has no chart.svg; `weft chart --draw {folder}` draws it")
    try:
        points = chart["points"]
        own = next(p for p in points if p["series"] == "scene")
        methods = list(dict.fromkeys(p["method"] for p in points))
        rows = [[m, *(best([p for p in points if p["method"] == m], limit) for limit in LIMITS)]
                for m in methods]
        failed = [p for p in points if not is_drawn(p)]
        runs = max(len(p["seconds"]) for p in points)
        text = f"**{chart['scene']}, {own['device']}**: `{own['command']}` and {len(points) - 1} "
        text += f"points around it, {runs} runs each"
        if is_drawn(own):
            text += f"; as it is {median(own):.3g} s, {100 * own['error']:.2g} %"
        text += f". {chart['about']} {chart['machine']}; commit {commits(points)}.\n\n"
        text += f"![speed against accuracy of {chart['scene']}]({os.path.relpath(folder / 'chart.svg', base)})\n\n"
        text += markdown(HEADS, rows)
        for p in failed:
            why = p["failure"].split("; checkpoint ")[0]  # a path on the machine that measured
            text += f"\nFailed: {p['series']}: {p['label']} ({p['method']}): {why}\n"
    except (KeyError, TypeError, ValueError, StopIteration) as error:
        raise BadInput(f"{folder}: lacks {error!r}") from error
    return text


def table(folders, base):
    return "\n".join(chart_text(folder, base) for folder in folders)


if __name__ == "__main__":
    sys.exit(main("chart_table.py", __doc__, "a folder with a chart", table, BEGIN, END, links=True))
