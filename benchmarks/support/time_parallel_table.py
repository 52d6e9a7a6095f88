#!/usr/bin/env python3
"""Prints what was measured of slices of time as Markdown tables, after those of Liang & Lin 2018.

    time_parallel_table.py RESULT...            RESULT: a file that --json of
                                                weft_bench_time_parallel, time_parallel_devices.py
                                                or suite_file.py wrote, or a directory with files
                                                time_parallel_*.json
    time_parallel_table.py --write DOCUMENT RESULT...
                                                replaces the part of that file between the lines
                                                <!-- time_parallel --> and <!-- /time_parallel -->

What no result has is "not measured". Exit code 2 if a result cannot be read or lacks a figure, or
the file has no such lines.
"""

import sys

from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN = "<!-- time_parallel -->"
END = "<!-- /time_parallel -->"
NONE = "not measured"
WORKERS = (1, 2, 4, 8, 16, 32, 64, 128)

# The paper's scenes: K, speed-up on 64 and 128 cores (Table 6), at 128 cores of 80 s (Table 7), of
# four times the triangles (Table 2), curvature error before and after recovery (Table 4), at 128
# cores by coarse steps of twice the fine ones (20 s of Table 7: Table 8 repeats a row for Karate),
# triangles of bodies (Table 6).
PAPER = {
    "blue_dress": (368, 54.0, 74.1, 104, 99.6, 0.11, 0.04, 53.1, "20K"),
    "yellow_dress": (381, 50.0, 75.0, 117, 109, 0.12, 0.06, 61.1, "20K"),
    "sphere": (564, 75.4, 102, 150, 178, 0.032, 0.006, 78.8, "1,280"),
    "falling": (187, 61.1, 116, 125, 119, 0.22, 0.05, 95.1, "15K"),
    "karate": (158, 51.0, 99.5, 123, 103, 0.29, 0.09, 73.4, "28K"),
    "twisting": (212, 60.0, 92.3, 115, 101, 0.46, 0.14, 87.2, "762"),
    "funnel": (1323, 50.5, 93.8, 139, 108, 0.16, 0.07, 66.0, "4K"),
}
# At 128 cores where Table 2 compares it with four times the triangles: not what Table 6 has.
KARATE_BASE = 96.4
# Other presets of these scenes: "sphere" has a mesh that stays here.
VARIANTS = {"sphere_adaptive": "sphere"}
# What a preset's name does not say.
LABELS = {"blue_dress": "blue_dress (ARCSim's)", "yellow_dress": "yellow_dress (ARCSim's blue one)",
          "sphere_adaptive": "sphere (ARCSim's, adaptive)"}
# Meshes of one scene are two of Table 2 if one has so many times the other's triangles: those that
# change never have the same number twice.
FINER = 2
# Speed-up by other means than slices of time, over one core.
PAPER_SPACE = (("ARCSim's threads (Table 6)", "12 cores", "2.2 to 4.6"),
               ("Zara et al. (Fig. 8)", "16 cores", "11"),
               ("Tang et al. (Table 5)", "a GPU", "47 to 58"))
# Adaptive over uniform partition (Table 3), by cores.
PAPER_ADAPTIVE = {8: 1.17, 16: 1.17, 32: 1.12, 64: 1.21, 128: 1.19}


class Level:
    """One coarse level of one result."""

    def __init__(self, result, level):
        self.result, self.level = result, level
        self.scene = result["preset"] or result["scene"]
        self.of_paper = VARIANTS.get(self.scene, self.scene)
        self.paper = PAPER.get(self.of_paper)
        self.serial = result["serial"]
        time = result["resolved_scene"]["time"]
        self.seconds = time["frames"] / time["frame_rate"]
        self.step = time["step"]

    def name(self):
        return (f"{LABELS.get(self.scene, self.scene)} {self.result['triangle_count']:,}/"
                f"{self.level['triangles']:,}, {self.seconds:.3g} s"
                + (", sampled" if self.serial["extrapolated"] else ""))

    def name_and_step(self):
        return f"{self.name()}, 1/{1 / self.level['coarse_step_s']:.0f} s"

    def like_paper(self):
        """Whether the figures of the paper's Table 6 are of such steps and such a mesh."""
        finer = any(word.startswith("triangles=") for word in self.result["command"])
        return self.paper and abs(self.level["coarse_step_s"] - 0.02) < 1e-6 and not finer

    def steps(self):
        return f"1/{1 / self.step:.0f} s, 1/{1 / self.level['coarse_step_s']:.0f} s"

    def schedules(self, cost):
        """Rows by workers."""
        return {row["workers"]: row for row in self.level.get(f"schedules_by_{cost}", [])}

    def runs(self, least=2):
        return [run for run in self.level["runs"] if run["slices"] >= least]


