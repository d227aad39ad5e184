#!/usr/bin/env python3
"""docs/thesis-results.md and its drawings are what `tools/reproduce --report` makes of its JSON.

    tools/check_thesis_results.py [ROOT]
    tools/check_thesis_results.py --lipoid PROGRAM --scratch DIR

With a program the results are flown anew, all but the designs and the 32 Ah cells, which take
minutes, and held against the JSON (tools/thesis/compare.py says how closely, and why).
"""

import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
# pylint: disable=wrong-import-position
from thesis import compare, hover, results
from thesis.lipoid import Lipoid
from thesis.report import files_of

SHOWN = 20


def stale(file):
    """What does not come from the JSON, as sentences."""
    for path, text in files_of(file).items():
        if not path.is_file():
            yield f"{path.name}: missing"
        elif path.read_text(encoding="utf-8") != text:
            yield f"{path.name}: differs from what {file.name} makes"


def flown_otherwise(file, lipoid):
    """Where the program does not fly as the JSON says."""
    old = json.loads(file.read_text(encoding="utf-8"))["stages"]
    for name, stage in results.STAGES.items():
        if name in results.SLOW:
            continue
        wanted = old[name]
        if name == "hover":
            wanted["rows"] = [row for row in wanted["rows"] if row["cell"] in hover.SMALL_CELLS]
            new = hover.measure(lipoid, hover.SMALL_CELLS)
        else:
            new = stage(lipoid)
        # Through JSON: tuples are lists there.
        yield from compare.differences(json.loads(json.dumps(new)), wanted, (name,))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("root", nargs="?", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parents[1])
    parser.add_argument("--lipoid", type=pathlib.Path)
    parser.add_argument("--scratch", type=pathlib.Path)
    options = parser.parse_args()
    file = options.root / "docs" / "thesis-results.json"
    if options.lipoid:
        problems = list(flown_otherwise(file, Lipoid(options.lipoid, options.scratch)))
        remedy = "run tools/reproduce if the change is meant"
    else:
        problems = list(stale(file))
        remedy = "run tools/reproduce --report docs/thesis-results.json"
    for problem in problems[:SHOWN]:
        print(problem, file=sys.stderr)
    if problems:
        print(f"{len(problems)} differences; {remedy}", file=sys.stderr)
        return 1
    print("as docs/thesis-results.json says")
    return 0


if __name__ == "__main__":
    sys.exit(main())
