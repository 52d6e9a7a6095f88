#!/usr/bin/env python3
"""Measures the library as its users meet it: sizes, times to import and to the first step, copies,
and a body that moves in every frame.

    library_figures.py BUILD FILE                              --repeats N
    library_figures.py --write docs/library.md FILE            the table

BUILD: a build folder with the Python package. FILE: the results. Processes of their own, medians.
Exit code 2 for bad input.
"""

import argparse
import datetime
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from jitter_runs import processor
from markdown_table import BadInput, markdown, read_object, replace_file, write_between

ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- figures -->", "<!-- /figures -->"
SHEET = """
import numpy
def sheet(n):
    side = numpy.linspace(0, 0.5, n + 1)
    x, y = numpy.meshgrid(side, side)
    a = (numpy.arange(n)[:, None] * (n + 1) + numpy.arange(n)).ravel()
    faces = numpy.concatenate([numpy.stack([a, a + 1, a + n + 2], 1), numpy.stack([a, a + n + 2, a + n + 1], 1)])
    return numpy.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), faces
"""
IMPORT = """
import numpy, time
start = time.perf_counter()
import weft
print(time.perf_counter() - start)
"""
FIRST_STEP = SHEET + """
import time
start = time.perf_counter()
import weft
scene = weft.Scene()
scene.add_cloth(*sheet(31), fabric="denim")
simulation = weft.Simulation(scene, "cpu:1")
simulation.advance(scene.time_step)
print(time.perf_counter() - start)
"""
POSITIONS = SHEET + """
import statistics, time, tracemalloc
import weft
scene = weft.Scene()
cloth = scene.add_cloth(*sheet(316), fabric="denim")
simulation = weft.Simulation(scene, "cpu:1")
x = simulation.positions(cloth)
other = numpy.empty_like(x)
reads, copies = [], []
tracemalloc.start()
before = tracemalloc.get_traced_memory()[0]
for _ in range(50):
    start = time.perf_counter()
    y = simulation.positions(cloth)
    reads.append(time.perf_counter() - start)
    start = time.perf_counter()
    numpy.copyto(other, y)
    copies.append(time.perf_counter() - start)
tracemalloc.stop()
assert y.ctypes.data == x.ctypes.data
print(len(x), statistics.median(reads), statistics.median(copies))
"""


def run(command, environment=None):
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True,
                              env={**os.environ, **(environment or {})})
    except (OSError, subprocess.CalledProcessError) as error:
        raise BadInput(f"{command[0]}: {getattr(error, 'stderr', '') or error}") from error
    return done.stdout.strip()


def python(build, program):
    return run(["/usr/bin/python3", "-c", program], {"PYTHONPATH": str(build / "python")})


def size(path):
    return path.stat().st_size


def stripped(path, folder):
    copy = folder / path.name
    run(["strip", "--strip-debug", "-o", str(copy), str(path)])
    return size(copy)


def measure(build, repeats):
    with tempfile.TemporaryDirectory(prefix="library_") as name:
        folder = Path(name)
        prefix, examples = folder / "prefix", folder / "examples"
        run(["cmake", "--install", str(build), "--prefix", str(prefix)])
        run(["cmake", "-S", str(ROOT / "examples"), "-B", str(examples), f"-DCMAKE_PREFIX_PATH={prefix}",
             "-DCMAKE_BUILD_TYPE=Release"])
        run(["cmake", "--build", str(examples)])
        libraries = {f.name: stripped(f, folder) for f in prefix.rglob("libweft*.a")}
        extension = next((build / "python/weft").glob("_weft*.so"))
        loop = run([str(examples / "weft_example_game_loop"), "20"])
        found = re.search(r"(\d+) vertices of cloth on (\d+) .*: (\d+) frames of ([\d.]+) ms, median "
                          r"([\d.]+) ms, 95 % below ([\d.]+) ms", loop)
        if not found:
            raise BadInput(f"game_loop: {loop}")
        vertices, read, copy = python(build, POSITIONS).split()
        return {
            "library_bytes": libraries,
            "python_bytes": stripped(extension, folder),
            "import_s": statistics.median(float(python(build, IMPORT)) for _ in range(repeats)),
            "first_step_s": statistics.median(float(python(build, FIRST_STEP)) for _ in range(repeats)),
            "first_step_triangles": 2 * 31 * 31,
            "positions": {"vertices": int(vertices), "read_s": float(read), "copy_s": float(copy)},
            "game_loop": dict(zip(("cloth_vertices", "body_vertices", "frames", "frame_ms", "median_ms",
                                   "most_ms"), map(float, found.groups()))),
        }


def table(paths):
    rows, origins = [], []
    for path in paths:
        result = read_object(Path(path))
        try:
            loop, positions = result["game_loop"], result["positions"]
            megabytes = [f"`{name}` {size / 1e6:.1f} MB" for name, size in sorted(result["library_bytes"].items())]
            rows += [
                ["size, without debug information",
                 ", ".join(megabytes) + f", the Python extension {result['python_bytes'] / 1e6:.1f} MB"],
                ["`import weft`, after NumPy", f"{1e3 * result['import_s']:.0f} ms"],
                [f"`import weft` to the end of the first step, {result['first_step_triangles']:,} triangles",
                 f"{1e3 * result['first_step_s']:.0f} ms"],
                [f"`positions()` of {positions['vertices']:,} vertices in Python, no allocation",
                 f"{1e3 * positions['read_s']:.2f} ms; NumPy copies them in {1e3 * positions['copy_s']:.2f} ms"],
                [f"`game_loop`: {loop['cloth_vertices']:,.0f} vertices on a body of {loop['body_vertices']:,.0f}, "
                 f"frames of {loop['frame_ms']:.1f} ms",
                 f"median {loop['median_ms']:.1f} ms, 95 % below {loop['most_ms']:.1f} ms"],
            ]
            origins.append(f"{result['commit'][:7]}, {result['cores']} cores of {result['cpu']}")
        except (KeyError, TypeError) as error:
            raise BadInput(f"{path}: lacks {error!r}") from error
    text = markdown([("what", False, None), ("measured", False, None)], rows)
    return f"{text}\n{'; '.join(origins)}; `python3 benchmarks/support/library_figures.py build/host-release FILE`.\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", type=Path)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("paths", nargs="+", type=Path)
    arguments = parser.parse_args()
    try:
        if arguments.write:
            write_between(arguments.write, table(arguments.paths), BEGIN, END)
            return 0
        if len(arguments.paths) != 2:
            raise BadInput("BUILD and FILE are wanted")
        build, file = arguments.paths
        result = {"commit": run(["git", "-C", str(ROOT), "rev-parse", "HEAD"]), "cpu": processor(),
                  "cores": os.cpu_count(), "started": datetime.datetime.now().isoformat(timespec="seconds"),
                  "command": sys.argv, **measure(build.resolve(), arguments.repeats)}
        replace_file(file, json.dumps(result, indent=1) + "\n")
    except BadInput as error:
        print(f"library_figures.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
