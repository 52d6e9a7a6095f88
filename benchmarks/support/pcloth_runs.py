#!/usr/bin/env python3
"""Time steps a second on counterparts of the benchmarks of P-Cloth (Li et al. 2020, Table 1).

    pcloth_runs.py WEFT DIR [--cards N] [--only NAME]... [--seconds S] [--steps N] [--triangles N]
                                    runs them in DIR, writes DIR/pcloth.json, an entry per benchmark
    pcloth_runs.py --table FILE     prints the table of such a file

As in the paper: single precision, block Jacobi, relative residual 0.01, 500 iterations at most,
its triangle counts and steps, the fabric interlock. Its scenes and garments are not published:
flag, sheets, funnel and twisting follow its descriptions, three skirts over each other on a
motion-captured body stand for garments. Each scene first goes its way for some seconds, on a card
of its own; from that checkpoint on, steps are timed on 1, 2, 4, ... cards. What is timed are the
stages of all steps but the first one after the checkpoint.
"""

import argparse
import json
import signal
import subprocess
import sys
import threading
from pathlib import Path

from markdown_table import markdown
from suite_file import put_case, read_cases

TAKE = "/usr/share/assimp/models/BVH/Boxing_Toes.bvh"
# Name, triangles, steps a second, the paper's frames a second on 1, 2 and 4 cards.
PAPER = {
    "flag": (1200000, 250, (1.17, 2.19, 5.45)),
    "sphere": (700000, 200, (0.76, 2.04, 4.21)),
    "funnel": (550000, 2000, (1.74, 2.87, 5.20)),
    "twisting": (550000, 2000, (1.71, 2.47, 3.72)),
    "sphere_1m": (1000000, 200, (0.23, 1.31, 2.11)),
    "princess": (510000, 250, (1.23, 2.59, 5.12)),
    "andy": (538000, 1000, (0.86, 2.21, 4.87)),
    "zoey": (569000, 500, (0.38, 1.16, 2.04)),
    "kimono": (1000000, 1000, (0.24, 0.58, 1.11)),
    "miku": (1330000, 1000, (0.48, 1.67, 2.59)),
    "kneel": (1650000, 250, (0.61, 1.74, 2.48)),
}
GARMENTS = ("princess", "andy", "zoey", "kimono", "miku", "kneel")
TITAN_XP = 547  # [GB/s]
STEPS_A_FRAME = 20


def upright(name, place, size):
    return {"name": name, "grid": {"size": size}, "material": "cloth",
            "transform": {"translate": place, "rotate": [90, 1, 0, 0]}}


def hanging(distances):
    """Sheets that hang from their upper edges; a ball goes through where they hang, and back."""
    names = [f"sheet_{k}" for k in range(len(distances))]
    way = [(0, -0.45), (0.5, 0.35), (1.0, -0.35), (1.5, 0.35), (2.0, -0.35)]
    return {
        "cloths": [upright(n, [0, y, 0], [1, 1]) for n, y in zip(names, distances)],
        "obstacles": [{"name": "ball", "sphere": {"radius": 0.2}, "friction": 0.2,
                       "motion": [{"time": t, "translate": [0, y, -0.15]} for t, y in way]}],
        "pins": [{"cloth": n, "edge": "top"} for n in names],
    }


def flag():
    return {
        "cloths": [upright("flag", [0.62, 0, 1.5], [1.2, 0.8])],
        "obstacles": [{"name": "pole", "capsule": {"radius": 0.012, "length": 2.2},
                       "transform": {"translate": [0, 0, 1.0]}}],
        "pins": [{"cloth": "flag", "edge": "left"}],
        "wind": {"density": 1.2, "velocity": [9, 2, 0], "drag": 0.02},
    }


