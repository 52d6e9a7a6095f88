#!/usr/bin/env python3
"""Chooses which slow tests run today: about a fourteenth, another one every day of two weeks.

Reads the output of `ctest -N -L slow --show-only=json-v1` on standard input and prints a regular
expression, for `ctest -E`, that matches exactly the slow tests that do not run today; nothing if
all of them run.

    slow_share.py [--day N]     N: day of the year; today if not given
"""

import argparse
import json
import re
import sys
import time
import zlib

SHARES = 14


def resting(names, day):
    """Names of the tests that do not run on `day`. CRC-32 because it is the same everywhere."""
    return [name for name in names if zlib.crc32(name.encode()) % SHARES != day % SHARES]


def cmake_escape(name):
    """`name` as a regular expression of CMake that matches it literally."""
    return re.sub(r"([][.*+?^$|()\\])", r"\\\1", name)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--day", type=int, default=time.localtime().tm_yday)
    day = parser.parse_args().day
    names = [test["name"] for test in json.load(sys.stdin)["tests"]]
    rest = resting(names, day)
    if names:
        print(f"slow tests: {len(names) - len(rest)} of {len(names)} run today", file=sys.stderr)
    if rest:
        print("^(" + "|".join(cmake_escape(name) for name in rest) + ")$")


if __name__ == "__main__":
    main()