def levels_of(result):
    if result.get("benchmark") != "time_parallel":
        return []
    return [Level(result, level) for level in result["coarse_levels"]]


def in_order(levels):
    """The paper's scenes first, then the others."""
    order = list(PAPER)
    place = lambda l: (order.index(l.of_paper) if l.paper else len(order), l.scene,
                       l.result["triangle_count"], l.seconds, -l.level["coarse_step_s"])
    return sorted(levels, key=place)


def columns(*names):
    """The first is text, the others are numbers."""
    return [(name, place > 0, None) for place, name in enumerate(names)]


def missing(levels, width):
    """Rows of the paper's scenes that there is nothing of."""
    there = {l.of_paper for l in levels}
    return [[scene, *[NONE] * width] for scene in PAPER if scene not in there]


def speedup_table(levels):
    """Table 6: from the cost of every step, as it was measured in slices, or of sampled ones."""
    found = [l for l in in_order(levels) if l.schedules("counted_work")]
    rows = []
    for l in found:
        paper = l.paper
        for cost, label in (("counted_work", "work"), ("clock", "clock")):
            rows_of = l.schedules(cost)
            bodies = l.result.get("obstacle_triangle_count")
            rows.append([f"{l.name()}, by {label}", "not noted" if bodies is None else f"{bodies:,}",
                         l.steps(), f"{l.level['ratio_by_' + cost]:.0f}",
                         *[f"{rows_of[p]['adaptive']:.1f}" if p in rows_of else "-"
                           for p in WORKERS],
                         f"{paper[1]:g}, {paper[2]:g} (K {paper[0]}, bodies {paper[8]})"
                         if l.like_paper() else "-"])
    rows += missing(found, len(WORKERS) + 4)
    return markdown(columns("scene, triangles fine/coarse, simulated", "triangles of bodies",
                            "fine, coarse step", "K", *[f"{p}" for p in WORKERS],
                            "paper: 64, 128"), rows)


def run_table(levels):
    """What was run, by the clock and against the formulas."""
    rows = []
    for l in in_order(levels):
        for run in l.runs():
            clock, work = run["by_clock"], run["by_counted_work"]
            bound = lambda json: (f"{json['bounds']['with_recovery']:.1f}, "
                                  f"{100 * json['efficiency']:.0f} %" if json["bounds"] else "-")
            iterations = run["recovery_iterations"]
            how = (" (extrapolated)" if l.serial["extrapolated"] else
                   " (of the slices' own steps)" if l.serial.get("from_slices") else "")
            rows.append([
                l.name_and_step(), run["partition"], f"{run['slices']}, {run['workers_at_once']}",
                f"{l.level.get('serial_wall_s', l.serial['wall_s']):.1f} s{how}",
                f"{run['wall_s']:.1f} s",
                f"{run['speedup_measured']:.1f}",
                f"{clock['speedup_with_a_core_each']:.1f}", bound(clock),
                f"{work['speedup_with_a_core_each']:.1f}", bound(work),
                f"{sum(iterations) / len(iterations):.1f} of "
                f"{run['recovery_iterations_by_formula']}",
                f"{work['recovery_steps']:.1f}"])
    return markdown(columns("scene, triangles fine/coarse, simulated, coarse step", "partition",
                            "slices, at once", "serial run", "in slices", "speed-up measured",
                            "a core each, by clock", "eq. 16, share", "by work", "eq. 16, share",
                            "recovery iterations", "steps' worth"), rows) if rows else ""


