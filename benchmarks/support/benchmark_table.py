#!/usr/bin/env python3
"""Prints what the committed results say against published figures and our own aims, as Markdown.

    benchmark_table.py LATEST                   LATEST: benchmarks/results/latest
    benchmark_table.py --write DOCUMENT LATEST  replaces the part of that file between the lines
                                                <!-- benchmarks --> and <!-- /benchmarks -->

"Ratio" is above 1 where weft is better than what the row compares with, and bold where it is not.
Exit code 2 if a result cannot be read or lacks a figure, or the document has no such lines.
"""

import sys

import asynchronous_results
import pcloth_runs
from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN = "<!-- benchmarks -->"
END = "<!-- /benchmarks -->"
COLUMNS = [(text, number, None) for text, number in (
    ("benchmark", False), ("triangles", True), ("weft", True), ("compared with", False),
    ("ratio", True), ("machine", False), ("commit", False), ("command", False))]

# Case of weft_bench_drape, by machine: what it is, and the aim in wall s per simulated s.
DRAPES = (
    ("2x-amd-epyc", "default", "`drape`", 6),
    ("1x-nvidia-h100", "499_stiff", "`sphere`, stiff", 2),
    ("1x-nvidia-h100", "499_interlock", "`sphere`, interlock", 2),
    ("1x-nvidia-h100", "699_stiff", "`sphere`, stiff", 5),
    ("1x-nvidia-h100", "699_interlock", "`sphere`, interlock", 5),
    ("1x-nvidia-h100", "stack_200", "`stack`", None),
    ("1x-nvidia-h100", "dress_200", "`dress`", 2.5),
    ("1x-nvidia-h200", "499", "`sphere`, stiff", None),
    ("1x-nvidia-h200", "499_interlock", "`sphere`, interlock", None),
    ("1x-nvidia-h200", "699", "`sphere`, stiff", None),
    ("2x-nvidia-h200", "499", "`sphere`, stiff", 1.2),
    ("2x-nvidia-h200", "499_interlock", "`sphere`, interlock", 1.5),
    ("2x-nvidia-h200", "699", "`sphere`, stiff", 2.8),
    ("2x-nvidia-h200", "dress_200", "`dress`", None),
    ("2x-nvidia-h200", "funnel_200", "`funnel`", None),
    ("2x-nvidia-h200", "dancer_skirt_200", "`dancer_skirt`", None),
    ("2x-nvidia-h200", "stack_200", "`stack`", None),
    ("4x-nvidia-h200", "499_4", "`sphere`, stiff", None),
    ("4x-nvidia-h200", "699_4", "`sphere`, stiff", None),
)
# Offset geometric contact (Chen et al. 2025), ms per step of 50 layers.
LAYERS = 6.3
# Times as fast as ARCSim on one thread that adaptive meshes should be.
ARCSIM_AIM = 10
# Koh, Narain and O'Brien 2015, Table 1: how many times as fast view is as adaptive.
VIEW = {"karate": 2.39, "dancer": 2.09, "dancers_10": 4.45}
# Machine, scene of which weft_bench_time_parallel has 20 s, and the speed-up on 128 cores of
# Liang & Lin 2018, Table 6.
SLICED = (("2x-amd-epyc", "blue_dress", 74.1), ("2x-intel-xeon", "yellow_dress", 75.0),
          ("2x-amd-epyc", "sphere", 102), ("16x-intel-xeon", "falling", 116),
          ("2x-amd-epyc", "karate", 99.5), ("2x-intel-xeon", "twisting", 92.3),
          ("16x-intel-xeon", "funnel", 93.8))
WORKERS = 128


def shown(ratio):
    text = f"{ratio:.0f}" if ratio >= 100 else f"{ratio:.2g}"
    return text if ratio >= 1 else f"**{text}**"


def commit_of(result):
    build = result["build"]
    return build["commit"][:7] + (" with changes" if build["dirty"] else "")


