#!/usr/bin/env python3
"""Keeps the documents in step with the tree and with the committed results.

- Relative links, and paths in backticks, name something that exists.
- Tables that a script writes are what it writes from the committed results.
- README names the outcome of validation and robustness, with the numbers of the results.
- Fewer than 60 files lie under benchmarks/results.
- README and ARCHITECTURE are short, and no folder of sources is crowded.
- ARCHITECTURE has the table of allowed includes that is enforced.

usage: check_documents.py [REPOSITORY]
       check_documents.py --self-test
"""

import pathlib
import re
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks/support"))

import benchmark_table  # noqa: E402
import check_includes  # noqa: E402
import chart_table  # noqa: E402
import library_figures  # noqa: E402
import physics_table  # noqa: E402
import report_table  # noqa: E402
import stability_table  # noqa: E402
import time_step_table  # noqa: E402
from markdown_table import BadInput  # noqa: E402

DOCUMENTS = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "scenes/README.md",
             "benchmarks/README.md", "docs/**/*.md")
# A journal tells of files as they were; only its links have to hold.
JOURNALS = ("benchmarks/journal/*.md",)
MOST_RESULTS = 60
MOST_LINES = {"README.md": 180, "ARCHITECTURE.md": 300}
MOST_SOURCES = 25
SOURCE_FOLDERS = ("host", "cuda", "include")
RESULTS = "benchmarks/results"
PHYSICS = f"{RESULTS}/validation/physics.json"
STABILITY = f"{RESULTS}/validation/stability.json"
TIME_STEPS = (f"{RESULTS}/validation/time_steps_cpu.json", f"{RESULTS}/validation/time_steps_cuda.json")


def links(text):
    """Targets of relative links and pictures, without fragments."""
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not re.match(r"[a-z]+:|#", target):
            yield target.partition("#")[0]


