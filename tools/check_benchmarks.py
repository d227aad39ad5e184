#!/usr/bin/env python3
"""docs/benchmarks.md and its drawing are what `tools/bench --report` makes of docs/benchmarks.json.

    tools/check_benchmarks.py [ROOT]

Nothing in them was typed by hand, then; README.md has the figure of the whole staged run.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
# pylint: disable=wrong-import-position
from benchmarks.report import write


def differences(file):
    """What stands in the report's files and does not come from the JSON, as sentences."""
    figure_file = file.with_name(f"{file.stem}_growth.svg")
    markdown, svg = write(json.loads(file.read_text(encoding="utf-8")), figure_file.name)
    wanted = {file.with_suffix(".md"): markdown}
    if svg is not None:
        wanted[figure_file] = svg
    for path, text in wanted.items():
        if not path.is_file():
            yield f"{path.name}: missing"
        elif path.read_text(encoding="utf-8") != text:
            yield f"{path.name}: differs from what {file.name} makes"


def of_readme(file, readme):
    """The same of the figure by which README.md compares the whole staged run."""
    goals = json.loads(file.read_text(encoding="utf-8"))["goals"]
    sentence = f"{goals[0]['found'].split(';')[0]} as fast as a SciPy script"
    if sentence not in readme.read_text(encoding="utf-8"):
        yield f"{readme.name}: expected '{sentence}'"


def main():
    here = pathlib.Path(__file__).resolve().parents[1]
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here
    numbers = root / "docs" / "benchmarks.json"
    remedy = "run tools/bench --report docs/benchmarks.json"
    problems = [f"{each}; {remedy}" for each in differences(numbers)]
    problems += of_readme(numbers, root / "README.md")
    for problem in problems:
        print(problem, file=sys.stderr)
    if not problems:
        print("docs/benchmarks.md is made from docs/benchmarks.json")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
