#!/usr/bin/env python3
"""Runs random scenes that a user might have written, and says which end badly.

usage: random_scenes.py --program WEFT [--seed N] [--first I] [--count M] [--only I,J] [--jobs J] [--limit SECONDS] [--keep DIR]

Scene I of seed N is always the same (scene_generator.py). A scene ends well if it exits 0 within --limit seconds of CPU
time and

- `weft check` finds nothing in its frames, and no vertex is inside a closed body or below the floor;
- nothing is faster than three times what gravity, bodies, pins, wind and pressure explain;
- pins are where their keys put them, and bodies and pins miss their places by two thicknesses at most;
- energy does not grow by more than the work done, unless the run warns of it;
- cloth in free flight falls as fast as steps of implicit Euler make it fall;
- cloth on a floor slows down; and
- of every seventh scene, one and two threads give the same bits.

A scene that may ask for the impossible may also exit 4 with one line and a checkpoint. Exit code: 0 all end well, 1 some
do not.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import threading

from everyday import cloths, compliance_problem, frame_problem, steps_of
from scene_generator import SceneGenerator

Result = collections.namedtuple("Result", "index kind detail seconds situation warned")
SLACK = 3  # how much faster than explained cloth may be
WALL = 20  # wall seconds per second of the limit, after which a run hangs


def run(command, limit):
    """exit code, error output, CPU seconds [s]"""
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(["/bin/sh", "-c", 'ulimit -t "$0"; exec "$@"', str(math.ceil(limit)), *map(str, command)],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors)
        watch = threading.Timer(WALL * limit, process.kill)
        watch.start()
        _, status, usage = os.wait4(process.pid, 0)
        watch.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        return process.returncode, errors.read(), usage.ru_utime + usage.ru_stime


def place_at(motion, time):
    """(translation, [degrees] turn about z) of a motion; None where it follows a curve through three keys or more"""
    def of(key):
        return key.get("translate", [0, 0, 0]), key.get("rotate", [0])[0]
    if time <= motion[0]["time"]:
        return of(motion[0])
    for first, second in zip(motion, motion[1:]):
        if abs(time - second["time"]) < 1e-9:
            return of(second)
        if time < second["time"]:
            share = (time - first["time"]) / (second["time"] - first["time"])
            if first.get("interpolation") != "linear":
                if len(motion) > 2:
                    return None
                share = share * share * (3 - 2 * share)
            (a, turn_a), (b, turn_b) = of(first), of(second)
            return [x + share * (y - x) for x, y in zip(a, b)], turn_a + share * (turn_b - turn_a)
    return of(motion[-1])


def pinned(pin, cloth):
    """numbers of the vertices of a grid that a pin holds"""
    n, m = cloth["grid"]["cells"]
    corners = {"min_min": 0, "max_min": n, "min_max": m * (n + 1), "max_max": m * (n + 1) + n}
    edges = {"left": range(0, (m + 1) * (n + 1), n + 1), "right": range(n, (m + 1) * (n + 1), n + 1),
             "bottom": range(n + 1), "top": range(m * (n + 1), (m + 1) * (n + 1))}
    if "vertices" in pin:
        return pin["vertices"]
    if "corners" in pin:
        return [corners[name] for name in pin["corners"]]
    return edges[pin["edge"]] if isinstance(pin["edge"], str) else []


def pin_problem(made, scene, frames, rate, distance):
    kinds = {cloth["name"]: cloth for cloth in scene["cloths"]}
    for pin in scene.get("pins", []):
        cloth = kinds[pin["cloth"]]
        if "grid" not in cloth or "obstacle" in pin:
            continue
        names = [name for name in frames[0] if name == pin["cloth"] or name.rpartition("_")[0] == pin["cloth"]]
        for number, frame in enumerate(frames):
            time = number / rate
            place = place_at(pin["motion"], time) if "motion" in pin else ([0, 0, 0], 0)
            if place is None or time > pin.get("release_time", math.inf):
                continue
            c, s = math.cos(math.radians(place[1])), math.sin(math.radians(place[1]))
            for name in names:
                for v in pinned(pin, cloth):
                    x, y, z = frames[0][name][v]
                    target = [c * x - s * y + place[0][0], s * x + c * y + place[0][1], z + place[0][2]]
                    miss = math.dist(target, frame[name][v])
                    if not miss <= distance + 2e-6 * max(made.size, *map(abs, target)):
                        return f"vertex {v} of {name} misses its pin by {miss:.3g} m at {time:.3g} s"
    return ""


def floor_problem(made, scene, frames, distance):
    if made.floor is None:
        return ""
    place = scene["obstacles"][0]
    middle = place["motion"][0]["translate"] if "motion" in place else place["transform"]["translate"]
    for number, frame in enumerate(frames):
        for name, places in frame.items():
            for x in places:
                depth = made.floor - x[2]
                if depth > distance + 1e-6 * max(1, abs(made.floor)) and max(
                        abs(x[0] - middle[0]), abs(x[1] - middle[1])) < made.size:
                    return f"{name} is {depth:.3g} m below the floor in frame {number}"
    return ""


def closed_meshes(path):
    """lists of triangles of the closed objects of an OBJ file"""
    vertices, objects = [], [[]]
    for line in path.read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "o":
            objects.append([])
        elif words[0] == "v":
            vertices.append(tuple(map(float, words[1:4])))
        elif words[0] == "f":
            objects[-1].append([int(word.split("/")[0]) - 1 for word in words[1:4]])
    for triangles in objects:
        edges = collections.Counter()
        for t in triangles:
            for a, b in zip(t, t[1:] + t[:1]):
                edges[a, b] += 1
                edges[b, a] -= 1
        if triangles and not any(edges.values()):
            yield [[vertices[v] for v in t] for t in triangles]


def windings(x, triangles):
    """how often a closed surface surrounds a point"""
    total = 0.0
    for triangle in triangles:
        a, b, c = ([p[k] - x[k] for k in range(3)] for p in triangle)
        la, lb, lc = math.hypot(*a), math.hypot(*b), math.hypot(*c)
        triple = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                  + a[2] * (b[0] * c[1] - b[1] * c[0]))
        total += 2 * math.atan2(triple, la * lb * lc + sum(p * q for p, q in zip(a, b)) * lc + sum(
            p * q for p, q in zip(b, c)) * la + sum(p * q for p, q in zip(c, a)) * lb)
    return total / (4 * math.pi)


def inside_problem(directory, frame):
    """whether cloth is inside a body at the end; `weft check` sees surfaces only"""
    bodies = sorted((directory / "frames").glob("obstacle*.obj"))
    if not bodies:
        return ""
    for triangles in closed_meshes(bodies[-1]):
        low = [min(p[k] for t in triangles for p in t) for k in range(3)]
        high = [max(p[k] for t in triangles for p in t) for k in range(3)]
        for name, places in frame.items():
            near = [x for x in places if all(low[k] < x[k] < high[k] for k in range(3))]
            for x in near[::max(1, len(near) * len(triangles) // 50000)]:
                if abs(windings(x, triangles)) > 0.5:
                    return f"{name} is inside a body at {x}"
    return ""


def box(places):
    """two corners of it"""
    return [tuple(extreme(x[k] for x in places) for k in range(3)) for extreme in (min, max)]


def speed_problem(made, scene, frames, rate, constant):
    """constant: vertices keep their numbers; otherwise only boxes around all of them tell speeds"""
    gravity = math.hypot(*scene.get("gravity", [0, 0, -9.81]))
    for number in range(1, len(frames)):
        time = number / rate
        bound = SLACK * (made.speed + gravity * time + math.sqrt(gravity * made.size)) + 0.05 * made.size * rate
        for name, places in frames[number].items():
            before = frames[number - 1][name]
            if not constant:
                before, places = box(before), box(places)
            fastest = max(map(math.dist, before, places)) * rate
            if not fastest <= bound:
                return f"{name} moves at {fastest:.3g} m/s in frame {number}, which is above {bound:.3g} m/s"
    return ""


def energy_problem(directory):
    """the engine's own comparison again, with other bounds: a tenth, or a half with bdf2, which need not dissipate what it gains"""
    scene = json.loads((directory / "scene.json").read_text())
    if scene["method"]["type"] == "asynchronous":
        return ""
    share = 0.5 if scene["method"]["integrator"] == "bdf2" else 0.1
    work = at_play = 0.0
    lowest = first = None
    for step in steps_of(directory):
        work += step.get("work", 0.0)
        if "energy" not in step:
            continue
        energy = step["energy"]
        net = sum(energy.values()) - work
        first = energy["gravitational"] if first is None else first
        lowest = net if lowest is None else min(lowest, net)
        at_play = max(at_play, energy["kinetic"] + energy["elastic"] + abs(energy["gravitational"] - first) + abs(work))
        if net - lowest > share * at_play + 1e-9:
            return f"{net - lowest:.3g} J from nothing at {step['time']:.3g} s, where {at_play:.3g} J are at play"
    return ""