def partition_table(levels):
    """Table 3: adaptive over uniform partition, by measured steps."""
    rows = []
    counts = [p for p in WORKERS if p >= 8]
    for l in in_order(levels):
        for cost, label in (("counted_work", "work"), ("clock", "clock")):
            found = l.schedules(cost)
            if not found or l.serial["extrapolated"]:
                continue
            cell = lambda p, of: f"{found[p][of] / found[p]['uniform']:.2f}" if p in found else "-"
            rows.append([f"{l.name_and_step()}, by {label}",
                         *[f"{cell(p, 'adaptive')} ({cell(p, 'balanced')})" for p in counts]])
    if rows:
        rows.append(["paper", *[f"{PAPER_ADAPTIVE[p]:g}" for p in counts]])
    return markdown(columns("adaptive (balanced) over uniform", *[f"{p}" for p in counts]),
                    rows) if rows else ""


def length_table(levels):
    """Table 7: longer runs, measured where there are some, by eq. (16) where not."""
    rows = []
    for l in in_order(levels):
        measured = l.schedules("counted_work")
        if not measured:
            continue
        if 128 in measured:
            steps = "sampled" if l.serial["extrapolated"] else "measured"
            rows.append([f"{l.name_and_step()} ({steps} steps)", f"{l.seconds:.3g} s",
                         f"{measured.get(64, measured[128])['adaptive']:.1f}",
                         f"{measured[128]['adaptive']:.1f}",
                         f"{l.paper[{20: 2, 80: 3}[l.seconds]]:g}"
                         if l.like_paper() and l.seconds in (20, 80) else "-"])
        paper = l.paper
        predicted = l.level.get("prediction_by_counted_work", [])
        for seconds in sorted({row.get("simulated_s", 0) for row in predicted} & {20, 40, 80}):
            of = {row["workers"]: row["bounds"]["with_recovery"] for row in predicted
                  if row.get("simulated_s") == seconds and row["bounds"]}
            if of and l.seconds < seconds:
                rows.append([f"{l.name_and_step()} (eq. 16, extrapolated)", f"{seconds:g} s",
                             f"{of[64]:.1f}", f"{of[128]:.1f}",
                             f"{paper[3]:g}" if l.like_paper() and seconds == 80 else "-"])
    return markdown(columns("scene, what was run", "simulated", "64", "128", "paper: 128"),
                    rows) if rows else ""


def pair_table(levels, same, differs, apart, paper):
    """Levels that are alike but in one thing, at 32, 64 and 128 workers.

    same: of a level, what is alike   differs: of a level, a number
    apart: whether the least and the greatest of these differ enough
    paper: of the paper's figures and whether the level is the first of its group, that at 128
    """
    groups = {}
    for l in in_order(levels):
        if l.schedules("counted_work") and not l.serial["extrapolated"]:
            groups.setdefault(same(l), []).append(l)
    rows, shown = [], []
    for group in groups.values():
        group = sorted(group, key=differs)
        if not apart(differs(group[0]), differs(group[-1])):
            continue
        shown += group
        for l in group:
            found = l.schedules("counted_work")
            rows.append([l.name(), l.steps(), f"{l.level['ratio_by_counted_work']:.0f}",
                         f"{l.level['ratio_by_clock']:.0f}",
                         *[f"{found[p]['adaptive']:.1f}" if p in found else "-"
                           for p in (32, 64, 128)],
                         f"{paper(l.paper, differs(l) == differs(group[0])):g}" if l.paper else "-"])
    rows += missing(shown, 7)
    return markdown(columns("scene, triangles fine/coarse, simulated", "fine, coarse step", "K",
                            "by clock", "32", "64", "128", "paper: 128"), rows)


