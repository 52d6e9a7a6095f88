"""Markdown tables of JSON results, and how they get into a document.

Columns are (heading, whether it is a number, how to get the text from a result).
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path


class BadInput(Exception):
    """One line for the user."""


def read_object(path):
    """The JSON object in a file."""
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from error
    if not isinstance(result, dict):
        raise BadInput(f"{path}: not a JSON object")
    return result


def row(columns, path, result):
    """The cells of one result; `path` is for the error."""
    cells = []
    for heading, _, text in columns:
        try:
            cells.append(text(result).replace("|", "\\|"))
        except (KeyError, TypeError, ValueError, AttributeError, IndexError,
                ZeroDivisionError) as error:
            raise BadInput(f"{path}: no figure for '{heading}': {error!r}") from error
    return cells


def markdown(columns, rows):
    """The table as text."""
    for cells in rows:
        if len(cells) != len(columns):
            raise ValueError(f"{len(cells)} cells for {len(columns)} columns: {cells}")
    lines = [[heading for heading, _, _ in columns],
             ["---:" if is_number else "---" for _, is_number, _ in columns], *rows]
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def replace_file(path, text):
    """Writes a file as a whole or not at all; it keeps its mode if it is there already."""
    path = path.resolve()
    try:
        mode = path.stat().st_mode & 0o777 if path.exists() else 0o644
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(temporary, mode)
        os.replace(temporary, path)
    except OSError as error:
        raise BadInput(f"{path}: {error}") from error


def write_between(path, text, begin, end):
    """Replaces the text between the two marked lines, and the file as a whole or not at all."""
    try:
        old = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from error
    lines = old.splitlines(keepends=True)
    marks = [[i for i, line in enumerate(lines) if line.strip() == mark] for mark in (begin, end)]
    if [len(found) for found in marks] != [1, 1] or marks[0][0] >= marks[1][0]:
        raise BadInput(f"{path}: needs one line {begin} and after it one line {end}")
    new = "".join(lines[: marks[0][0] + 1]) + "\n" + text + "\n" + "".join(lines[marks[1][0]:])
    if new == old:
        return
    replace_file(path, new)


def main(program, about, source, table, begin, end, links=False):
    """The command line of a program that prints a table, or writes it between two lines.

    source: what its arguments are; table: takes their paths and returns the text; links: whether it
    also takes the folder that the text is for, because the text has links
    """
    parser = argparse.ArgumentParser(prog=program, description=about.splitlines()[0])
    parser.add_argument("sources", nargs="+", type=Path, metavar="SOURCE", help=source)
    parser.add_argument("--write", type=Path, metavar="FILE",
                        help=f"replace the text between {begin} and {end} there")
    arguments = parser.parse_args()
    try:
        folder = arguments.write.parent if arguments.write else Path()
        text = table(arguments.sources, folder) if links else table(arguments.sources)
        if arguments.write:
            write_between(arguments.write, text, begin, end)
        else:
            sys.stdout.write(text)
    except BadInput as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2
    return 0
