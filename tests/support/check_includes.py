#!/usr/bin/env python3
"""Checks which part of the tree includes which, and that every kernel has all of its files.

    check_includes.py ROOT            prints one line per violation; exit code 1 if there is any
    check_includes.py --strict ROOT   missing CUDA and parity files are violations too
    check_includes.py --table         prints the table of allowed includes as Markdown
    check_includes.py --self-test     shows that each rule catches its violation

The rules are those of ARCHITECTURE.md: data flows one way, no room includes another that includes
it back, kernels of different rooms do not know each other, host and CUDA do not know each other,
and no dependency shows in a public header.
"""

import argparse
import re
import sys
import tempfile
from pathlib import Path

STAGES = ("integrate", "assemble", "solve", "collide", "respond")
SOURCE_SUFFIXES = {".hpp", ".cpp", ".cu", ".cuh", ".h"}
SOURCE_FOLDERS = ("include", "host", "cuda", "tests", "benchmarks")
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)
STD_HEADER = re.compile(r"[a-z0-9_]+")
CUDA_HEADER = re.compile(r"(cuda|cub/|thrust/|cooperative_groups|nccl|nvtx|device_launch_parameters)")

# Lists the element-wise kernels, by including their headers.
ELEMENT_WISE = "include/weft/kernels/element_wise.hpp"
ELEMENT_WISE_KERNEL = re.compile(r'#include "weft/kernels/(\w+/\w+)\.hpp"')

# What only host/app may call.
PROGRAM_ONLY = re.compile(
    r"\b(?:f?printf|f?puts|f?putc|putchar|perror|abort|_?exit|quick_exit|getenv)\s*\(|std::c(?:out|err|log)\b"
)
# Calls that end a child process of the library's, and not the program.
IN_CHILDREN = {("child_trial.cpp", "_exit(")}
COMMENT = re.compile(r"//.*")

# Rooms under host/, from the bottom to the top: a room may include itself, the public headers, and
# the rooms named here. A room stands below all that may include it, so that there is no cycle.
ROOMS = {
    "base": (),
    "input": (),
    "exec": (),
    "integrate": ("exec",),
    "assemble": ("exec",),
    "solve": ("exec",),
    "collide": ("exec",),
    "respond": ("exec",),
    "geometry": ("base", "input"),
    "meshing": (),
    "scene/fabric": (),
    "scene/seams": (),
    "scene": ("base", "input", "geometry", "scene/fabric", "scene/seams"),
    "model": ("base", "geometry", "scene/fabric", "scene/seams", "scene"),
    "state": ("base", "input", "scene/seams", "scene", "model"),
    "implicit/parallel": ("state",),
    "implicit/tracking": ("model",),
    "implicit/linear": (
        "base", "model", "state", "implicit/parallel", "implicit/tracking",
    ),
    "implicit/contact": ("exec", "geometry", "state", "implicit/parallel"),
    "implicit/collision_response": ("model", "state", "implicit/parallel", "implicit/linear"),
    "implicit": (
        "model", "state", "implicit/parallel", "implicit/tracking", "implicit/linear",
        "implicit/contact", "implicit/collision_response",
    ),
    "implicit/sleep": ("exec", "geometry", "scene", "model", "implicit/parallel", "implicit"),
    "view": ("geometry", "scene/seams", "scene", "model"),
    "adaptive": ("base", "geometry", "scene/fabric", "scene/seams", "model", "view"),
    "untangle": ("geometry", "scene/seams", "scene", "model"),
    "asynchronous": ("model", "state"),
    "simulation": (
        "base", "input", "exec", "scene/seams", "scene", "model", "state", "implicit/parallel",
        "implicit/linear", "implicit", "implicit/sleep", "view", "adaptive", "untangle",
        "asynchronous",
    ),
    "time_parallel": (
        "base", "geometry", "scene/seams", "scene", "model", "state", "implicit/tracking", "implicit",
        "adaptive", "untangle", "simulation",
    ),
    "io/json": ("input",),
    "io/mesh": ("base", "input", "geometry"),
    "io/spool": ("base", "input", "io/mesh"),
    "io/usd": ("base", "input", "geometry", "io/mesh", "io/spool"),
    "io/gltf": ("base", "input", "geometry", "scene", "io/spool"),
    "io/animation": ("base", "input", "geometry", "model", "io/mesh", "io/spool", "io/usd"),
    "io/pattern": ("base", "input", "geometry", "meshing", "io/json", "io/mesh"),
    "io/arcsim": ("base", "input", "scene/fabric", "scene", "io/json", "io/mesh"),
    "render": ("geometry", "scene", "io/mesh"),
    "io/scene": (
        "base", "input", "exec", "geometry", "scene/fabric", "scene/seams", "scene", "untangle", "io/json", "io/mesh", "io/usd",
        "io/animation", "io/pattern", "io/arcsim", "render",
    ),
    "lab/check": (),
    "lab/worn": (),
    "lab/chart": ("geometry", "lab/check"),
    "lab/plan": ("geometry", "scene/seams", "scene", "model", "implicit/contact"),
    "app/memory": (),
    "app/process": ("base",),
    "app/run": (
        "base", "input", "exec", "scene", "time_parallel", "io/mesh", "io/spool", "io/usd",
        "io/gltf", "render", "io/scene", "lab/check", "app/process",
    ),
    "app/chart": (
        "base", "input", "geometry", "io/animation", "io/scene", "lab/check", "lab/chart", "lab/plan",
        "app/process", "app/run",
    ),
    "app/plan": (
        "base", "input", "scene", "lab/plan", "app/process", "app/run", "app/chart",
    ),
    "app/render": (
        "base", "input", "scene", "view", "io/mesh", "io/animation", "render", "io/scene",
        "app/run",
    ),
    "app/manual": (),
    "app/new": ("base", "input", "geometry", "scene", "io/mesh", "io/scene"),
    "app/view": (
        "base", "input", "geometry", "io/mesh", "io/animation", "render", "app/process", "app/run", "app/render",
    ),
    "app/time_parallel": (
        "base", "input", "exec", "scene", "time_parallel", "io/scene", "app/process", "app/run",
    ),
    "app": (
        "base", "input", "scene/fabric", "scene", "io/json", "io/mesh", "io/spool", "io/usd", "io/gltf", "io/animation",
        "io/pattern", "io/arcsim", "io/scene", "lab/check", "lab/worn", "app/process", "app/run", "app/chart", "app/plan",
        "app/render", "app/manual", "app/new", "app/view", "app/time_parallel",
    ),
}

