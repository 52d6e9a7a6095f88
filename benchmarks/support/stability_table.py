#!/usr/bin/env python3
"""Prints a JSON file of weft_bench_stability as a Markdown table, a row a case, a column a method.

    stability_table.py RESULT...                   RESULT: a file that --json wrote; several are one
                                                   table, later ones adding cases and methods
    stability_table.py --write README.md RESULT... replaces what stands in that file between the lines
                                                   <!-- stability --> and <!-- /stability -->

A cell says how many starts passed, were refused, and failed, and why the first of each was refused
or failed. Exit code 2 if a file cannot be read or lacks something, or there are no such lines.
"""

import re
import sys

from markdown_table import BadInput, main, markdown, read_object

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
    for outcome in ("passed", "refused", "failed"):
        some = [run for run in runs if run["outcome"] == outcome]
        if not some:
            continue
        shown = "**failed**" if outcome == "failed" else outcome
        parts.append(f"{len(some)} {shown}" + (f" ({reason(some)})" if outcome != "passed" else ""))
    return ", ".join(parts).replace("|", "\\|")


def device_of(result):
    """What a column is called beside its method, unless it is the usual one."""
    return "" if result["device"] == "cpu:1" else f", {result['device']}"


def origin(result):
    build, machine = result["build"], result["machine"]
    return (f"commit {build['commit']}{' with changes' if build['dirty'] else ''} "
            f"({build['compiler']}) on {machine['cpu']}, {machine['threads']} threads")


def table(paths):
    cases, columns, cells, origins = {}, {}, {}, {}
    for path in paths:
        result = read_object(path)
        if result.get("benchmark") != "stability":
            raise BadInput(f"{path}: not a result of weft_bench_stability")
        try:
            for case in result["cases"]:
                cases[case["name"]] = case["about"]
            for method in result["methods"]:
                columns[method + device_of(result)] = None
            for run in result["runs"]:
                key = run["case"], run["method"] + device_of(result)
                cells.setdefault(key, {})[run["seed"]] = run
            origins[origin(result)] = None
        except (KeyError, TypeError) as error:
            raise BadInput(f"{path}: lacks {error!r}") from error
    heads = [("case", False, None), ("what has to hold", False, None)]
    heads += [(column, False, None) for column in columns]
    rows = [[name, about.replace("|", "\\|"),
             *(cell(list(cells.get((name, column), {}).values())) for column in columns)]
            for name, about in cases.items()]
    runs = [run for some in cells.values() for run in some.values()]
    counts = {outcome: sum(run["outcome"] == outcome for run in runs)
              for outcome in ("passed", "refused", "failed")}
    summary = ", ".join(f"{count} {outcome}" for outcome, count in counts.items())
    return markdown(heads, rows) + f"\n{len(runs)} runs: {summary}. Run at {'; '.join(origins)}.\n"


if __name__ == "__main__":
    sys.exit(main("stability_table.py", __doc__, "a file that --json wrote", table, BEGIN, END))