def command_of(result):
    """The command of a benchmark, by its program's name, without the file that it wrote."""
    words = [f"weft_bench_{result['benchmark']}", *map(str, result["command"][1:])]
    if "--json" in words:
        at = words.index("--json")
        words[at:at + 2] = []
    return "`" + " ".join(words) + "`"


def gpu_count(device):
    return len(device.partition(":")[2].split(",")) if device.startswith("cuda") else 0


def pcloth_rows(latest):
    rows = []
    for machine in ("1x-nvidia-h200", "2x-nvidia-h200"):
        cases = read_cases(latest / machine / "pcloth.json")
        for name, (_, _, paper) in pcloth_runs.PAPER.items():
            result = cases[name]
            width = max(gpu_count(run["device"]) for run in result["runs"])
            run = next(r for r in result["runs"] if gpu_count(r["device"]) == width)
            here, theirs = 1000 / run["step_ms"], paper[width.bit_length() - 1]
            bandwidth = pcloth_runs.copies_of(result["machine"][0]) / pcloth_runs.TITAN_XP
            words = " ".join(["benchmarks/support/pcloth_runs.py", *result["command"]])
            rows.append([
                f"{name}, {width} GPU{'s' if width > 1 else ''}", f"{result['triangle_count']:,}",
                f"{here:.3g} steps/s", f"P-Cloth, {width} x Titan Xp: {theirs:g} steps/s",
                f"{shown(here / theirs)}; {shown(here / theirs / bandwidth)} by bandwidth", machine,
                commit_of(result), f"`{words}`"])
    return rows


def drape_rows(latest):
    rows = []
    for machine, case, name, aim in DRAPES:
        result = read_cases(latest / machine / "drape.json")[case]
        for series in result["series"]:
            wall = series["wall_s_per_simulated_s"]["median"]
            is_aimed = aim and series is result["series"][-1]
            rows.append([
                f"{name}, `{series['device']}`", f"{result['triangle_count']:,}",
                f"{wall:.3g} s per simulated s", f"aim: {aim} s" if is_aimed else "",
                shown(aim / wall) if is_aimed else "", machine, commit_of(result),
                command_of(result)])
    return rows


def fold_rows(latest):
    """4 million triangles, folded: whole steps on several GPUs, without the first one, which waits
    for set-up."""
    machine, rows = "4x-nvidia-h200", []
    for report in read_cases(latest / machine / "fold.json").values():
        steps = report["last_steps"][1:]
        mean = sum(sum(step["stages_ms"].values()) for step in steps) / len(steps)
        rows.append([f"`sphere`, folded, `{report['device']}`", f"{report['triangle_count']:,}",
                     f"{mean:.3g} ms per step", "", "", machine, commit_of(report),
                     f"`{report['command']}`"])
    return rows


def layer_rows(latest):
    machine = "1x-nvidia-h200"
    result = read_cases(latest / machine / "drape.json")["layers_50"]
    run = result["series"][0]["samples"][0]
    mean = 1000 * run["wall_s"] / run["steps"]
    return [["`stack`, 50 layers, steps of 5 ms", f"{result['triangle_count']:,}",
             f"{mean:.3g} ms per step", f"Chen et al. 2025: {LAYERS} ms per step",
             shown(LAYERS / mean), machine, commit_of(result), command_of(result)]]


def arcsim_rows(latest):
    machine, rows = "2x-intel-xeon", []
    for case, result in read_cases(latest / machine / "adaptive.json").items():
        if not case.startswith("arcsim_"):
            continue
        run = next(r for r in result["runs"] if r["method"] == "adaptive")
        ratio = run["arcsim_over_weft"]
        rows.append([
            f"adaptive: ARCSim's {run['scene']}, {run['frames']} frames",
            f"{run['faces_by_frame'][-1]:,.0f}", f"{run['cpu_s']:.3g} CPU s",
            f"ARCSim 0.2.1: {run['arcsim_cpu_s']:g} CPU s; aim: {ARCSIM_AIM} times as fast",
            f"{shown(ratio)}; {shown(ratio / ARCSIM_AIM)} of the aim", machine, commit_of(result),
            command_of(result)])
    return rows