# Folders under include/weft that a folder there may include; its own is always allowed.
ALLOWED_BELOW = {
    "core": (),
    "state": ("core",),
    "elements": ("core",),
    "exec": ("core",),
    "kernels": ("core", "state", "elements", "exec"),
}
# Single headers that a folder may include beyond that. Standard library only themselves.
ALLOWED_HEADERS = {"exec": ("weft/error.hpp",)}


def includes(root, path):
    """Yields (line number, text, is_quoted) of each include; a quoted name relative to its own
    file's folder is turned into a path from the root."""
    text = path.read_text(encoding="utf-8", errors="replace")
    for match in INCLUDE.finditer(text):
        name = match.group(2)
        quoted = match.group(1) == '"'
        beside = (path.parent / name).resolve()
        if quoted and beside.is_file() and beside.is_relative_to(root):
            name = beside.relative_to(root).as_posix()
            name = name.removeprefix("include/")
        yield text.count("\n", 0, match.start(2)) + 1, name, quoted


def stage_of(name):
    """Stage that a path belongs to: host/solve/x.cpp, cuda/solve/x.cu, weft/kernels/solve/x.hpp."""
    match = re.match(r"(?:host|cuda|(?:include/)?weft/kernels)/(\w+)/", name)
    return match.group(1) if match and match.group(1) in STAGES else None


def room_of(name):
    """Room that a file under host/ stands in, or None: host/io/mesh/obj_file.cpp is in io/mesh."""
    return name.removeprefix("host/").rpartition("/")[0] if name.startswith("host/") else None


def room_violation(path, name):
    """What is wrong with an include from host/ into host/."""
    own, other = room_of(path), room_of(name)
    if not own or not other:
        return None
    for room in (own, other):
        if room not in ROOMS:
            return f"host/{room} is no room; ROOMS in check_includes.py lists them"
    if other != own and other not in ROOMS[own]:
        allowed = ", ".join(ROOMS[own])
        return f"{own} may include " + (f"{allowed} only" if allowed else "no other room")
    return None


def table_violations(rooms):
    """Entries of a table that name an unknown room, or one that does not stand below its user."""
    messages = []
    below = []
    for room, allowed in rooms.items():
        messages += [
            f"ROOMS: {room} -> {other}: {other} does not stand above {room} in the table"
            for other in allowed
            if other not in below
        ]
        below.append(room)
    return messages


