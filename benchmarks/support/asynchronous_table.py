#!/usr/bin/env python3
"""Prints what weft_bench_asynchronous has measured at the paper's sizes as Markdown tables.

    asynchronous_table.py DIR                   DIR: holds asynchronous_*.json
    asynchronous_table.py --write README.md DIR replaces what stands in that file between the lines
                                                <!-- asynchronous --> and <!-- /asynchronous -->

Durations of runs that were sampled are extrapolated and say so. Exit code 2 if a result cannot be
read or lacks a figure, or the file has no such lines.
"""

import sys

from markdown_table import BadInput, main, markdown, read_object

BEGIN = "<!-- asynchronous -->"
END = "<!-- /asynchronous -->"

# Scene, and what Ainsley et al. 2012 have for it on one thread: no slabs, all of it [min], and
# all of it on 12 threads.
PAPER = (
    ("reef_knot", 74, 50.5, 5.8),
    ("bowline", 294, 121, 15.2),
    ("trash_compactor", 53.5, 13.3, 2.4),
    ("two_cloths", 402, 282, 40.1),
)
# A run that is extrapolated from fewer windows says nothing.
LEAST_WINDOWS = 200
PARTS = ("useful", "resimulation", "detection", "unneeded", "bookkeeping")


def results(directory, pattern):
    """The results in a directory by name, those whose files match."""
    found = {}
    for path in sorted(directory.glob(f"asynchronous_{pattern}.json")):
        found[path.stem.removeprefix("asynchronous_")] = read_object(path)
    return found


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


def scene_table(directory):
    """The paper's table 1: durations on one thread, and against our own detection without slabs."""
    columns = [(text, number, None) for text, number in (
        ("scene", False), ("vertices", True), ("simulated", True), ("eta(1)", True), ("r(1)", True),
        ("million events", True), ("all of it", True), ("no slabs", True),
        ("s a million events, all of it / no slabs", True), ("ratio", True),
        ("paper: all of it / no slabs", True), ("paper's ratio", True), ("failsafe", True),
        ("peak", True))]
    rows = []
    for scene, paper_ccd, paper_all, _ in PAPER:
        found = results(directory, f"{scene}_*")
        slabs, ccd = pick(found, "slabs", 1), pick(found, "ccd", 1)
        if slabs is None or ccd is None:
            continue
        result, sample = slabs
        # The ratio compares what was taken in the same way.
        same = [s for r, s in samples(found) if s["narrow"] == "slabs" and s["threads"] == 1
                and s["extrapolated"] == ccd[1]["extrapolated"] and s["timed_steps"] > 0
                and s["window_s"] == ccd[1]["window_s"]
                and s["simulated_s"] == ccd[1]["simulated_s"]]
        of_ratio = same[0] if same else sample
        per_event = [s["timed_s"] / s["events"] * 1e6 for s in (of_ratio, ccd[1])]
        calls = sample["candidates"]
        rows.append([
            scene, f"{result['vertex_count']:,}", f"{sample['simulated_s']:.3g} s",
            f"{result['eta_1_m'] * 1e3:g} mm", f"{result['r_1_N_per_m']:g} N/m",
            f"{sample['events'] / 1e6:,.0f}", minutes(sample), minutes(ccd[1]),
            f"{per_event[0]:.3f} / {per_event[1]:.3f}", f"{per_event[1] / per_event[0]:.2f}",
            f"{paper_all:g} / {paper_ccd:g} min", f"{paper_ccd / paper_all:.2f}",
            f"{100 * sample['failsafe'] / calls:.3f} %" if calls else "-",
            f"{result['peak_bytes'] / 1e6:.0f} MB"])
    return markdown(columns, rows) if rows else ""


def thread_table(directory):
    """Figure 7: how much faster several threads are."""
    found = results(directory, "threads_*")
    if not found:
        return ""
    counts = sorted({s["threads"] for _, s in samples(found)})
    columns = [("scene", False, None)] + [(f"{n} threads", True, None) for n in counts]
    rows = []
    for name, result in found.items():
        # One thread begins nothing ahead.
        pace = {(s["threads"], s["threads"] > 1 and s.get("optimistic", False)):
                s["timed_s"] / s["events"]
                for _, s in samples({name: result}) if s["events"]}
        if (1, False) not in pace:
            continue
        for optimistic in sorted({how for _, how in pace}):
            rows.append([name.removeprefix("threads_") + (" (optimistic)" if optimistic else "")]
                        + [f"{pace[1, False] / pace[n, optimistic]:.2f}"
                           if (n, optimistic) in pace else "-" for n in counts])
    return markdown(columns, rows)


def share_table(directory):
    """Figures 1, 8 and 9: where the time goes, by window length."""
    columns = [(text, number, None) for text, number in (
        ("scene", False), ("R", True), ("s for a simulated s", True), ("useful", True),
        ("resimulation", True), ("detection", True), ("unneeded", True), ("bookkeeping", True),
        ("windows without rollback", True))]
    rows = []
    for scene, *_ in PAPER:
        taken = {}
        for _, s in samples(results(directory, f"{scene}_*")):
            if s["narrow"] != "slabs" or s["threads"] != 1 or not s["timed_steps"]:
                continue
            taken.setdefault((s["window_s"], not s["extrapolated"]), s)
        for (window, _), s in sorted(taken.items()):
            whole = sum(s[f"{part}_s"] for part in PARTS)
            rows.append([scene + (" (sampled)" if s["extrapolated"] else ""), f"{window * 1e3:g} ms",
                         f"{s['wall_s'] / s['simulated_s']:.3g}"]
                        + [f"{100 * s[f'{part}_s'] / whole:.0f} %" for part in PARTS]
                        + [f"{100 * s['clean_windows'] / s['windows']:.0f} %"])
    return markdown(columns, rows) if rows else ""


def frame_table(directory):
    """Figure 6: rollbacks and seconds a frame of the twister, by simulated second."""
    found = results(directory, "twister_frames")
    if not found:
        return ""
    result, sample = samples(found)[0]
    rate = result["resolved_scene"]["time"]["frame_rate"]
    columns = [("simulated s", True, None), ("rollbacks a frame", True, None),
               ("s a frame", True, None)]
    rows = []
    for first in range(0, len(sample["frame_wall_s"]), round(rate)):
        part = slice(first, first + round(rate))
        mean = [sum(sample[key][part]) / len(sample[key][part])
                for key in ("frame_rollbacks", "frame_wall_s")]
        rows.append([f"{first / rate:g}", f"{mean[0]:.1f}", f"{mean[1]:.3f}"])
    return markdown(columns, rows)


def table(paths):
    """All tables of one directory, each under what it shows."""
    if len(paths) != 1:
        raise BadInput("one directory, please")
    parts = (("One thread, against Ainsley et al. 2012 (a machine of 2010):", scene_table),
             ("Speed on several threads over that on one:", thread_table),
             ("Where the time goes, by the length R of windows:", share_table),
             ("The twister, by simulated time:", frame_table))
    texts = []
    for title, make in parts:
        try:
            text = make(paths[0])
        except (KeyError, TypeError, ValueError, IndexError, ZeroDivisionError) as error:
            raise BadInput(f"{paths[0]}: {title} {error!r}") from error
        if text:
            texts.append(f"{title}\n\n{text}")
    if not texts:
        raise BadInput(f"{paths[0]}: no asynchronous_*.json")
    return "\n".join(texts)


if __name__ == "__main__":
    sys.exit(main("asynchronous_table.py", __doc__, "a directory of results", table, BEGIN, END))
