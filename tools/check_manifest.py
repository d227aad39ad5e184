#!/usr/bin/env python3
"""Every file under fixtures/ is declared in fixtures/MANIFEST.json, with its hash and its origin.

    tools/check_manifest.py [ROOT]             fails on an undeclared, missing or changed file
    tools/check_manifest.py --update [ROOT]    writes the hashes of the files of every entry

The manifest is a list of entries, one per group of files made together:

    { "files": "logs/arbin/*.csv",     a pattern below fixtures/; ** matches folders too
      "origin": "...", "licence": "...", "units": "...", "made": "...",
      "sha256": { "logs/arbin/a.csv": "..." } }

A file belongs to exactly one entry. --update fills in "sha256" only: an entry is written by hand.
"""

import hashlib
import json
import pathlib
import sys

TEXTS = ("files", "origin", "licence", "units", "made")


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def check(fixtures, entries):
    problems = []
    owner = {}
    for k, entry in enumerate(entries):
        for key in TEXTS:
            if not isinstance(entry.get(key), str) or not entry[key].strip():
                problems.append(f"entry {k}: expected a text under '{key}'")
        for key in set(entry) - {*TEXTS, "sha256"}:
            problems.append(f"entry {k}: unknown key '{key}'")
        for name, wanted in entry.get("sha256", {}).items():
            if name in owner:
                problems.append(f"{name}: declared twice")
            owner[name] = k
            path = fixtures / name
            if not path.is_file():
                problems.append(f"{name}: declared, but missing")
            elif digest(path) != wanted:
                problems.append(f"{name}: changed since it was declared (hash {digest(path)})")
    for path in sorted(p for p in fixtures.rglob("*") if p.is_file()):
        name = path.relative_to(fixtures).as_posix()
        if name != "MANIFEST.json" and name not in owner:
            problems.append(f"{name}: not declared; add an entry, then run "
                            "tools/check_manifest.py --update")
    return problems


def update(fixtures, entries):
    for entry in entries:
        names = sorted(p.relative_to(fixtures).as_posix() for p in fixtures.glob(entry["files"])
                       if p.is_file() and p.name != "MANIFEST.json")
        entry["sha256"] = {name: digest(fixtures / name) for name in names}


def main():
    arguments = [a for a in sys.argv[1:] if a != "--update"]
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).resolve().parents[1])
    fixtures = root / "fixtures"
    manifest = fixtures / "MANIFEST.json"
    entries = json.loads(manifest.read_text(encoding="utf-8"))
    if "--update" in sys.argv[1:]:
        update(fixtures, entries)
        text = json.dumps(entries, indent=2, ensure_ascii=False) + "\n"
        manifest.write_text(text, encoding="utf-8")
    problems = check(fixtures, entries)
    for problem in problems:
        print(f"fixtures/MANIFEST.json: {problem}", file=sys.stderr)
    if problems:
        return 1
    print(f"{sum(len(e['sha256']) for e in entries)} fixtures as declared")
    return 0


if __name__ == "__main__":
    sys.exit(main())
