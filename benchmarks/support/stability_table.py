#!/usr/bin/env python3
"""Prints results of weft_bench_stability as a Markdown table, a row per case, a column per method.

    stability_table.py RESULT...                   RESULT: a file that --json or stability_record.py
                                                   wrote; several are one table, later ones adding
                                                   cases and methods
    stability_table.py --write DOCUMENT RESULT...  replaces the part of that file between the lines
                                                   <!-- stability --> and <!-- /stability -->

A cell says how many starts passed, were refused, and failed, and why the first of each was refused
or failed. Exit code 2 if a file cannot be read or lacks something, or there are no such lines.
"""

import re
import sys

from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN = "<!-- stability -->"
END = "<!-- /stability -->"
LONGEST_REASON = 90


def reason(runs):
    """Why the first of some runs ended as it did, in a few words."""
    text = " ".join(runs[0]["detail"].split())
    text = re.sub(r"^step \d+: ", "", text)
    return text if len(text) <= LONGEST_REASON else text[:LONGEST_REASON].rsplit(" ", 1)[0] + " ..."


def cell(runs):
    if not runs:
        return "not run"
    parts = []
    for kind in ("passed", "refused", "failed"):
        some = [run for run in runs if run["outcome"] == kind]
        if not some:
            continue
        shown = "**failed**" if kind == "failed" else kind
        parts.append(f"{len(some)} {shown}" + (f" ({reason(some)})" if kind != "passed" else ""))
    return ", ".join(parts).replace("|", "\\|")


def device_of(result):
    """What a column is called beside its method, unless it is the usual one."""
    return "" if result["device"] == "cpu:1" else f", {result['device']}"


def origin(result):
    build, machine = result["build"], result["machine"]
    return (f"commit {build['commit']}{' with changes' if build['dirty'] else ''} "
            f"({build['compiler']}) on {machine['cpu']}, {machine['threads']} threads")


def cells_of(result):
    """The cells of the table that a result of weft_bench_stability has: "CASE METHOD[, DEVICE]", and
    with it what the case is, the column, where the runs come from, and the runs."""
    shared = {key: result[key] for key in ("limit_s", "command", "build", "machine", "finished")
              if key in result}
    found = {}
    for case in result["cases"]:
        for method in result["methods"]:
            column = method + device_of(result)
            runs = [{key: value for key, value in run.items() if key not in ("case", "method")}
                    for run in result["runs"]
                    if run["case"] == case["name"] and run["method"] == method]
            if runs:
                found[f"{case['name']} {column}"] = {**case, "column": column, **shared, "runs": runs}
    return found


def read_cells(path):
    """The cells of a file, whichever program wrote it."""
    found = read_cases(path)
    try:
        if set(found) == {path.stem}:
            result = found[path.stem]
            if result.get("benchmark") != "stability":
                raise BadInput(f"{path}: not a result of weft_bench_stability")
            return cells_of(result)
        return found
    except (KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{path}: lacks {error!r}") from error


def outcome(runs):
    """How many runs passed, were refused, and failed."""
    return {kind: sum(run["outcome"] == kind for run in runs)
            for kind in ("passed", "refused", "failed")}


def table(paths):
    cases, columns, cells, origins = {}, {}, {}, {}
    for path in paths:
        for found in read_cells(path).values():
            try:
                cases[found["name"]] = found["about"]
                columns[found["column"]] = None
                by_seed = cells.setdefault((found["name"], found["column"]), {})
                by_seed.update({run["seed"]: run for run in found["runs"]})
                origins[origin(found)] = None
            except (KeyError, TypeError) as error:
                raise BadInput(f"{path}: lacks {error!r}") from error
    heads = [("case", False, None), ("what has to hold", False, None)]
    heads += [(column, False, None) for column in columns]
    rows = [[name, about.replace("|", "\\|"),
             *(cell(list(cells.get((name, column), {}).values())) for column in columns)]
            for name, about in cases.items()]
    runs = [run for some in cells.values() for run in some.values()]
    summary = ", ".join(f"{count} {kind}" for kind, count in outcome(runs).items())
    return markdown(heads, rows) + f"\n{len(runs)} runs: {summary}. Run at {'; '.join(origins)}.\n"


if __name__ == "__main__":
    sys.exit(main("stability_table.py", __doc__, "a file that --json or stability_record.py wrote",
                  table, BEGIN, END))