def fall_problem(made, scene, frames, steps):
    if not made.free or scene.get("method", {}).get("integrator") == "bdf2" or made.kind == "asynchronous":
        return ""
    if any("damping" in material for material in scene.get("materials", {}).values()):
        return ""
    gravity, velocity = scene.get("gravity", [0, 0, -9.81]), scene["cloths"][0]["velocity"]
    time = steps[-1]["time"]
    squares = sum(step["step"] ** 2 for step in steps)
    first, last = ([sum(x[k] for places in frame.values() for x in places) for k in range(3)] for frame in
                   (frames[0], frames[-1]))
    count = sum(map(len, frames[0].values()))
    moved = [(b - a) / count for a, b in zip(first, last)]
    wanted = [velocity[k] * time + gravity[k] / 2 * (time * time + squares) for k in range(3)]
    miss = math.dist(moved, wanted)
    return "" if miss <= 0.01 * math.hypot(*wanted) + 0.01 * made.size else f"falls by {moved} m instead of {wanted}"


def rest_problem(made, frames, rate):
    if not made.settles:
        return ""

    def speed(one, other):
        return sum(math.dist(a, b) for name in one for a, b in zip(one[name], other[name])) * rate
    speeds = [speed(a, b) for a, b in zip(frames, frames[1:])]
    return "" if speeds[-1] < 0.5 * max(speeds) + 1e-3 else "does not slow down on the floor"