def funnel():
    profile = [[0.4, 0.3], [0.26, 0.16], [0.16, 0.07], [0.125, 0.03], [0.115, -0.02],
               [0.115, -0.16], [0.125, -0.165], [0.135, -0.16], [0.135, -0.02], [0.145, 0.02],
               [0.175, 0.055], [0.275, 0.145], [0.415, 0.285], [0.415, 0.3]]
    return {
        "cloths": [{"name": "sheet", "disc": {"radius": 0.3}, "material": "cloth",
                    "velocity": [0, 0, -2],
                    "transform": {"translate": [0, 0, 0.28]},
                    "copies": {"count": 3, "translate": [0, 0, 0.01], "rotate": [23, 0, 0, 1]}}],
        "obstacles": [{"name": "funnel", "revolution": {"closed": True, "profile": profile},
                       "friction": 0.05}],
    }


def twisting():
    """Three sheets lie over each other on a ball that turns four times a second."""
    return {
        "cloths": [{"name": "sheet", "grid": {"size": [0.8, 0.8]}, "material": "cloth",
                    "transform": {"translate": [0, 0, 0.203]}, "velocity": [0, 0, -1],
                    "copies": {"count": 3, "translate": [0, 0, 0.01], "rotate": [30, 0, 0, 1]}}],
        "obstacles": [{"name": "ball", "sphere": {"radius": 0.2}, "friction": 0.8,
                       "motion": [{"time": 0.1 * k, "rotate": [144 * k, 0, 0, 1]}
                                  for k in range(60)]},
                      {"name": "floor", "plane": {"size": [3, 3]}, "friction": 0.3,
                       "transform": {"translate": [0, 0, -0.21]}}],
    }


def garment(take):
    cloths, pins = [], []
    for k, (inner, outer, lift) in enumerate(
            [(0.13, 0.52, 0.0), (0.14, 0.6, 0.014), (0.15, 0.68, 0.028)]):
        cloths.append({"name": f"skirt_{k}", "material": "cloth",
                       "disc": {"inner_radius": inner, "radius": outer},
                       "transform": {"translate": [-0.096, -0.51, 1.055 + lift],
                                     "rotate": [4.36, -0.038, 0.066, 0]}})
        pins.append({"cloth": f"skirt_{k}", "edge": "inner", "obstacle": "body"})
    body = {"name": "body", "friction": 0.3, "units": "cm",
            "capture": {"file": take, "first": 520, "last": 1000,
                        "start_time": 0.1, "radius": {"Hips": 0.105, "Ab": 0.11, "Chest": 0.1}}}
    return {"cloths": cloths, "obstacles": [body], "pins": pins}


def scene(name, triangles, take):
    of_paper, rate, _ = PAPER[name]
    if name in GARMENTS:
        parts = garment(take)
    else:
        parts = {"flag": flag, "funnel": funnel, "twisting": twisting,
                 "sphere": lambda: hanging([-0.02, 0, 0.02]),
                 "sphere_1m": lambda: hanging([0])}[name]()
    return {
        "name": f"pcloth_{name}", "triangles": triangles or of_paper,
        "time": {"step": 1 / rate, "frame_rate": rate / STEPS_A_FRAME, "frames": 100000},
        "materials": {"cloth": {"fabric": "interlock", "density": 0.2}},
        **parts,
        "contact": {"thickness": 0.001, "friction": 0.1},
        "precision": "float",
        "solver": {"tolerance": 0.01},
        "experimental": {"solver.max_iterations": 500, "solver.preconditioner": "block_jacobi"},
        "output": {"format": "ply", "checkpoint_every": 100000},
    }


