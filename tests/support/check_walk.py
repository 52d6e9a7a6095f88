#!/usr/bin/env python3
"""Is scenes/walk.bvh what scenes/make_walk.py writes? Numbers may differ by their last digit, since
sines do from one C library to the next.

usage: check_walk.py [REPOSITORY]
"""

import importlib.util
import pathlib
import sys


def main() -> int:
    here = pathlib.Path(__file__).resolve()
    scenes = (pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here.parents[2]) / "scenes"
    sys.dont_write_bytecode = True
    spec = importlib.util.spec_from_file_location("make_walk", scenes / "make_walk.py")
    make_walk = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make_walk)
    made = make_walk.walk().split()
    there = (scenes / "walk.bvh").read_text(encoding="ascii").split()
    if len(made) != len(there):
        print(f"walk.bvh has {len(there)} words, make_walk.py writes {len(made)}")
        return 1
    for k, (a, b) in enumerate(zip(made, there)):
        if a == b:
            continue
        try:
            same = abs(float(a) - float(b)) < 0.0015
        except ValueError:
            same = False
        if not same:
            print(f"word {k} of walk.bvh is {b}, make_walk.py writes {a}")
            return 1
    print(f"{len(made)} words alike")
    return 0


if __name__ == "__main__":
    sys.exit(main())
