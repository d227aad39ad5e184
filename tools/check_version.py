#!/usr/bin/env python3
"""The version in CMakeLists.txt is that of CITATION.cff and the newest of CHANGELOG.md.

    tools/check_version.py [ROOT]
"""

import pathlib
import re
import sys

PLACES = {
    "CMakeLists.txt": r"^project\(lipoid VERSION (\S+)",
    "CITATION.cff": r"^version: (\S+)",
    "CHANGELOG.md": r"^## (\d+\.\d+\.\d+)",
}


def version_in(root, name, pattern):
    match = re.search(pattern, (root / name).read_text(encoding="utf-8"), re.MULTILINE)
    return match.group(1) if match else None


def main():
    here = pathlib.Path(__file__).resolve().parents[1]
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here
    found = {name: version_in(root, name, pattern) for name, pattern in PLACES.items()}
    wanted = found["CMakeLists.txt"]
    problems = [f"{name} says version {version}, CMakeLists.txt says {wanted}"
                for name, version in found.items() if version is None or version != wanted]
    for problem in problems:
        print(problem, file=sys.stderr)
    if not problems:
        print(f"version {wanted} everywhere")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