def run(words, log, seconds, patience):
    """Exit code; ends the run by a signal after some seconds, upon which it writes a checkpoint once
    the step is done, and kills it where that takes longer than `patience`, in seconds."""
    with open(log, "w", encoding="utf-8") as out:
        process = subprocess.Popen(words, stdout=out, stderr=subprocess.STDOUT)
        try:
            return process.wait(seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGTERM)
        try:
            return process.wait(patience)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def timed(folder, start, report):
    """Figures of the steps that a run did after `start` and one more."""
    steps = [json.loads(line) for line in (folder / "steps.jsonl").read_text().splitlines()]
    steps = [s for s in steps if s["number"] > start + 1]
    device = report["peak_bytes"]["device"]
    return {
        "device": report["device"], "first_step": start + 2, "steps": len(steps),
        "step_ms": mean(sum(s["stages_ms"].values()) for s in steps),
        "stages_ms": {k: mean(s["stages_ms"][k] for s in steps) for k in steps[0]["stages_ms"]},
        "iterations_a_step": mean(s["iterations"] for s in steps),
        "iterations_max": max(s["iterations_max"] for s in steps),
        "contacts": mean(s["proximities"] for s in steps),
        "impacts": mean(s["impacts"] for s in steps),
        "peak_device_bytes": device, "state_hash": report["state_hash"],
    }