def paths(text, folders):
    """Words in backticks that are paths: below one of the folders, or a document of the root."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    for code in re.findall(r"`([^`\n]+)`", text):
        for word in code.split():
            word = word.strip("'\",;:()")
            if re.search(r"[<>$=\[{]|NAME|SCENE", word):
                continue  # a pattern for the reader
            if word.partition("/")[0] in folders and "/" in word or re.fullmatch(r"[A-Z]+\.md", word):
                yield word


def exists(root, base, path):
    """Whether a path or a pattern with stars names something, from `base` or from the root."""
    return any(next(folder.glob(path.rstrip("/")), None) if "*" in path else (folder / path).exists()
               for folder in (base, root) if not path.startswith("/"))


def folders_of(folder):
    return {entry.name for entry in folder.iterdir()
            if entry.is_dir() and entry.name not in (".git", "build", "out")}


def broken_references(root, documents, journals):
    problems = []
    for pattern in (*documents, *journals):
        found = sorted(root.glob(pattern))
        if not found and "*" not in pattern:
            problems.append(f"{pattern}: is missing")
        for document in found:
            text = document.read_text(encoding="utf-8")
            name = document.relative_to(root)
            problems += [f"{name}: link to {target}, which does not exist" for target in links(text)
                         if not (document.parent / target).exists()]
            if pattern in journals:
                continue
            folders = folders_of(root) | folders_of(document.parent)
            problems += [f"{name}: names {path}, which does not exist"
                         for path in paths(text, folders) if not exists(root, document.parent, path)]
    return problems


def block(text, begin, end):
    """The text between two marked lines; None without them."""
    found = re.search(f"^{re.escape(begin)}\n\n(.*)\n^{re.escape(end)}$", text, re.M | re.S)
    return found.group(1) if found else None


def stale_tables(root):
    charts = sorted(path.parent for path in (root / RESULTS / "charts").glob("*/chart.json"))
    tables = (
        ("docs/validation.md", physics_table, lambda: physics_table.table([root / PHYSICS])),
        ("docs/robustness.md", stability_table, lambda: stability_table.table([root / STABILITY])),
        ("docs/accuracy.md", chart_table, lambda: chart_table.table(charts, root / "docs")),
        ("docs/accuracy.md", time_step_table,
         lambda: time_step_table.table([root / path for path in TIME_STEPS])),
        ("docs/library.md", library_figures,
         lambda: library_figures.table([root / RESULTS / "latest/2x-amd-epyc/library.json"])),
        ("benchmarks/README.md", benchmark_table,
         lambda: benchmark_table.table([root / RESULTS / "latest"])),
        ("benchmarks/README.md", report_table,
         lambda: report_table.table([root / RESULTS / "latest/2x-amd-epyc/run.json"])),
    )
    problems = []
    for name, writer, make in tables:
        text = (root / name).read_text(encoding="utf-8")
        try:
            if block(text, writer.BEGIN, writer.END) != make():
                problems.append(f"{name}: the text between {writer.BEGIN} and {writer.END} is not "
                                f"what {writer.__name__}.py writes from the committed results")
        except BadInput as error:
            problems.append(f"{name}: {error}")
    return problems


def wrong_outcomes(readme, target, expected):
    """Lines of README about a document: one has to say "N of M", and all that do have to be right."""
    lines = [line for line in readme.splitlines() if f"({target})" in line]
    said = [tuple(int(number.replace(",", "")) for number in numbers)
            for line in lines for numbers in re.findall(r"\b([\d,]+) of ([\d,]+)\b", line)]
    if not said:
        return [f"README.md: no line that links to {target} says \"{expected[0]} of {expected[1]}\""]
    return [f"README.md: says {n} of {m} beside {target}; the results say {expected[0]} of "
            f"{expected[1]}" for n, m in said if (n, m) != expected]


def outcome_problems(root):
    readme = (root / "README.md").read_text(encoding="utf-8")
    physics = [result for _, result in physics_table.read_results(root / PHYSICS)]
    runs = [run for cell in stability_table.read_cells(root / STABILITY).values()
            for run in cell["runs"]]
    counts = stability_table.outcome(runs)
    return (wrong_outcomes(readme, "docs/validation.md", physics_table.outcome(physics))
            + wrong_outcomes(readme, "docs/robustness.md",
                             (counts["passed"] + counts["refused"], len(runs))))


def too_many_results(root, most):
    count = sum(1 for path in (root / RESULTS).rglob("*") if path.is_file())
    return [] if count < most else [f"{RESULTS}: {count} files; fewer than {most} are allowed"]


def too_long(root, most):
    """Documents that a reader would not finish."""
    lengths = {path: len((root / path).read_text(encoding="utf-8").splitlines()) for path in most}
    return [f"{path}: {lengths[path]} lines; at most {most[path]}"
            for path in most if lengths[path] > most[path]]


def crowded_folders(root, most):
    """Folders of sources with too many files to take in."""
    counts = {}
    for top in SOURCE_FOLDERS:
        for path in (root / top).rglob("*.c*"):
            if path.suffix in (".cpp", ".cu"):
                counts[path.parent] = counts.get(path.parent, 0) + 1
    return [f"{folder.relative_to(root)}: {count} .cpp or .cu files; at most {most}"
            for folder, count in sorted(counts.items()) if count > most]


def other_table(root):
    """ARCHITECTURE shows the table of allowed includes that check_includes.py enforces."""
    if check_includes.table_markdown() in (root / "ARCHITECTURE.md").read_text(encoding="utf-8"):
        return []
    return ["ARCHITECTURE.md: its table of rooms is not that of check_includes.py --table"]


def self_test():
    """Each check finds what it is for."""
    with tempfile.TemporaryDirectory() as scratch:
        root = pathlib.Path(scratch)
        (root / "docs").mkdir()
        (root / RESULTS).mkdir(parents=True)
        (root / RESULTS / "a.json").write_text("{}")
        (root / "docs/good.md").write_text("[a](../README.md#part) ![b](https://x/y) `docs/*.md`\n"
                                           "`python3 docs/good.md NAME`, `docs/<name>`, `a/b`\n")
        (root / "README.md").write_text("[docs](docs) `README.md`\n")
        assert broken_references(root, ("README.md", "docs/*.md"), ()) == []
        (root / "docs/bad.md").write_text("[a](gone.md) `docs/gone.md` `run docs/none.json`\n"
                                          "`GONE.md` `docs/*.txt`\n```\n`docs/fenced`\n```\n")
        found = broken_references(root, ("README.md", "MISSING.md"), ("docs/bad.md",))
        assert found == ["MISSING.md: is missing",
                         "docs/bad.md: link to gone.md, which does not exist"], found
        found = broken_references(root, ("docs/bad.md",), ())
        assert len(found) == 5 and all("does not exist" in line for line in found), found
        assert too_many_results(root, 2) == [] and too_many_results(root, 1) != []
        (root / "ARCHITECTURE.md").write_text(check_includes.table_markdown() + "\n")
        lines = len(check_includes.table_markdown().splitlines())
        assert other_table(root) == []
        assert too_long(root, {"ARCHITECTURE.md": lines}) == []
        assert too_long(root, {"ARCHITECTURE.md": lines - 1}) != []
        (root / "ARCHITECTURE.md").write_text("another table\n")
        assert other_table(root) != []
        (root / "host/room").mkdir(parents=True)
        for name in ("a.cpp", "b.cpp"):
            (root / "host/room" / name).write_text("")
        assert crowded_folders(root, 2) == [] and crowded_folders(root, 1) != []
    assert wrong_outcomes("1,087 of 1,092 ([a](a.md))\n", "a.md", (1087, 1092)) == []
    assert wrong_outcomes("88 of 92 ([a](a.md))\n", "a.md", (87, 92)) != []
    assert wrong_outcomes("87 of 92\n[a](a.md)\n", "a.md", (87, 92)) != []
    assert block("x\n<!-- a -->\n\nrow\n\n<!-- /a -->\n", "<!-- a -->", "<!-- /a -->") == "row\n"
    assert block("x\n", "<!-- a -->", "<!-- /a -->") is None


def main():
    if "--self-test" in sys.argv[1:]:
        self_test()
        return 0
    root = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT
    try:
        problems = (broken_references(root, DOCUMENTS, JOURNALS) + stale_tables(root)
                    + outcome_problems(root) + too_many_results(root, MOST_RESULTS) + too_long(root, MOST_LINES)
                    + crowded_folders(root, MOST_SOURCES) + other_table(root))
    except (BadInput, OSError, ValueError, LookupError) as error:
        problems = [f"{type(error).__name__}: {error}"]
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