def prediction_table(levels):
    """Eq. (11) and (16) for more workers than anyone has here."""
    rows = []
    for l in in_order(levels):
        for cost, label in (("counted_work", "work"), ("clock", "clock")):
            predicted = [row for row in l.level.get(f"prediction_by_{cost}", [])
                         if row.get("simulated_s") == 20 and row["bounds"]]
            of = {row["workers"]: row["bounds"] for row in predicted}
            if not of:
                continue
            cell = lambda p: (f"{of[p]['least']:.1f} to {of[p]['balanced']:.1f}; "
                              f"{of[p]['with_recovery']:.1f}")
            rows.append([f"{l.name_and_step()}, by {label}",
                         cell(128), cell(512), cell(100000)])
    return markdown(columns("20 s of the scene", "128 workers: eq. 11; eq. 16", "512", "100,000"),
                    rows) if rows else ""


def accuracy_table(levels):
    """Table 4: eq. (17) against the serial run."""
    rows = []
    mean = lambda rows_, key, of: (sum(r[key][of] for r in rows_ if of in r.get(key, {}))
                                   / max(1, sum(of in r.get(key, {}) for r in rows_)))
    # A start that the fine run itself has led to would only be compared with itself.
    own = lambda state: state.get("after", {}).get("position_max_m") == 0
    states_of = lambda l: [s for s in l.level["accuracy"] if not own(s)]
    found = [l for l in in_order(levels) if states_of(l)]
    for l in found:
        states = states_of(l)
        paper = l.paper
        cell = lambda key: (f"{100 * mean(states, key, 'dihedral'):.1f} % "
                            f"({100 * mean(states, key, 'curvature'):.0f} %)"
                            if any("dihedral" in s.get(key, {}) for s in states) else "-")
        rows.append([l.name_and_step(), str(len(states)),
                     cell("before"), cell("after"), cell("before_from_averages"),
                     cell("after_from_averages"), cell("twin"),
                     f"{100 * paper[5]:g} %, {100 * paper[6]:g} %" if paper else "-"])
    rows += missing(found, 7)
    return markdown(columns("scene, triangles fine/coarse, simulated, coarse step", "states",
                            "before", "after", "from averages: before", "after",
                            "a serial run 1 um off", "paper: before, after"), rows)


def seam_table(levels):
    """What would pop, and what the coarse level takes of memory."""
    rows = []
    found = [l for l in in_order(levels) if l.runs()]
    for l in found:
        for run in l.runs():
            seams = run["seams"]
            share = seams.get("position_over_largest_frame_change")
            rows.append([
                l.name_and_step(), str(run["slices"]),
                f"{1e3 * seams['position_max_m']:.1f} mm",
                f"{1e3 * seams['position_rms_max_m']:.1f} mm",
                f"{share:.2f}" if share is not None else "-",
                f"{100 * seams['dihedral_max']:.1f} %" if "dihedral_max" in seams else "-",
                str(run["tangled_seam_states"]),
                f"{100 * l.level['device_bytes_over_fine']:.1f} %"])
    rows += missing(found, 7)
    return markdown(columns("scene, triangles fine/coarse, simulated, coarse step", "slices",
                            "largest jump", "rms", "over the largest frame change (aim: < 2)",
                            "eq. 17 across", "states that intersect",
                            "memory of the coarse level (paper: 5.5 %)"), rows)


def device_table(results):
    """Beside devices in space: speed-up over the first run of each file."""
    rows = []
    for _, result in results:
        if result.get("benchmark") != "time_parallel_devices":
            continue
        for run in result["runs"]:
            formulas = run.get("speedup_by_formulas") or {}
            cell = lambda key: f"{run[key]:.2f}" if key in run else run["message"] or NONE
            ratio = f"{formulas['ratio']:.1f}" if formulas else "-"
            coarse = run.get("coarse")
            if not formulas and coarse and run.get("fine_steps_s"):
                a_second = coarse["steps_s"] / coarse["steps"] / coarse["step"]
                ratio = f"{run['fine_steps_s'] / (a_second * run['simulated_s']):.2f}"
            rows.append([f"{result['scene']} {run['triangle_count']:,}, {run['simulated_s']:.3g} s"
                         if "triangle_count" in run else result["scene"], run["kind"],
                         run["device"], str(run["slices"]), cell("wall_s"), cell("speedup"),
                         ratio,
                         f"{formulas['with_recovery']:.2f}" if formulas else "-",
                         f"{max(run['starts_s']):.1f}" if run.get("starts_s") else "-",
                         f"{max(run['jump_over_frame_change']):.2f}"
                         if run.get("jump_over_frame_change") else "-"])
    rows = rows or [[NONE] * 10]
    rows += [["paper", who, devices, "1", "-", speedup, *["-"] * 4]
             for who, devices, speedup in PAPER_SPACE]
    return markdown(columns("scene, triangles, simulated", "run", "devices", "slices", "wall s",
                            "speed-up", "K", "eq. 16", "longest start, s",
                            "largest seam jump"), rows)