def problem_of(args, made, scene_file, directory):
    """What is wrong with how a scene ends: kind, detail, CPU seconds, whether it warned of its energy"""
    def command(out, threads):
        return [args.program, "run", scene_file, "-o", out, "--device", f"cpu:{threads}", "--no-preview"]
    code, errors, seconds = run(command(directory, 1), args.limit)
    lines = [line for line in errors.splitlines() if line.startswith("weft: ") and "warning" not in line]
    warned = "energy" in errors or "gained" in errors
    how = lines[0] if lines else errors[-200:]
    if code < 0 and seconds >= args.limit - 1:
        return "slow", f"no end within {args.limit:g} s", seconds, warned
    if code == 2:
        return "refused", how, seconds, warned
    if code == 4:
        if len(lines) != 1:
            return "exit", f"exit 4 with {len(lines)} lines: {errors[-200:]}", seconds, warned
        if not list(directory.glob("checkpoint*")):
            return "exit", "exit 4 without a checkpoint", seconds, warned
        return "may stop" if made.hard else "stopped", how, seconds, warned
    if code != 0:
        return "exit", f"exit {code}: {errors[-300:]}", seconds, warned
    check = subprocess.run([args.program, "check", directory], capture_output=True, text=True)
    if check.returncode != 0:
        return "check", check.stdout.strip()[-300:], seconds, warned
    scene = made.scene
    report = json.loads((directory / "report.json").read_text())
    distance = report["contacts"]["compliance_distance_max"] * 1.01
    paths = sorted((directory / "frames").glob("cloth_*.obj"))
    frames = [cloths(path) for path in paths]
    steps = steps_of(directory)
    constant = made.kind not in ("adaptive", "view") and "refine" not in scene
    about = {"largest_coordinate": 1e9}
    for kind, detail in (
            ("frames", frame_problem(directory, about, scene["time"]["frames"] + 1)),
            ("pinch", compliance_problem(directory)),
            ("floor", floor_problem(made, scene, frames, distance)),
            ("inside", inside_problem(directory, frames[-1]) if distance == 0 else ""),
            ("pin", pin_problem(made, scene, frames, made.rate, distance) if constant else ""),
            ("speed", speed_problem(made, scene, frames, made.rate, constant)),
            ("energy", "" if warned or made.close else energy_problem(directory)),
            ("fall", fall_problem(made, scene, frames, steps) if constant else ""),
            ("rest", rest_problem(made, frames, made.rate) if constant else "")):
        if detail:
            return kind, detail, seconds, warned
    if made.index % 7 == 0 and made.kind != "time_parallel":
        other = directory.with_name("two_threads")
        run(command(other, 2), 3 * args.limit)
        hashes = [json.loads((path / "report.json").read_text())["state_hash"] for path in (directory, other)]
        if hashes[0] != hashes[1]:
            return "bits", f"one thread gives {hashes[0]}, two give {hashes[1]}", seconds, warned
    return "ok", "", seconds, warned


