#!/usr/bin/env python3
"""Puts a result of weft_bench_stability into the file that holds those of all cases and methods.

    stability_record.py RESULT FILE    RESULT: a file that --json wrote; FILE: an entry per case and
                                       method, made if it is missing

Entries of cases and methods that RESULT has not run stay. Exit code 2 if a file cannot be read or
lacks something.
"""

import argparse
import sys
from pathlib import Path

from markdown_table import BadInput
from stability_table import read_cells
from suite_file import write_cases


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("result", type=Path)
    parser.add_argument("file", type=Path)
    arguments = parser.parse_args()
    try:
        known = read_cells(arguments.file) if arguments.file.exists() else {}
        write_cases(arguments.file, {**known, **read_cells(arguments.result)})
    except BadInput as error:
        print(f"stability_record.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
