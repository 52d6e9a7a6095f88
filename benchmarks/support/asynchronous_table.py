#!/usr/bin/env python3
"""Prints what weft_bench_asynchronous has measured at the paper's sizes as Markdown tables.

    asynchronous_table.py FILE                  FILE: results by case, as suite_file.py writes them.
                                                A case is called SCENE_HOW, threads_SCENE_COUNT,
                                                windows_SCENE_HOW or twister_frames_HOW
    asynchronous_table.py --write DOCUMENT FILE replaces the part of that file between the lines
                                                <!-- asynchronous --> and <!-- /asynchronous -->

Durations of runs that were sampled are extrapolated and say so. Exit code 2 if a result cannot be
read or lacks a figure, or the file has no such lines.
"""

import sys
from fnmatch import fnmatchcase

from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN = "<!-- asynchronous -->"
END = "<!-- /asynchronous -->"

# Scene as files name it, and what Ainsley et al. 2012 have for it on one thread: no slabs, all of
# it [min], and all of it on 12 threads. Their eta(1) is not published: thin_two_cloths is two_cloths
# with that of the knots.
PAPER = (
    ("reef_knot", 74, 50.5, 5.8),
    ("bowline", 294, 121, 15.2),
    ("trash_compactor", 53.5, 13.3, 2.4),
    ("two_cloths", 402, 282, 40.1),
    ("thin_two_cloths", 402, 282, 40.1),
)
MISSING = "not measured"
# A run that is extrapolated from fewer windows says nothing.
LEAST_WINDOWS = 200
PARTS = ("useful", "resimulation", "detection", "unneeded", "bookkeeping")


SUMS = (("timed_steps", "timed_s", "timed_cpu_s", "events", "windows", "clean_windows", "rollbacks",
         "candidates", "slabs", "failsafe", "ccd_tests")
        + tuple(f"{part}_s" for part in PARTS))


def merged(parts):
    """One result of those that processes side by side have taken of one way, each from states of
    its own: sums, and what the whole takes by all of them."""
    if any(part["build"] != parts[0]["build"] for part in parts):
        raise BadInput("parts of one result are of different builds")
    whole = dict(parts[0], samples=[])
    for of_parts in zip(*(part["samples"] for part in parts)):
        taken = [s for s in of_parts if s["timed_steps"] > 0]
        if not taken:
            continue
        steps = round(taken[0]["wall_s"] / taken[0]["timed_s"] * taken[0]["timed_steps"])
        sample = dict(taken[0], **{key: sum(s[key] for s in taken) for key in SUMS})
        sample["wall_s"] = sample["timed_s"] * steps / sample["timed_steps"]
        if sample["events"]:
            sample["wall_s_per_million_events"] = sample["timed_s"] / sample["events"] * 1e6
        sample["failure"] = next((s["failure"] for s in taken if s["failure"] != "none"), "none")
        whole["samples"].append(sample)
    return whole


def results(cases, pattern):
    """The cases whose names match; NAME_part_K are one."""
    found = {}
    for name in sorted(cases):
        if fnmatchcase(name, pattern):
            found.setdefault(name.partition("_part_")[0], []).append(cases[name])
    return {name: parts[0] if len(parts) == 1 else merged(parts) for name, parts in found.items()}


def samples(found):
    """Samples that say something, each with the result that it is of."""
    return [(result, sample) for result in found.values() for sample in result["samples"]
            if not sample["extrapolated"] or sample["windows"] >= LEAST_WINDOWS]


def minutes(sample):
    """What the run takes, and how that is known."""
    how = f" (extrapolated from {sample['windows']} windows)" if sample["extrapolated"] else ""
    cut = f", first {sample['simulated_s']:.3g} s" if sample["stopped_by_limit"] else ""
    return f"{sample['wall_s'] / 60:.3g} min{how}{cut}"


def pick(found, narrow, threads):
    """The whole run of that kind, else what was sampled of one; of runs that were cut the longest.
    None if there is none."""
    fitting = [(r, s) for r, s in samples(found)
               if s["narrow"] == narrow and s["threads"] == threads and s["failure"] == "none"
               and abs(s["window_s"] - 0.003) < 1e-9 and s["timed_steps"] > 0]
    return min(fitting, key=lambda rs: (rs[1]["stopped_by_limit"], rs[1]["extrapolated"],
                                        -rs[1]["simulated_s"]), default=None)