class Runs:
    def __init__(self, arguments):
        self.arguments = arguments
        self.file = arguments.directory / "pcloth.json"
        self.lock = threading.Lock()
        self.results = {}
        self.failed = {}

    def folder(self, name, kind):
        return self.arguments.directory / f"{name}_{kind}"

    def words(self, name, kind, cards):
        directory = self.arguments.directory
        return [self.arguments.weft, "run", str(directory / f"{name}.json"), "--no-preview", "--overwrite",
                "--device", "cuda:" + ",".join(map(str, cards)), "-o",
                str(self.folder(name, kind))]

    def start(self, name, card):
        made = scene(name, self.arguments.triangles, self.arguments.take)
        (self.arguments.directory / f"{name}.json").write_text(json.dumps(made, indent=1))
        folder = self.folder(name, "start")
        code = run(self.words(name, "start", [card]), f"{folder}.log", self.arguments.seconds,
                   self.arguments.limit)
        if code != 130:
            self.failed[name] = f"the way to the checkpoint ended with exit code {code}"

    def measure(self, name, cards):
        if name in self.failed:
            return
        kind = f"on_{len(cards)}"
        start = self.folder(name, "start")
        checkpoint = max(start.glob("checkpoint_*.weft"))
        first = json.loads((start / "report.json").read_text())["steps"]
        frames = -(-(first + self.arguments.steps + 1) // STEPS_A_FRAME)
        folder = self.folder(name, kind)
        code = run(self.words(name, kind, cards) + ["--resume", str(checkpoint), "--frames",
                                                    str(frames)], f"{folder}.log",
                   self.arguments.limit, 10)
        if code != 0:
            self.failed[name] = f"{len(cards)} cards: exit code {code}"
            return
        report = json.loads((folder / "report.json").read_text())
        result = self.results.setdefault(name, {
            "benchmark": "pcloth", "scene": name, "build": report["build"],
            "triangle_count": report["triangle_count"], "vertex_count": report["vertex_count"],
            "command": [Path(w).name if w.startswith("/") else w for w in sys.argv[1:]],
            "machine": self.arguments.machine,
            "step": 1 / PAPER[name][1], "simulated_s_before": first / PAPER[name][1], "runs": [],
        })
        result["runs"].append(timed(folder, first, report))
        with self.lock:
            put_case(self.file, name, result)

    def side_by_side(self, call, names, width):
        """call(name, cards) for all, on disjoint sets of `width` cards each, as many at once as there
        are cards for."""
        free = [list(range(k, k + width))
                for k in range(0, self.arguments.cards - width + 1, width)]
        names, lock = list(names), threading.Lock()

        def serve(cards):
            while True:
                with lock:
                    if not names:
                        return
                    name = names.pop(0)
                try:
                    call(name, cards)
                except (OSError, ValueError, LookupError) as error:
                    self.failed[name] = repr(error)

        threads = [threading.Thread(target=serve, args=(cards,)) for cards in free]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def all(self):
        names = self.arguments.only or list(PAPER)
        self.side_by_side(lambda name, cards: self.start(name, cards[0]), names, 1)
        width = 1
        while width <= self.arguments.cards:
            self.side_by_side(self.measure, names, width)
            width *= 2
        for name, why in self.failed.items():
            print(f"{name}: {why}", file=sys.stderr)
        return 4 if self.failed else 0


def copies_of(device):
    """[GB/s] as the probe of a card printed it."""
    return 1000 * float(device.split("copies at ")[1].split(" TB/s")[0])


def table(file):
    results = read_cases(file)
    rows, commits, cards, bandwidths = [], set(), set(), []
    for name, (_, rate, paper) in PAPER.items():
        result = results.get(name)
        if result is None:
            rows.append([name, "", f"1/{rate}", "", "not measured"] + [""] * 7)
            continue
        commits.add(result["build"]["commit"])
        copies = copies_of(result["machine"][0])
        cards.add(result["machine"][0].split(", copies")[0])
        bandwidths.append(copies)
        by_cards = {len(r["device"].split(",")): r for r in result["runs"]}
        rate_of = {n: 1000 / r["step_ms"] for n, r in by_cards.items()}
        bits = "same" if len({r["state_hash"] for r in result["runs"]}) == 1 else "**differ**"
        least = min(by_cards)
        one = by_cards[least]
        rows.append([
            name, f"{result['triangle_count']:,}", f"1/{rate}",
            f"{result['simulated_s_before']:.2f}",
            " / ".join(f"{rate_of[n]:.3g}" for n in sorted(rate_of)),
            " / ".join(f"{value:.3g}" for value in paper),
            " / ".join(f"{rate_of[n] / rate_of[least]:.2f}" for n in sorted(rate_of) if n > least),
            " / ".join(f"{value / paper[0]:.2f}" for value in paper[1:]),
            f"{rate_of[least] / least / copies * 1000:.3g} / {paper[0] / TITAN_XP * 1000:.3g}",
            f"{one['iterations_a_step']:.0f}", f"{one['contacts']:,.0f}, {one['impacts']:,.0f}",
            bits])
    columns = [("benchmark", False, None), ("triangles", True, None), ("step, s", True, None), ("from, s", True, None),
               ("time steps a s on 1 / 2 / 4 cards", True, None), ("paper", True, None),
               ("speed-up on 2 / 4", True, None), ("paper", True, None),
               ("steps a s and TB/s of one card: here / paper", True, None),
               ("iterations a step", True, None), ("contacts, impacts a step", True, None),
               ("bits", False, None)]
    print(markdown(columns, rows))
    if not bandwidths:
        return 0
    print(f"Commit {', '.join(sorted(commits))}; {'; '.join(sorted(cards))}. Bandwidth: copies "
          f"measured before each run, {min(bandwidths) / 1000:.2f} to {max(bandwidths) / 1000:.2f} "
          f"TB/s; {TITAN_XP} GB/s for the paper's Titan Xp.")
    return 0


def cards_of(weft):
    """The lines of `weft info` about cards."""
    out = subprocess.run([weft, "info"], capture_output=True, text=True, check=False).stdout
    return [line.strip() for line in out.splitlines() if "copies at" in line]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    if "--table" in sys.argv:
        parser.add_argument("--table", type=Path, metavar="FILE")
        return table(parser.parse_args().table)
    parser.add_argument("weft")
    parser.add_argument("directory", type=Path)
    parser.add_argument("--cards", type=int, default=4)
    parser.add_argument("--only", action="append", choices=PAPER)
    parser.add_argument("--seconds", type=float, default=60, help="on the way to the checkpoint")
    parser.add_argument("--steps", type=int, default=20, help="that are timed, at least: "
                        f"frames of {STEPS_A_FRAME} are done to their end")
    parser.add_argument("--limit", type=float, default=600, help="seconds that timed steps may take")
    parser.add_argument("--triangles", type=int, help="instead of the paper's")
    parser.add_argument("--take", default=TAKE)
    arguments = parser.parse_args()
    arguments.directory.mkdir(parents=True, exist_ok=True)
    arguments.directory = arguments.directory.resolve()
    arguments.machine = cards_of(arguments.weft)
    return Runs(arguments).all()


if __name__ == "__main__":
    sys.exit(main())
