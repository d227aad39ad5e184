#!/usr/bin/env python3
"""Keeps docs/equations.md in step with the sources.

    tools/check_equations.py [ROOT]

A row of the table is: number | in words | file: function | test. It fails, naming file and line,
where
  * a source of model/, identify/ or tools/ cites an equation, "(4.46)" or a range
    "(4.46)-(4.51)", that has no row,
  * a line of code ends in a citation, "...;  // (4.46)", and no row of it names the file,
  * a row names a file that does not cite the equation or does not hold the function,
  * a row names a test that does not exist: "tests/a_test.cc: Suite.Name" or "tests/a.py: function".
"""

import pathlib
import re
import sys

NUMBER = r"\(([3-6])\.([1-9]\d?)\)"
# Not a call such as T(3.5) or sqrt(4.2).
CITATION = re.compile(rf"(?<![\w>]){NUMBER}(?:-{NUMBER})?")


def citations(text):
    """The equation numbers cited in a line, ranges written out, as (chapter, number)."""
    for match in CITATION.finditer(text):
        chapter, first, last_chapter, last = match.groups()
        if last is not None and last_chapter != chapter:
            raise ValueError(f"range over chapters: {match.group(0)}")
        for number in range(int(first), int(last or first) + 1):
            yield int(chapter), number


def sources(root):
    for folder in ("model", "identify", "tools"):
        for pattern in ("*.h", "*.cc", "*.c"):
            yield from sorted((root / folder).rglob(pattern))


def read_rows(path):
    """(line, equations, file, function, test file, test name) of every row of the table."""
    rows = []
    problems = []
    for line, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        cells = [cell.strip().replace("`", "") for cell in text.strip().strip("|").split("|")]
        if not text.startswith("| ("):
            continue
        if len(cells) != 4 or ": " not in cells[2] or ": " not in cells[3]:
            problems.append(f"docs/equations.md:{line}: expected four cells, "
                            "number | in words | file: function | test file: test")
            continue
        file, function = cells[2].split(": ", 1)
        test_file, test = cells[3].split(": ", 1)
        rows.append((line, set(citations(cells[0])), file, function, test_file, test))
    return rows, problems


def has_test(path, name):
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return re.search(rf"^def {re.escape(name)}\(", text, re.M) is not None
    suite, _, test = name.partition(".")
    return re.search(rf"^(?:TYPED_)?TEST(?:_F|_P)?\({suite},\s*{test}\)", text, re.M) is not None


def check(root):
    table = root / "docs" / "equations.md"
    rows, problems = read_rows(table)
    files_of = {}
    for _, equations, file, *_ in rows:
        for equation in equations:
            files_of.setdefault(equation, set()).add(file)

    cited_in = {}
    for path in sources(root):
        name = path.relative_to(root).as_posix()
        for line, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            for equation in citations(text):
                cited_in.setdefault(equation, set()).add(name)
                label = f"({equation[0]}.{equation[1]})"
                if equation not in files_of:
                    problems.append(f"{name}:{line}: {label} has no row in docs/equations.md")
                    continue
                code, comment, _ = text.partition("//")
                computes = comment and code.strip() and "///" not in text
                if computes and name not in files_of[equation]:
                    problems.append(f"{name}:{line}: {label} is computed here, "
                                    "but no row of it in docs/equations.md names this file")

    for line, equations, file, function, test_file, test in rows:
        where = f"docs/equations.md:{line}"
        if not (root / file).is_file():
            problems.append(f"{where}: no file {file}")
            continue
        for chapter, number in sorted(equations):
            if file not in cited_in.get((chapter, number), set()):
                problems.append(f"{where}: {file} does not cite ({chapter}.{number})")
        source = (root / file).read_text(encoding="utf-8")
        if not re.search(rf"\b{re.escape(function.split('::')[-1])}\b", source):
            problems.append(f"{where}: {file} has no {function}")
        if not (root / test_file).is_file():
            problems.append(f"{where}: no file {test_file}")
        elif not has_test(root / test_file, test):
            problems.append(f"{where}: {test_file} has no test {test}")
    return rows, problems


def main():
    here = pathlib.Path(__file__).resolve().parents[1]
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here
    rows, problems = check(root)
    for problem in problems:
        print(problem, file=sys.stderr)
    if not rows:
        print("docs/equations.md: expected a table of equations, found none", file=sys.stderr)
    if problems or not rows:
        return 1
    print(f"{len(rows)} rows in step with their sources and tests")
    return 0


if __name__ == "__main__":
    sys.exit(main())
