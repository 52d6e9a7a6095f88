#!/usr/bin/env python3
"""Looks at the page of `weft chart` in Chromium, drawn from charts of benchmarks/results.

- The legend names every method; the scene's own settings are marked and labelled.
- Labels do not cover each other, on a wide screen and on a phone; nothing is wider than the phone.
- A symbol that is tapped says its command; the console stays empty.

usage: chart_page.py --program WEFT [--keep FOLDER]

Exit code 77: there is no Chromium.
"""

import json
import pathlib
import shutil
import subprocess
import sys

import chromium
from chromium import expect

CHARTS = pathlib.Path(__file__).resolve().parents[2] / "benchmarks/results/charts"
NAMES = ("dress_cpu",)


def check(page, file, chart, width, phone):
    page.viewport(width, 844, phone)
    page.open(file)
    where = f"{file.parent.name}, {width} pixels"
    wide = page.run("document.documentElement.scrollWidth")
    expect(wide <= width, f"{where}: the page is {wide} pixels wide")
    legend = page.run("[...document.querySelectorAll('#legend li')].map(item => item.textContent)")
    for name in {point["method"] for point in chart["points"]} | {"your settings"}:
        expect(name in legend, f"{where}: the legend lacks {name}: {legend}")
    labels = page.run("[...document.querySelectorAll('#chart .label')].map(label => {"
                      "const b = label.getBoundingClientRect();"
                      "return [label.textContent, b.left, b.top, b.right, b.bottom]; })")
    expect("your settings" in [label[0] for label in labels], f"{where}: labels {labels}")
    expect(len(labels) >= 5, f"{where}: only {len(labels)} labels")
    for k, (name, left, top, right, bottom) in enumerate(labels):
        expect(left >= 0 and right <= width, f"{where}: {name} is cut off")
        for other in labels[:k]:
            # Boxes of letters have a pixel or two of air.
            covers = left < other[3] - 2 and right > other[1] + 2 and top + 4 < other[4] and bottom - 4 > other[2]
            expect(not covers, f"{where}: {name} covers {other[0]}")
    x, y = page.run("(box => [box.left + box.width / 2, box.top + box.height / 2])"
                    "([...document.querySelectorAll('#chart g')].at(-1).getBoundingClientRect())")
    page.run(f"scrollTo(0, {max(0, y - 400)})")
    y -= page.run("scrollY")
    page.drag((x, y), (x, y), touch=phone)
    note = page.run("getComputedStyle(document.getElementById('note')).display + ' ' +"
                    "document.getElementById('note').textContent")
    expect(note.startswith("block your settings") and "weft run" in note, f"{where}: note {note}")
    expect(not page.problems, f"{where}: {page.problems}")


def check_charts(program, folder, page, keep):
    for name in NAMES:
        shutil.copytree(CHARTS / name, folder / name)
        # 2: there is no gnuplot, which draws other files.
        done = subprocess.run([program, "chart", "--draw", str(folder / name)],
                              capture_output=True, text=True)
        expect(done.returncode in (0, 2), done.stderr)
        chart = json.loads((folder / name / "chart.json").read_text())
        for width, phone in ((1280, False), (390, True)):
            check(page, folder / name / "chart.html", chart, width, phone)
            keep(f"{name}_{width}")
    return f"{', '.join(NAMES)}: as expected, wide and on a phone"


if __name__ == "__main__":
    sys.exit(chromium.main(__doc__, check_charts))
