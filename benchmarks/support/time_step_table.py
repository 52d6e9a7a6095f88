#!/usr/bin/env python3
"""Prints results of time_step_runs.py as a Markdown table, a row per set-up and time step.

    time_step_table.py [--write docs/accuracy.md] FILE...    FILE: one per device
"""

import re
import sys

from markdown_table import BadInput, main, markdown
from suite_file import read_cases

BEGIN, END = "<!-- time steps -->", "<!-- /time steps -->"


def table(paths):
    rows, devices, origins = {}, [], []
    for path in paths:
        for entry in read_cases(path).values():
            try:
                device = entry["device"].split(":")[0].replace("cuda", "CUDA").replace("cpu", "CPU")
                if device not in devices:
                    devices.append(device)
                build = entry["build"]
                card = re.search(r"NVIDIA [A-Z]+\d+", entry["device"])
                machine = card[0] if card else entry["machine"]["cpu"]
                origin = (f"{device}: {build['commit'][:7]}{' with changes' if build['dirty'] else ''}"
                          f", {machine}")
                if origin not in origins:
                    origins.append(origin)
                for row in entry["rows"]:
                    key = (entry["setup"], row["step_s"])
                    cells = rows.setdefault(key, {"about": entry["about"]})
                    cells[device] = (f"{'' if row['holds'] else '**misses**: '}{row['found']}; "
                                     f"{row['wall_s']} s")
            except (KeyError, TypeError) as error:
                raise BadInput(f"{path}: lacks {error!r}") from error
    columns = [("set-up", False, None), ("time step [s]", True, None),
               ("what has to hold", False, None)]
    columns += [(f"{device}; wall time", False, None) for device in devices]
    text = markdown(columns, [
        [setup, str(step), cells["about"], *(cells.get(device, "-") for device in devices)]
        for (setup, step), cells in rows.items()])
    return f"{text}\n{'; '.join(origins)}.\n"


if __name__ == "__main__":
    sys.exit(main("time_step_table.py", __doc__, "a file of time_step_runs.py", table, BEGIN, END))