def failure_text(results):
    lines = [f"- {case}: {failure['failure']}\n" for case, result in results
             for failure in result.get("failures", [])]
    return "".join(lines)


def origin_text(results):
    """Which results are of which commit and machine."""
    files = {}
    for case, result in results:
        build, machine = result.get("build", result), result["machine"]
        origin = (f"commit {build['commit'][:10]}{' with changes' if build['dirty'] else ''} on "
                  f"{', '.join([machine['cpu'], *machine.get('devices', [])])}, "
                  f"{machine['threads']} threads")
        files.setdefault(origin, []).append(case.removeprefix("time_parallel_"))
    return "".join(f"- {origin}: {', '.join(names)}\n" for origin, names in files.items())


def table(paths):
    """All tables of some files and directories, each under what it shows."""
    results = []
    for path in paths:
        found = sorted(path.glob("time_parallel_*.json")) if path.is_dir() else [path]
        if not found:
            raise BadInput(f"{path}: no time_parallel_*.json")
        results += [item for file in found for item in read_cases(file).items()]
    scene = lambda l: (l.scene, l.step, l.result["resolved_scene"]["time"]["frames"])
    # Meshes that change never have the same number of triangles twice.
    stays = lambda l: l.result["resolved_scene"]["method"]["time_parallel"]["method"] == "implicit"
    texts = []
    try:
        levels = [level for _, result in results for level in levels_of(result)]
        parts = (
            ("Speed-up by workers, a core each: Algorithm 1 on the measured cost of every step, or "
             "of sampled ones (Table 6):", speedup_table(levels)),
            ("Runs in slices:", run_table(levels)),
            ("Partitions, by the same steps (Table 3):", partition_table(levels)),
            ("Longer runs (Table 7), by counted work:", length_table(levels)),
            ("Shorter coarse steps (Table 8, of 20 s), by counted work:",
             pair_table(levels,
                        lambda l: (*scene(l), stays(l) and l.result["triangle_count"]),
                        lambda l: -l.level["coarse_step_s"], lambda a, b: a < b,
                        lambda paper, first: paper[2 if first else 7])),
            ("Finer meshes (Table 2, of 20 s), by counted work:",
             pair_table(levels, lambda l: (*scene(l), l.level["coarse_step_s"]),
                        lambda l: l.result["triangle_count"], lambda a, b: b >= FINER * a,
                        lambda paper, first: KARATE_BASE if first and paper is PAPER["karate"]
                        else paper[2 if first else 4])),
            ("Predicted for 20 s (eq. 11 and 16):", prediction_table(levels)),
            ("Starts of slices against the serial run, eq. (17) by dihedral angles (by turning "
             "angles), on the starts' meshes, mean over states (Table 4):", accuracy_table(levels)),
            ("Seams and memory:", seam_table(levels)),
            ("Devices in space and slices of time (Fig. 8, 9, Table 5):", device_table(results)),
            ("What ended early:", failure_text(results)),
            ("Measured with:", origin_text(results)))
        texts = [f"{title}\n\n{text}" if title else text for title, text in parts if text]
    except (KeyError, TypeError, ValueError, IndexError, ZeroDivisionError) as error:
        raise BadInput(f"{', '.join(map(str, paths))}: {error!r}") from error
    return "\n".join(texts)


if __name__ == "__main__":
    sys.exit(main("time_parallel_table.py", __doc__, "results by case, or a directory of files", table, BEGIN, END))
