#!/usr/bin/env python3
"""Records which slow tests have run, when, on what commit, and how they ended.

    ctest -L '^slow$' --output-junit RESULTS.xml ...
    slow_record.py RESULTS.xml RECORD.json --commit COMMIT
    slow_record.py --list RECORD.json < names      prints names, one a line, without a record

What an earlier record says of tests that did not run this time stays.
"""

import argparse
import json
import os
import sys
import time
import xml.etree.ElementTree as ElementTree


def cpu_model():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return "unknown"


def outcome_of(case):
    """passed, failed or skipped, and why if skipped."""
    skipped = case.find("skipped")
    if skipped is not None:
        return "skipped"
    return "passed" if case.get("status") == "run" and case.find("failure") is None else "failed"


def read_junit(path, commit):
    """Records by test name."""
    started = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    machine = f"{cpu_model()}, {os.cpu_count()} threads"
    return {
        case.get("name"): {
            "outcome": outcome_of(case),
            "seconds": round(float(case.get("time", 0)), 1),
            "commit": commit,
            "machine": machine,
            "recorded": started,
        }
        for case in ElementTree.parse(path).getroot().iter("testcase")
    }


def merged(old, new):
    """A run replaces what was known; that a test was skipped does not replace that it has run."""
    result = dict(old)
    for name, record in new.items():
        if record["outcome"] != "skipped" or name not in old:
            result[name] = record
    return dict(sorted(result.items()))


def load(path):
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        return json.load(file)["tests"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("--commit", default="unknown")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    if arguments.list:
        known = load(arguments.files[0])
        lacking = [name for name in sys.stdin.read().split("\n") if name and name not in known]
        print("\n".join(lacking))
        return 1 if lacking else 0
    junit, record = arguments.files
    tests = merged(load(record), read_junit(junit, arguments.commit))
    counts = {}
    for test in tests.values():
        counts[test["outcome"]] = counts.get(test["outcome"], 0) + 1
    with open(record, "w", encoding="utf-8") as file:
        json.dump({"command": "./dev slow", "counts": counts, "tests": tests}, file, indent=1)
        file.write("\n")
    print(f"{record}: {counts}")
    return 1 if counts.get("failed") else 0


if __name__ == "__main__":
    sys.exit(main())
