#!/usr/bin/env python3
"""Holds docs/architecture.md and docs/adding.md to the code.

Every file and folder that they name exists; every folder of model/ and identify/ stands in the table of rooms; no
#include runs against the arrows model <- identify <- tools; no source names a document that is no
part of the project; and none reads a number by the locale, which in Python is that of another. Prints what it counted; exit code 1 where something does not hold.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
DOCS = ("docs/architecture.md", "docs/adding.md")
LAYERS = ("model", "identify", "tools")  # each may include itself and those before it
MODEL = ("core", "statistics", "battery", "vehicle", "control", "flight", "analysis", "export")  # the same within model/
SOURCES = (".cc", ".h", ".py", ".md", ".txt", ".cmake")
# Documents of others that a source may have been written from, but that a reader does not have.
FOREIGN = re.compile(r"\b(?:design|errata|targets|STYLE)\.md\b")

# A decimal comma of the process' locale makes 0 of "0.5".
BY_LOCALE = re.compile(r"\b(?:strtod|strtof|stod|stof|atof|setlocale)\b")


def named_paths(text):
    """Paths in backticks: not commands, not names with a placeholder."""
    for word in re.findall(r"`([^`\s]+)`", text):
        if word.startswith(LAYERS) and "/" in word and "NAME" not in word and "{" not in word:
            yield word.rstrip(":,.")


def problems_of_docs():
    rooms = (ROOT / DOCS[0]).read_text(encoding="utf-8")
    count = 0
    problems = []
    for doc in DOCS:
        for path in named_paths((ROOT / doc).read_text(encoding="utf-8")):
            count += 1
            if not (ROOT / path).exists():
                problems.append(f"{doc}: names {path}, which is not there")
    for layer in LAYERS[:2]:
        for folder in sorted((ROOT / layer).iterdir()):
            if folder.is_dir() and f"`{layer}/{folder.name}`" not in rooms:
                problems.append(f"{DOCS[0]}: {layer}/{folder.name} has no row")
    return count, problems


def problems_of_includes():
    count = 0
    problems = []
    for rank, layer in enumerate(LAYERS):
        for file in sorted((ROOT / layer).rglob("*")):
            if file.suffix not in (".cc", ".h"):
                continue
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                include = re.match(r'#include "(\w+)/', line)
                if not include:
                    continue
                count += 1
                room = re.match(r'#include "model/(\w+)/', line)
                own = file.relative_to(ROOT).parts[1]
                upward = (layer == "model" and room is not None
                          and MODEL.index(room[1]) > MODEL.index(own))
                if include[1] in LAYERS[rank + 1:] or upward:
                    problems.append(f"{file.relative_to(ROOT)}:{number}: {line}: against the arrows")
    return count, problems


def problems_of_citations():
    count = 0
    problems = []
    for layer in (*LAYERS, "python", "tests", "docs"):
        for file in sorted((ROOT / layer).rglob("*")):
            if file.suffix not in SOURCES or file == pathlib.Path(__file__).resolve():
                continue
            count += 1
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                if FOREIGN.search(line):
                    problems.append(f"{file.relative_to(ROOT)}:{number}: cites a document that is no part "
                                    f"of the project: {line.strip()}")
                if file.suffix in (".cc", ".h") and layer in (*LAYERS, "python") and BY_LOCALE.search(line):
                    problems.append(f"{file.relative_to(ROOT)}:{number}: reads a number by the locale "
                                    f"(std::from_chars does not): {line.strip()}")
    return count, problems


def main():
    paths, bad_docs = problems_of_docs()
    includes, bad_includes = problems_of_includes()
    files, bad_citations = problems_of_citations()
    problems = bad_docs + bad_includes + bad_citations
    for problem in problems:
        print(problem)
    print(f"{paths} paths in {' and '.join(DOCS)}, {includes} includes and {files} files looked at; "
          f"{len(problems)} do not hold")
    return 1 if problems or not (paths and includes and files) else 0


if __name__ == "__main__":
    sys.exit(main())
