#!/usr/bin/env python3
"""What contact.self_certificate saves, or costs: scenes with and without it, by turns.

    certificate_pairs.py PROGRAM FILE.json SCENE...          such as scenes/flag.json
    certificate_pairs.py PROGRAM FILE.json --pairs 5 --frames 10 --set triangles=10000 SCENE...

One rank of the host. A step's time is compared with that of the same step without, so that what
else the machine does hits both; the medians over all steps of all pairs stand in the file, with
build and machine. Exit code 0; 1 if a pair ends in different states; 2 for bad input.
"""

import sys
from pathlib import Path

from run_pairs import measure_all, median, step_ms, turns


def contact_ms(step):
    return step["stages_ms"]["contacts"] + step["stages_ms"]["resolve_collisions"]


def measure(arguments, scene):
    """Build, and one scene's line of the result."""
    pairs, same, report = [], True, None
    for one, other in turns(arguments, scene,
                            ["--experimental", "contact.self_certificate=true"],
                            ["--experimental", "contact.self_certificate=false"]):
        report = one[0]
        same = same and report["state_hash"] == other[0]["state_hash"]
        pairs += zip(one[1], other[1])
    held = [(a, b) for a, b in pairs if a["self_certified"]]
    not_held = [(a, b) for a, b in pairs if not a["self_certified"]]
    return report["build"], {
        "scene": Path(scene).stem, "same_state": same,
        "triangles": report["triangle_count"],
        "steps": len(pairs), "certified": len(held),
        "asked": sum(a["certificate_ms"] > 0 for a, _ in pairs),
        "certificate_ms": median(a["certificate_ms"] for a, _ in pairs if a["certificate_ms"] > 0),
        "certified_contact_ms": [median(contact_ms(p[k]) for p in held) for k in range(2)],
        "certified_step_ms": [median(step_ms(p[k]) for p in held) for k in range(2)],
        "certified_step_ratio": median(step_ms(a) / step_ms(b) for a, b in held),
        "other_step_ratio": median(step_ms(a) / step_ms(b) for a, b in not_held)}


if __name__ == "__main__":
    lines = measure_all(__doc__.splitlines()[0], measure, pairs=3, frames=5)
    sys.exit(0 if all(line["same_state"] for line in lines) else 1)
