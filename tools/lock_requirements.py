#!/usr/bin/env python3
"""Locks python/requirements-*.in into .txt files with hashes, for the interpreter that runs this.

usage: tools/lock_requirements.py [--upgrade]     needs pip 22.2 or later; asks the package index

Packages that are locked keep their versions, unless --upgrade asks for the newest.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "python"


def lock(source, pinned):
    """Packages that `pinned` lists keep the versions there; returns it with those of this file."""
    with tempfile.TemporaryDirectory() as scratch:
        report = pathlib.Path(scratch) / "report.json"
        constraints = pathlib.Path(scratch) / "constraints.txt"
        constraints.write_text("\n".join(pinned) + "\n")
        command = [sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--quiet",
                   "--report", report, "--constraint", constraints, "--requirement", source]
        subprocess.run(command, check=True)
        found = json.loads(report.read_text())["install"]
    lines = [f"# Locked from {source.name} (see there) by tools/lock_requirements.py."]
    for one in sorted(found, key=lambda one: one["metadata"]["name"].lower()):
        digest = one["download_info"]["archive_info"]["hashes"]["sha256"]
        name, version = one["metadata"]["name"].lower(), one["metadata"]["version"]
        lines += [f"{name}=={version} \\", f"    --hash=sha256:{digest}"]
    source.with_suffix(".txt").write_text("\n".join(lines) + "\n")
    pinned = pinned + [line.split(" ")[0] for line in lines if "==" in line]
    print(f"{source.with_suffix('.txt').name}: {len(found)} packages")
    return pinned


def locked():
    """The versions that both files hold now."""
    files = [FOLDER / "requirements-test.txt", FOLDER / "requirements-extra.txt"]
    return [line.split(" ")[0] for file in files for line in file.read_text().splitlines() if "==" in line]


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--upgrade"]):
        sys.exit("usage: tools/lock_requirements.py [--upgrade]")
    versions = lock(FOLDER / "requirements-test.in", [] if sys.argv[1:] else locked())
    lock(FOLDER / "requirements-extra.in", versions)
