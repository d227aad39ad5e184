"""Logs of 10^8 rows: processor time and peak memory of every command that reads one."""

import shutil

from . import campaign
from .process import run, say

CELL = "cell.json"


def commands(lipoid, folder):
    """What is measured: by name, the command."""
    log = folder / "low_rate.csv"
    toml = folder / "campaign.toml"
    return {
        "inspect": [lipoid, "inspect", log],
        "identify, staged": [lipoid, "identify", toml, "--method", "staged", "-o", folder / CELL],
        "identify, joint": [lipoid, "identify", toml, "-o", folder / "joint.json"],
        "validate": [lipoid, "validate", folder / CELL, log],
        "convert": [lipoid, "convert", log, "-o", folder / "written.csv"],
        "simulate": [lipoid, "simulate", folder / CELL, "--current", log, "-o", folder / "written.csv"],
    }


def measure(lipoid, folder, rows):
    """The folder, which is made and removed, takes 80 bytes for each row."""
    hours = rows * 0.01 / 3600.0 * 1.002  # a little before its end the cell is empty
    parameters = ",".join(f"{name}={value}" for name, value in campaign.BRANCH.items())
    make = [lipoid, "synthesize", "grepow-32Ah-1", "--with", parameters, "--rates-C", "1,2,3,4,5,6,7,8",
            "--low-rate-h", f"{hours:.1f}", "--voltage-noise-V", campaign.NOISE_V,
            "--voltage-resolution-V", "0.00001", "--seed", "1", "-o", folder]
    shutil.rmtree(folder, ignore_errors=True)
    try:
        say("making a long log")
        made = run(make)
        file = folder / "low_rate.csv"
        with open(file, "rb") as stream:
            count = sum(piece.count(b"\n") for piece in iter(lambda: stream.read(1 << 20), b"")) - 1
        measured = []
        for name, command in commands(lipoid, folder).items():
            say(f"long log: {name}")
            # 1: the cell is empty before the log ends, or does not fit it well.
            ended = run([*command, "--quiet"], expect_success=False)
            if ended.exit_code not in (0, 1):
                raise SystemExit(f"{ended.command} ended with {ended.exit_code}:\n{ended.err[-2000:]}")
            measured.append({"name": name, "command": ended.command, **ended.figures()})
            (folder / "written.csv").unlink(missing_ok=True)
        return {"command": made.command, "rows": count, "bytes": file.stat().st_size, "runs": measured}
    finally:
        shutil.rmtree(folder, ignore_errors=True)