def scene_table(cases):
    """The paper's table 1: durations on one thread, and against our own detection without slabs."""
    columns = [(text, number, None) for text, number in (
        ("scene", False), ("vertices", True), ("simulated", True), ("eta(1)", True), ("r(1)", True),
        ("million events", True), ("all of it", True), ("no slabs", True),
        ("s a million events, all of it / no slabs", True), ("ratio", True),
        ("paper: all of it / no slabs", True), ("paper's ratio", True), ("failsafe", True),
        ("peak", True))]
    rows = []
    for scene, paper_ccd, paper_all, _ in PAPER:
        found = results(cases, f"{scene}_*")
        slabs, ccd = pick(found, "slabs", 1), pick(found, "ccd", 1)
        if slabs is None:
            rows.append([scene] + ["-"] * 5 + [MISSING] + ["-"] * 7)
            continue
        result, sample = slabs
        columns_of_ccd = [MISSING, f"{sample['wall_s_per_million_events']:.3f} / -", "-"]
        if ccd is not None:
            # The ratio compares what was taken in the same way.
            same = [s for r, s in samples(found) if s["narrow"] == "slabs" and s["threads"] == 1
                    and s["extrapolated"] == ccd[1]["extrapolated"] and s["timed_steps"] > 0
                    and s["failure"] == "none"
                    and s["window_s"] == ccd[1]["window_s"]
                    and s["simulated_s"] == ccd[1]["simulated_s"]]
            per_event = [s["timed_s"] / s["events"] * 1e6 for s in (same or [sample])[:1] + [ccd[1]]]
            columns_of_ccd = [minutes(ccd[1]), f"{per_event[0]:.3f} / {per_event[1]:.3f}",
                              f"{per_event[1] / per_event[0]:.2f}" if same else "-"]
        calls = sample["candidates"]
        rows.append([
            scene, f"{result['vertex_count']:,}", f"{sample['simulated_s']:.3g} s",
            f"{result['eta_1_m'] * 1e3:g} mm", f"{result['r_1_N_per_m']:g} N/m",
            f"{sample['events'] / 1e6:,.0f}", minutes(sample), *columns_of_ccd,
            f"{paper_all:g} / {paper_ccd:g} min", f"{paper_ccd / paper_all:.2f}",
            f"{100 * sample['failsafe'] / calls:.3f} %" if calls else "-",
            f"{result['peak_bytes'] / 1e6:.0f} MB"])
    return markdown(columns, rows) if any(MISSING not in row for row in rows) else ""


def twelve_table(cases):
    """The paper's table 1 again: twelve threads."""
    columns = [(text, number, None) for text, number in (
        ("scene", False), ("simulated", True), ("one thread", True), ("12 threads", True),
        ("ratio", True), ("paper: one / 12 threads", True), ("paper's ratio", True))]
    rows = []
    for scene, _, paper_one, paper_twelve in PAPER:
        found = results(cases, f"{scene}_*")
        several, one = pick(found, "slabs", 12), pick(found, "slabs", 1)
        if several is None:
            continue
        sample = several[1]
        alike = one and all(one[1][key] == sample[key]
                            for key in ("simulated_s", "window_s", "extrapolated"))
        ratio = alike and sample["events"] and (one[1]["timed_s"] / one[1]["events"]
                                              / (sample["timed_s"] / sample["events"]))
        rows.append([scene, f"{sample['simulated_s']:.3g} s", minutes(one[1]) if one else MISSING,
                     minutes(sample), f"{ratio:.2f}" if ratio else "-",
                     f"{paper_one:g} / {paper_twelve:g} min", f"{paper_one / paper_twelve:.2f}"])
    return markdown(columns, rows) if rows else ""


