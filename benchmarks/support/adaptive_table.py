#!/usr/bin/env python3
"""Prints JSON files of weft_bench_adaptive and weft_bench_looks as Markdown tables.

    adaptive_table.py RESULT...                   RESULT: a file that --json or suite_file.py wrote;
                                                  runs of one scene and one set of overrides are
                                                  compared
    adaptive_table.py --write DOCUMENT RESULT...  replaces the part of that file between the lines
                                                  <!-- adaptive --> and <!-- /adaptive -->

Methods are compared over the frames that all of them have done: runs that were cut short, by
--seconds or a time limit, say so. Where scenes have been run at the paper's sizes, those and
methods that are missing are said to be not measured. Exit code 2 if a file cannot be read or lacks something, or there
are no such lines.
"""

import sys

from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN = "<!-- adaptive -->"
END = "<!-- /adaptive -->"
METHODS = ("implicit", "adaptive", "view")
# Koh, Narain and O'Brien 2015, Table 1: adaptive over fixed, view over adaptive.
PAPER = {"karate.json": (2.04, 2.39), "dancer.json": (1.85, 2.09), "dancers_10.json": (2.13, 4.45)}
# Mean faces there.
PAPER_FACES = {"karate.json": (123790, 41973, 21501), "dancer.json": (43710, 18041, 9638),
               "dancers_10.json": (437100, 161028, 36339)}
LOOKS = (
    ("silhouette_mean_px", "silhouette, mean [px]", 2), ("silhouette_p95_px", "95 % [px]", 2),
    ("shade_rms", "shade, r.m.s.", 3), ("shade_share_off_by_a_tenth", "off by a tenth", 3),
    ("largest_px", "farthest beyond [px]", 2), ("p99_px", "99 % [px]", 3),
    ("rms_px", "r.m.s. [px]", 3), ("distance_m", "distance [m]", 4),
    ("mean_height_m", "height [m]", 4), ("width_m", "width [m]", 4),
    ("area_over_rest", "area over rest", 4))


def number(value, digits=3):
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.{digits}g}"


def spread(values):
    return [number(f(values)) for f in (min, max, lambda v: sum(v) / len(v))]


def origin(result):
    build, machine = result["build"], result["machine"]
    return (f"commit {build['commit'][:10]}{' with changes' if build['dirty'] else ''} on "
            f"{machine['cpu']}, {machine['threads']} threads")


def headings(*columns):
    return [(text, is_number, None) for text, is_number in columns]


def arcsim_table(results):
    rows = []
    for result in results:
        runs = result["runs"]
        for run in (r for r in runs if r["method"] == "adaptive"):
            faces = run["faces_by_frame"]
            told = ", ".join(
                f"{frame}: {faces[int(frame) - 1]:,.0f} ({theirs:,})"
                for frame, theirs in run["arcsim_faces_by_frame"].items()
                if 0 < int(frame) <= len(faces))
            ratio = run["arcsim_over_weft"]
            distances = {r["method"]: r["distance_m"] for r in runs if r.get("distance_m")}
            rows.append([run["scene"], f"{run['frames']} of {run['frames_asked']}", told,
                         f"{run['cpu_s']:.3g}", f"{run['arcsim_cpu_s']:g}",
                         "not done" if ratio is None else f"{ratio:.1f}",
                         f"{100 * run['remeshing_share']:.0f} %",
                         f"{100 * run['remeshing_cpu_share']:.0f} %"
                         if "remeshing_cpu_share" in run else "not measured",
                         f"{100 * run['energy_jump_share']:.2g} %",
                         *(f"{distances[m]['mean']:.3g}" if m in distances else ""
                           for m in ("adaptive", "uniform"))])
    columns = headings(("scene", False), ("frames", False), ("faces by frame (ARCSim's)", False),
                       ("CPU s", True), ("ARCSim", True), ("ratio", True), ("remeshing", True),
                       ("of CPU s", True), ("energy jump", True), ("distance [m]", True), ("uniform [m]", True))
    return markdown(columns, sorted(rows)) if rows else ""


def groups_of(results):
    """Runs by scene, overrides, criteria and device, then by method."""
    groups = {}
    for result in results:
        overrides = " ".join(result["overrides"])
        coarser = result.get("coarser", 1)
        # What an edge may turn, shrink and shear by, against that of the scene's own mesh.
        criteria = f"times {coarser:g}" if coarser != 1 else (
            "of the full mesh" if "triangles=" in overrides else "the scene's")
        for run in result["runs"]:
            key = (result["scene"], overrides, criteria, result["device"])
            groups.setdefault(key, {})[run["method"]] = run
    return groups


def is_full_size(scene, overrides):
    return scene in PAPER and "triangles=" not in overrides


def missing_rows(groups):
    """Of the paper's sizes, if any have been run."""
    full = {scene: set(runs) for (scene, overrides, _, _), runs in groups.items()
            if is_full_size(scene, overrides)}
    if not full:
        return []
    missing = [(scene, method) for scene in PAPER for method in METHODS
               if method not in full.get(scene, ())]
    return [[scene, "", "", "", method, "not measured"] for scene, method in missing]