def table_markdown():
    """The table of allowed includes for ARCHITECTURE.md."""
    lines = ["| room | may include |", "|---|---|"]
    for room, allowed in ROOMS.items():
        lines.append(f"| `host/{room}` | " + (", ".join(f"`{a}`" for a in allowed) or "nothing") + " |")
    for folder, allowed in ALLOWED_BELOW.items():
        names = [f"`weft/{a}`" for a in allowed] + [f"`{h}`" for h in ALLOWED_HEADERS.get(folder, ())]
        lines.append(f"| `include/weft/{folder}` | " + (", ".join(names) or "nothing") + " |")
    lines.append("| `cuda` | `include/weft`, nothing of `host` |")
    return "\n".join(lines)


def public_header_violation(own, name, quoted):
    """What is wrong with an include in include/weft/<own>."""
    if not quoted:
        if not STD_HEADER.fullmatch(name) and not name.startswith("weft/"):
            return "headers under include/ take the standard library and weft alone"
    if quoted and not name.startswith("weft/"):
        return "headers under include/ take only headers under include/"
    parts = name.split("/")
    folder = own.split("/")[0] if "/" in own else None
    if name.startswith("weft/") and folder in ALLOWED_BELOW:
        allowed = (folder,) + ALLOWED_BELOW[folder]
        if name in ALLOWED_HEADERS.get(folder, ()):
            return None
        if len(parts) < 3 or parts[1] not in allowed:
            return f"weft/{folder} may include " + ", ".join("weft/" + a for a in allowed) + " only"
    return None


def violation(path, name, quoted):
    """What is wrong with an include, or None.

    path: the including file, from the root; name: what it includes; quoted: "..." and not <...>
    """
    if path.startswith("include/weft/"):
        wrong = public_header_violation(path.removeprefix("include/weft/"), name, quoted)
        if wrong:
            return wrong

    side = path.split("/")[0]
    if side == "host" and (name.startswith("cuda/") or CUDA_HEADER.match(name)):
        return "host/ never includes CUDA"
    if side == "cuda" and name.startswith("host/"):
        return "cuda/ never includes host/"

    own_stage, other_stage = stage_of(path), stage_of(name)
    if own_stage and other_stage and own_stage != other_stage:
        return f"kernels of different rooms never include each other ({own_stage} -> {other_stage})"

    wrong = room_violation(path, name)
    if wrong:
        return wrong

    if name.startswith("assimp/") and not path.startswith("host/io/"):
        return "assimp is for host/io only"
    if name.startswith("CGAL/") and not path.startswith(("host/lab/check/", "tests/unit/lab/check/")):
        return "CGAL is for host/lab/check and its tests only"
    if path.startswith("tests/oracle/") and name.startswith("weft/elements/"):
        return "an oracle must not use the formulas that it checks"
    return None


def is_library(path):
    return path.split("/")[0] in ("include", "host", "cuda") and not path.startswith("host/app/")