def thread_table(cases):
    """Figure 7: how much faster several threads are."""
    found = results(cases, "threads_*")
    if not found:
        return ""
    counts = sorted({s["threads"] for _, s in samples(found)})
    columns = [("scene", False, None)] + [(f"{n} threads", True, None) for n in counts]
    rows = []
    for scene in sorted({result["scene"] for result in found.values()}):
        of_scene = {name: r for name, r in found.items() if r["scene"] == scene}
        # One thread begins nothing ahead.
        pace = {(s["threads"], s["threads"] > 1 and s.get("optimistic", False)):
                s["timed_s"] / s["events"] for _, s in samples(of_scene)
                if s["events"] and s["failure"] == "none"}
        if (1, False) not in pace:
            continue
        for optimistic in sorted({how for n, how in pace if n > 1}):
            rows.append([scene + (" (optimistic)" if optimistic else "")]
                        + [f"{pace[1, False] / pace[n, optimistic and n > 1]:.2f}"
                           if (n, optimistic and n > 1) in pace else MISSING for n in counts])
    return markdown(columns, rows)


def share_table(cases):
    """Figures 1, 8 and 9: where the time goes, by window length."""
    columns = [(text, number, None) for text, number in (
        ("scene", False), ("simulated", True), ("R", True), ("s for a simulated s", True),
        ("useful", True), ("resimulation", True), ("detection", True), ("unneeded", True), ("bookkeeping", True),
        ("windows without rollback", True))]
    rows = []
    for scene, *_ in PAPER:
        taken = {}
        found = {**results(cases, f"{scene}_*"), **results(cases, f"windows_{scene}_*")}
        for _, s in samples(found):
            if s["narrow"] != "slabs" or s["threads"] != 1 or not s["timed_steps"]:
                continue
            taken.setdefault((round(s["simulated_s"], 6), s["window_s"], not s["extrapolated"]), s)
        for (simulated, window, _), s in sorted(taken.items()):
            whole = sum(s[f"{part}_s"] for part in PARTS)
            rows.append([scene + (" (sampled)" if s["extrapolated"] else ""), f"{simulated:g} s",
                         f"{window * 1e3:g} ms",
                         f"{s['wall_s'] / s['simulated_s']:.3g}"]
                        + [f"{100 * s[f'{part}_s'] / whole:.0f} %" for part in PARTS]
                        + [f"{100 * s['clean_windows'] / s['windows']:.0f} %"])
    return markdown(columns, rows) if rows else ""


def frame_table(cases):
    """Figure 6: rollbacks and seconds a frame of the twister, by simulated second."""
    found = results(cases, "twister_frames*")
    columns = [("simulated s", True, None), ("threads", True, None),
               ("rollbacks a frame", True, None), ("s a frame", True, None)]
    rows = []
    for result, sample in samples(found):
        if sample["extrapolated"]:
            continue
        rate = result["resolved_scene"]["time"]["frame_rate"]
        for first in range(0, len(sample["frame_wall_s"]), round(rate)):
            part = slice(first, first + round(rate))
            mean = [sum(sample[key][part]) / len(sample[key][part])
                    for key in ("frame_rollbacks", "frame_wall_s")]
            rows.append([f"{first / rate:g}", f"{sample['threads']}", f"{mean[0]:.1f}",
                         f"{mean[1]:.3f}"])
    if not rows:
        return ""
    return markdown(columns, rows)


def table(paths):
    """All tables of one file, each under what it shows."""
    if len(paths) != 1:
        raise BadInput(f"{len(paths)} files; one at a time")
    cases = read_cases(paths[0])
    parts = (("One thread, against Ainsley et al. 2012 (a machine of 2010):", scene_table),
             ("Twelve threads, as the paper has them:", twelve_table),
             ("Speed on several threads over that on one:", thread_table),
             ("Where the time goes, by the length R of windows:", share_table),
             ("The twister, by simulated time:", frame_table))
    texts = []
    for title, make in parts:
        try:
            text = make(cases)
        except (KeyError, TypeError, ValueError, IndexError, ZeroDivisionError) as error:
            raise BadInput(f"{paths[0]}: {title} {error!r}") from error
        if text:
            texts.append(f"{title}\n\n{text}")
    if not texts:
        raise BadInput(f"{paths[0]}: no case that a table shows")
    return "\n".join(texts)


if __name__ == "__main__":
    sys.exit(main("asynchronous_table.py", __doc__, "results by case", table, BEGIN, END))