def speed_tables(results):
    rows, growth = [], []
    groups = groups_of(results)
    for (scene, overrides, criteria, device), runs in sorted(groups.items()):
        common = min(len(run["wall_s_by_frame"]) for run in runs.values())
        if common == 0:
            rows.append([scene, overrides, criteria, device, ", ".join(runs), "no frame was done"])
            continue
        mean = {m: sum(r["wall_s_by_frame"][:common]) / common for m, r in runs.items()}
        for method in (m for m in METHODS if m in runs):
            run = runs[method]
            walls = run["wall_s_by_frame"][:common]
            ratios = [f"{mean[of] / mean[method]:.2f}" if of in mean and of != method else ""
                      for of in ("implicit", "adaptive")]
            theirs = {"adaptive": 0, "view": 1}.get(method)
            paper = PAPER.get(scene)
            ratios.append(f"{paper[theirs]:.2f}" if paper and theirs is not None else "")
            faces = (f"{PAPER_FACES[scene][METHODS.index(method)]:,}"
                     if is_full_size(scene, overrides) else "")
            done = f"{common} of {run['frames_asked']}"
            rows.append([scene, overrides, criteria, device,
                         method + (" (failed)" if run["failure"] else ""), done,
                         *spread(run["faces_by_frame"][:common]), faces, *spread(walls), *ratios,
                         f"{100 * run['remeshing_share']:.0f} %"])
            growth.append([scene, overrides, criteria, method, *(
                number(sum(walls[:max(1, round(common * part / 4))])) for part in (1, 2, 3, 4))])
    rows += missing_rows(groups)
    first = headings(("scene", False), ("overrides", False), ("criteria", False),
                     ("device", False), ("method", False), ("frames", False),
                     ("faces, least", True), ("most", True), ("mean", True),
                     ("paper's mean", True), ("s a frame, least", True), ("most", True), ("mean", True),
                     ("over implicit", True), ("over adaptive", True), ("paper's", True),
                     ("remeshing", True))
    second = headings(("scene", False), ("overrides", False), ("criteria", False),
                      ("method", False),
                      ("s after 1/4 of the frames", True), ("1/2", True), ("3/4", True),
                      ("all", True))
    if not rows:
        return []
    rows = [[*cells, *[""] * (len(first) - len(cells))] for cells in rows]
    return [markdown(first, rows), markdown(second, growth)]


def looks_table(result):
    runs = result["runs"]
    head = (f"`{result['measure']}` of {result['scene']}, {result['frames']} of "
            f"{result['frames_asked']} frames, {result['resolution'][0]} x "
            f"{result['resolution'][1]} pixels, {' '.join(result['overrides'])}:\n\n")
    if result["measure"] == "edges":
        rows = []
        for run in runs:
            for place, cloth in enumerate(run["by_frame"][-1]["cloths"]):
                rows.append([run["name"], str(place), f"{cloth['distance_m']:.2f}",
                             f"{cloth['faces']:,}", f"{cloth['edges_seen']:,}",
                             f"{cloth['shortest_px']:.2f}", f"{cloth['p5_px']:.2f}",
                             f"{cloth['median_px']:.2f}"])
        return head + markdown(headings(
            ("run", False), ("in the row", True), ("distance [m]", True), ("faces", True),
            ("edges seen", True), ("shortest [px]", True), ("5 % are shorter than [px]", True),
            ("half are [px]", True)), rows)
    shown = [(key, text, digits) for key, text, digits in LOOKS
             if any(key in run["summary"] for run in runs)]
    columns = headings(("run", False), ("faces, mean", True), ("s", True), *(
        (f"{text}, {kind}", True) for _, text, _ in shown for kind in ("mean", "most")))
    rows = []
    for run in runs:
        cells = [run["name"] + (" (failed)" if run["failure"] else ""), number(run["faces_mean"]),
                 f"{run['wall_s']:.3g}"]
        for key, _, digits in shown:
            values = run["summary"].get(key)
            cells += [f"{values[kind]:.{digits}f}" if values else "" for kind in ("mean", "max")]
        rows.append(cells)
    return head + markdown(columns, rows)


def table(paths):
    results = [item for path in paths for item in read_cases(path).items()]
    parts = []
    try:
        adaptive = [r for _, r in results if r["benchmark"] == "adaptive"]
        looks = [r for _, r in results if r["benchmark"] == "looks"]
        if len(adaptive) + len(looks) < len(results):
            raise BadInput("a file is no result of weft_bench_adaptive or weft_bench_looks")
        parts.append(arcsim_table([r for r in adaptive if r["scene"] == "ARCSim's"]))
        parts += speed_tables([r for r in adaptive if r["scene"] != "ARCSim's"])
        parts += [looks_table(r) for r in looks if r.get("runs")]
        origins = sorted({origin(r) for _, r in results})
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise BadInput(f"a result lacks something: {error!r}") from error
    parts.append("Measured with " + "; ".join(origins) + ".\n")
    return "\n".join(part for part in parts if part)


if __name__ == "__main__":
    sys.exit(main("adaptive_table.py", __doc__, "a file that --json or suite_file.py wrote", table, BEGIN, END))
