#!/usr/bin/env python3
"""What method.implicit.sleep_distance saves: scenes with and without it, by turns.

    sleep_pairs.py PROGRAM FILE.json SCENE...          such as scenes/stack.json
    sleep_pairs.py PROGRAM FILE.json --pairs 3 --frames 100 --set triangles=2000 SCENE...

One rank of the host; cloth may depart by a millimetre. A step's time is compared with that of the
same step without, so that what else the machine does hits both: medians of those steps in which
something slept, and of those before, and the ratio of whole runs. They stand in the file with
build, machine, how much slept, by how much that departed at most by its own bound, and by how much
any vertex of each cloth did at the end: what never slept may go another way altogether where it is
chaotic. Exit code 0; 1 if something departs by more than the bound; 2 for bad input.
"""

import math
import sys
from pathlib import Path

from run_pairs import measure_all, median, turns

BOUND_M = 0.001


def step_ms(step):
    """With what sleep itself takes, which is in no stage."""
    return step["wall_s"] * 1e3


def asleep(step):
    return step.get("sleep", {}).get("asleep", 0) > 0


def measure(arguments, scene):
    """Build, and one scene's line of the result."""
    pairs, reports, ratios, apart = [], [], [], {}
    for one, other in turns(arguments, scene,
                            ["--set", f"method.implicit.sleep_distance={BOUND_M}"],
                            ["--set", "method.implicit.sleep_distance=0"]):
        reports.append(one[0])
        for name, places in one[2].items():
            apart[name] = max(apart.get(name, 0.0), *map(math.dist, places, other[2][name]))
        steps = list(zip(one[1], other[1]))
        ratios.append(sum(step_ms(a) for a, _ in steps) / sum(step_ms(b) for _, b in steps))
        pairs += steps
    slept = [(a, b) for a, b in pairs if asleep(a)]
    before = [(a, b) for a, b in pairs if not asleep(a)]
    sleep = reports[0]["sleep"]
    return reports[0]["build"], {
        "scene": Path(scene).stem, "triangles": reports[0]["triangle_count"],
        "bound_m": BOUND_M, "departure_m": sleep["departure"],
        "end_apart_m": apart,
        "steps": len(pairs), "steps_with_sleep": len(slept),
        "asleep_share": sleep["asleep"], "fell_asleep": sleep["fell_asleep"],
        "woken": sleep["woken"], "redone": sleep["redone"],
        "sleep_step_ms": [median(step_ms(p[k]) for p in slept) for k in range(2)],
        "sleep_step_ratio": median(step_ms(a) / step_ms(b) for a, b in slept),
        "other_step_ratio": median(step_ms(a) / step_ms(b) for a, b in before),
        "run_ratio": median(ratios)}


if __name__ == "__main__":
    lines = measure_all(__doc__.splitlines()[0], measure, pairs=3, frames=60)
    sys.exit(0 if all(line["departure_m"] <= line["bound_m"] for line in lines) else 1)