def program_calls(path):
    """Yields (line number, text) of calls in a library's file that only a program may make."""
    text = path.read_text(encoding="utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), 1):
        match = PROGRAM_ONLY.search(COMMENT.sub("", line))
        if match and (path.name, match.group(0)) not in IN_CHILDREN:
            yield number, match.group(0)


def check_edges(root):
    """Returns (messages, number of files read, pairs of rooms of which one includes the other)."""
    messages = []
    edges = set()
    count = 0
    for folder in SOURCE_FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in SOURCE_SUFFIXES or not path.is_file():
                continue
            count += 1
            own = path.relative_to(root).as_posix()
            if own.startswith("host/") and room_of(own) and room_of(own) not in ROOMS:
                messages.append(f"{own}: host/{room_of(own)} is no room; ROOMS in check_includes.py lists them")
            for line, name, quoted in includes(root, path):
                if room_of(own) and room_of(name):
                    edges.add((room_of(own), room_of(name)))
                wrong = violation(own, name, quoted)
                if wrong:
                    messages.append(f"{own}:{line}: includes {name}: {wrong}")
            if is_library(own):
                for line, call in program_calls(path):
                    messages.append(f"{own}:{line}: {call}: a library neither prints nor ends the program")
    return messages, count, edges


def element_wise_kernels(root):
    """Names of the kernels that share one file per backend: <room>/<name>."""
    header = root / ELEMENT_WISE
    return set(ELEMENT_WISE_KERNEL.findall(header.read_text())) if header.is_file() else set()


def check_kernels(root):
    """Returns (missing host files, missing CUDA and parity files, number of kernels)."""
    required, owed = [], []
    element_wise = element_wise_kernels(root)
    kernels = sorted((root / "include/weft/kernels").glob("*/*.hpp"))
    for header in kernels:
        stage, name = header.parent.name, header.stem
        own = header.relative_to(root).as_posix()
        if stage not in STAGES:
            required.append(f"{own}: no such room for kernels: {stage}; there are {', '.join(STAGES)}")
            continue
        parity = f"tests/parity/{stage}/{name}.cpp"
        backends = (f"host/{stage}/{name}.cpp", f"cuda/{stage}/{name}.cu")
        if f"{stage}/{name}" in element_wise:
            required += [
                f"{path}: {ELEMENT_WISE} lists this kernel, so it has no file of its own"
                for path in backends
                if (root / path).is_file()
            ]
            owed += [] if (root / parity).is_file() else [parity]
            continue
        if not (root / backends[0]).is_file():
            required.append(f"{own}: has no host file {backends[0]}")
        owed += [path for path in (backends[1], parity) if not (root / path).is_file()]
    return required, owed, len(kernels)


def check(root, strict):
    """Prints the result for the tree at `root`; returns the exit code."""
    messages, file_count, edges = check_edges(root)
    required, owed, kernel_count = check_kernels(root)
    messages += required + table_violations(ROOMS)
    messages += [
        f"ROOMS: {room} -> {other}: nothing needs this entry any more"
        for room, allowed in ROOMS.items()
        for other in allowed
        if (room, other) not in edges
    ]
    if owed:
        print(f"{len(owed)} files of kernels are still to be written:")
        for path in owed:
            print(f"  {path}")
        if strict:
            messages += [f"{path} is missing" for path in owed]
    for message in messages:
        print(message)
    if file_count == 0:
        print(f"{root}: no sources found")
        return 1
    print(f"{file_count} files, {kernel_count} kernels, {len(messages)} violations")
    return 1 if messages else 0


# One forbidden include per line, each with an allowed neighbour.
FORBIDDEN = [
    ("include/weft/core/vec.hpp", '"weft/scene.hpp"'),
    ("include/weft/core/vec.hpp", "<Eigen/Dense>"),
    ("include/weft/state/cloth.hpp", '"weft/elements/membrane.hpp"'),
    ("include/weft/elements/membrane.hpp", '"weft/state/cloth.hpp"'),
    ("include/weft/exec/queue.hpp", '"weft/state/cloth.hpp"'),
    ("include/weft/exec/queue.hpp", "<cuda_runtime.h>"),
    ("include/weft/exec/queue.hpp", '"weft/scene.hpp"'),
    ("include/weft/state/cloth.hpp", '"weft/error.hpp"'),
    ("include/weft/kernels/solve/spmv.hpp", '"weft/kernels/collide/hash.hpp"'),
    ("include/weft/kernels/solve/spmv.hpp", '"weft/scene.hpp"'),
    ("include/weft/scene.hpp", "<nlohmann/json.hpp>"),
    ("include/weft/scene.hpp", "<thrust/sort.h>"),
    ("include/weft/scene.hpp", '"host/io/mesh/mesh_file.hpp"'),
    ("host/solve/spmv.cpp", '"host/assemble/gather.hpp"'),
    ("host/solve/spmv.cpp", '"weft/kernels/respond/zone.hpp"'),
    ("host/solve/spmv.cpp", '"cuda/exec/check.cuh"'),
    ("host/implicit/step.cpp", "<cub/cub.cuh>"),
    ("cuda/solve/spmv.cu", '"host/solve/spmv.hpp"'),
    ("cuda/solve/spmv.cu", '"cuda/collide/sort.cuh"'),
    ("host/geometry/topology.cpp", "<assimp/scene.h>"),
    ("host/geometry/box_tree.cpp", '"host/model/model.hpp"'),
    ("host/state/store.cpp", '"host/simulation/simulation.hpp"'),
    ("host/implicit/linear/linear_system.cpp", '"host/implicit/step.hpp"'),
    ("host/implicit/step.cpp", '"host/collide/grid_walk.hpp"'),
    ("host/io/mesh/obj_file.cpp", '"host/io/usd/usd_file.hpp"'),
    ("host/io/scene/scene_file.cpp", '"host/app/run.hpp"'),
    ("host/lab/check/box_tree.cpp", '"host/geometry/box_tree.hpp"'),
    ("host/lab/chart/chart.cpp", "<CGAL/Polygon_mesh_processing/self_intersections.h>"),
    ("tests/oracle/membrane.cpp", '"weft/elements/membrane.hpp"'),
]
LAWFUL = [
    ("include/weft/core/vec.hpp", "<cmath>"),
    ("include/weft/core/vec.hpp", '"weft/core/hd.hpp"'),
    ("include/weft/elements/membrane.hpp", '"weft/elements/strain.hpp"'),
    ("include/weft/exec/launch.hpp", '"weft/error.hpp"'),
    ("include/weft/kernels/solve/spmv.hpp", '"weft/kernels/solve/matrix.hpp"'),
    ("include/weft/kernels/solve/spmv.hpp", '"weft/elements/membrane.hpp"'),
    ("include/weft/scene.hpp", '"weft/core/vec.hpp"'),
    ("host/solve/spmv.cpp", '"weft/kernels/solve/spmv.hpp"'),
    ("host/implicit/step.cpp", '"weft/kernels/collide/hash.hpp"'),
    ("host/geometry/box_tree.cpp", '"host/base/parallel.hpp"'),
    ("host/implicit/step.cpp", '"host/implicit/linear/linear_system.hpp"'),
    ("host/io/mesh/mesh_file.cpp", "<assimp/scene.h>"),
    ("host/lab/check/check.cpp", "<CGAL/intersections.h>"),
    ("tests/unit/lab/check/oracle.cpp", "<CGAL/intersections.h>"),
    ("cuda/solve/spmv.cu", "<cooperative_groups.h>"),
    ("tests/oracle/membrane.cpp", "<Eigen/Dense>"),
]

# A line of code, and whether a library may hold it.
CALLS = [
    ('fprintf(stderr, "x");', False),
    ('std::cerr << "x";', False),
    ("std::abort();", False),
    ('if (getenv("X")) return;', False),
    ('std::snprintf(text, 8, "x");', True),
    ("// printf(x) would be wrong here", True),
    ("on_exit();", True),
]


def self_test():
    """Runs every rule on made-up trees; returns the exit code."""
    failures = 0

    def messages_for(path, include, extra=(), code=""):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            for other in extra:
                (root / other).parent.mkdir(parents=True, exist_ok=True)
                (root / other).write_text("")
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(f"#pragma once\n#include {include}\n{code}\n")
            return check_edges(root)[0] + check_kernels(root)[0]

    for path, include in FORBIDDEN:
        twin = re.sub(r"include/weft/kernels/(\w+)/(\w+)\.hpp", r"host/\1/\2.cpp", path)
        if len(messages_for(path, include, (twin,) if twin != path else ())) != 1:
            print(f"not caught: {path} includes {include}")
            failures += 1
    for path, include in LAWFUL:
        twin = re.sub(r"include/weft/kernels/(\w+)/(\w+)\.hpp", r"host/\1/\2.cpp", path)
        found = messages_for(path, include, (twin,) if twin != path else ())
        if found:
            print(f"wrongly caught: {found}")
            failures += 1
    for code, lawful in CALLS:
        if bool(messages_for("host/implicit/step.cpp", "<cstdio>", code=code)) == lawful:
            print(f"{'wrongly' if lawful else 'not'} caught: {code}")
            failures += 1
        if messages_for("host/app/run.cpp", "<cstdio>", code=code):
            print(f"wrongly caught in a program: {code}")
            failures += 1
    if not messages_for("include/weft/kernels/solve/spmv.hpp", "<cmath>"):
        print("not caught: a kernel without a host file")
        failures += 1
    own_file = ("include/weft/kernels/solve/spmv.hpp", "host/solve/spmv.cpp")
    for extra, expected in ((own_file[:1], 0), (own_file, 1)):
        if len(messages_for(ELEMENT_WISE, '"weft/kernels/solve/spmv.hpp"', extra)) != expected:
            print(f"an element-wise kernel with {extra}: not {expected} violations")
            failures += 1
    if not messages_for("host/attic/box.cpp", "<cmath>"):
        print("not caught: a folder that is no room")
        failures += 1
    for rooms in ({"a": ("b",), "b": ("a",)}, {"a": ("a",)}, {"a": ("c",)}):
        if not table_violations(rooms):
            print(f"not caught: the table {rooms}")
            failures += 1
    other_stage = ("host/assemble/gather.hpp",)
    if not messages_for("host/solve/spmv.cpp", '"../assemble/gather.hpp"', other_stage):
        print("not caught: a relative include of another kernel's room")
        failures += 1
    print(f"{len(FORBIDDEN) + len(LAWFUL) + 2 * len(CALLS) + 8} cases, {failures} failures")
    return 1 if failures else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("root", nargs="?", default=".", type=Path)
    parser.add_argument("--strict", action="store_true")
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    if arguments.table:
        print(table_markdown())
        return 0
    if arguments.self_test:
        return self_test()
    return check(arguments.root.resolve(), arguments.strict)


if __name__ == "__main__":
    sys.exit(main())