def view_rows(latest):
    """Mean time per frame of the adaptive method over that of `view`, against Koh et al. 2015."""
    machine, rows = "32x-intel-xeon", []
    cases = read_cases(latest / machine / "adaptive.json")
    for name, theirs in VIEW.items():
        of = {method: cases[f"view_{name}_{method}"] for method in ("implicit", "adaptive", "view")}
        walls = {method: result["runs"][0]["wall_s_by_frame"] for method, result in of.items()}
        frames = min(map(len, walls.values()))
        ratio = sum(walls["adaptive"][:frames]) / sum(walls["view"][:frames])
        rows.append([
            f"view: {name}, over adaptive", f"{of['view']['runs'][0]['faces_by_frame'][-1]:,.0f}",
            f"{ratio:.3g} times as fast", f"Koh et al. 2015: {theirs:g} times",
            shown(ratio / theirs), machine, commit_of(of["view"]),
            command_of(of["view"])])
    return rows


def asynchronous_rows(latest):
    rows = []
    for machine, threads in (("2x-intel-xeon", 1), ("64x-intel-xeon", 12)):
        cases = read_cases(latest / machine / "asynchronous.json")
        for scene, _, one, twelve in asynchronous_results.PAPER:
            found = asynchronous_results.pick(
                asynchronous_results.results(cases, f"{scene}_*"), "slabs", threads)
            if found is None:
                continue
            result, sample = found
            theirs = twelve if threads == 12 else one
            rows.append([
                f"asynchronous: {scene}, {sample['simulated_s']:g} s, "
                f"{threads} thread{'s' if threads > 1 else ''}", f"{result['triangle_count']:,}",
                asynchronous_results.minutes(sample), f"Ainsley et al. 2012: {theirs:g} min",
                shown(theirs / (sample["wall_s"] / 60)), machine, commit_of(result),
                command_of(result)])
    return rows


def sliced_rows(latest):
    rows = []
    for machine, scene, theirs in SLICED:
        result = read_cases(latest / machine / "time_parallel.json")[f"{scene}_20s"]
        level = result["coarse_levels"][0]
        here = {cost: next(row["adaptive"] for row in level[f"schedules_by_{cost}"]
                           if row["workers"] == WORKERS) for cost in ("counted_work", "clock")}
        time = result["resolved_scene"]["time"]
        rows.append([
            f"time_parallel: {scene}, {time['frames'] / time['frame_rate']:g} s, {WORKERS} workers",
            f"{result['triangle_count']:,}",
            f"{here['counted_work']:.3g} times one worker by work, {here['clock']:.3g} by clock",
            f"Liang & Lin 2018: {theirs:g} times", shown(here["counted_work"] / theirs), machine,
            commit_of(result), command_of(result)])
    return rows


def table(paths):
    if len(paths) != 1:
        raise BadInput(f"{len(paths)} folders; one at a time")
    texts = []
    for title, makers in (("P-Cloth", [pcloth_rows]), ("Drapes", [drape_rows, fold_rows]),
                          ("Peers", [layer_rows, arcsim_rows, view_rows, asynchronous_rows,
                                     sliced_rows])):
        try:
            rows = [row for make in makers for row in make(paths[0])]
        except (KeyError, TypeError, ValueError, IndexError, StopIteration) as error:
            raise BadInput(f"{paths[0]}: {title}: {error!r}") from error
        texts.append(f"### {title}\n\n{markdown(COLUMNS, rows)}")
    return "\n".join(texts)


if __name__ == "__main__":
    sys.exit(main("benchmark_table.py", __doc__, "benchmarks/results/latest", table, BEGIN, END))