def result_of(args, index):
    made = SceneGenerator(args.seed, index)
    made.index = index
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        if args.keep:
            folder = args.keep / f"{args.seed}_{index}"
            folder.mkdir(parents=True)
        scene_file = folder / "scene.json"
        scene_file.write_text(json.dumps(made.scene, indent=1))
        for name, text in made.files.items():
            (folder / name).write_text(text)
        try:
            kind, detail, seconds, warned = problem_of(args, made, scene_file, folder / "run")
        except Exception as error:  # a run may leave files that nothing above expects
            kind, detail, seconds, warned = "script", repr(error), 0.0, False
    return Result(index, kind, detail, seconds, f"{made.situation}, {made.kind}", warned)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="the number of the first scene")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--only", help="numbers of scenes, with commas between them, instead of --first and --count")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60)
    parser.add_argument("--keep", type=pathlib.Path, help="a folder in which scenes and runs stay")
    args = parser.parse_args()
    indices = [int(i) for i in args.only.split(",")] if args.only else range(args.first, args.first + args.count)
    results = []
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for result in pool.map(lambda index: result_of(args, index), indices):
            results.append(result)
            print(f"{result.kind:9}{result.seconds:6.1f} s  --seed {args.seed} --only {result.index:<5} "
                  f"{result.situation:20}{'  [energy warning]' if result.warned else ''}  {result.detail}", flush=True)
    print()
    for kind, count in collections.Counter(result.kind for result in results).most_common():
        where = "" if kind == "ok" else ": " + ", ".join(str(result.index) for result in results if result.kind == kind)
        print(f"{count:5} {kind}{where}")
    print("      warned of their energy:", ", ".join(str(result.index) for result in results if result.warned) or "none")
    slowest = sorted(results, key=lambda result: -result.seconds)[:5]
    print("      slowest:", ", ".join(f"{result.index} ({result.seconds:.1f} s)" for result in slowest))
    return 1 if any(result.kind not in ("ok", "may stop") for result in results) else 0


if __name__ == "__main__":
    sys.exit(main())
