#!/usr/bin/env python3
"""What the package costs over C++, and what it does beside PyBaMM: prints a table.

usage: PYTHONPATH=build/dev/python tests/bench/python_bench.py [--currents 1000] [--rows 10000] [--pybamm]

The command reads its logs from the page cache; what reading takes is measured by itself. Processor
time is compared for identify, so that other programs on the machine count less.
"""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import lipoid
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]


def processor_s() -> float:
    """Return the time of all cores that this process and those it ran have had, in s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def best(runs: int, work: Callable[[], object], clock: Callable[[], float]) -> float:
    """Return the least of so many times, in s."""
    times = []
    for _ in range(runs):
        began = clock()
        work()
        times.append(clock() - began)
    return min(times)


def identify_overhead(program: pathlib.Path, runs: int) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        lipoid.synthesize(
            "gifi-600mAh-1", folder / "lab", seed=1, sampling_s=0.1, voltage_noise_V=1e-3
        )
        campaign = lipoid.Campaign.read(folder / "lab/campaign.toml")
        logs = {
            kind: campaign.logs(kind.replace("_", "-"))
            for kind in ("constant_current", "low_rate", "pulses")
        }
        rows = sum(len(log) for some in logs.values() for log in some)

        def command() -> None:
            subprocess.run(
                [
                    program,
                    "identify",
                    folder / "lab/campaign.toml",
                    "-o",
                    folder / "cell.json",
                    "--quiet",
                    "--summary",
                    folder / "summary.json",
                ],
                check=True,
                capture_output=True,
            )

        def reading() -> None:
            lipoid.Campaign.read(folder / "lab/campaign.toml").logs()

        def arrays() -> None:
            made = {
                kind: [
                    lipoid.Log(time_s=x.time_s, current_A=x.current_A, voltage_V=x.voltage_V)
                    for x in some
                ]
                for kind, some in logs.items()
            }
            lipoid.identify(lipoid.Campaign(capacity_Ah=0.6, cutoff_V=3.0, **made))

        theirs, read, ours = (best(runs, work, processor_s) for work in (command, reading, arrays))
        print(
            f"identify, {rows} rows: command {theirs:.3f} s of processor time, of which reading {read:.3f} s; "
            f"Python on arrays {ours:.3f} s, {100 * (ours / (theirs - read) - 1):+.1f} %"
        )


def simulate_many(currents: int, rows: int, runs: int, with_pybamm: bool) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    t = np.arange(0.0, float(rows))
    one = np.where(t % 600 < 60, 1.2, 0.05)
    many = np.linspace(0.5, 1.0, currents)[:, None] * one
    took = best(runs, lambda: cell.simulate(t, many), time.perf_counter)
    single = (
        best(runs, lambda: [cell.simulate(t, many[k]) for k in range(10)], time.perf_counter) / 10.0
    )
    print(
        f"simulate {currents} x {rows} rows: {took:.3f} s, {currents * rows / took / 1e6:.1f} million rows/s "
        f"on {os.cpu_count()} cores; one by one {rows / single / 1e6:.1f} million rows/s"
    )
    if with_pybamm:
        made = cell.to_pybamm()
        made.run(t, one)
        theirs = best(1, lambda: made.run(t, one), time.perf_counter)
        print(
            f"PyBaMM's Thevenin with diffusion on one such current: {theirs:.3f} s, "
            f"{theirs / single:.0f} times as long; {rows / theirs / 1e6:.4f} million rows/s"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--currents", type=int, default=1000)
    parser.add_argument("--rows", type=int, default=10_000)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--pybamm", action="store_true")
    arguments = parser.parse_args()
    program = pathlib.Path(os.environ.get("LIPOID_PROGRAM", ROOT / "build/dev/tools/lipoid"))
    print(json.dumps({"lipoid": lipoid.__version__, "python": sys.version.split()[0]}))
    identify_overhead(program, arguments.runs)
    simulate_many(arguments.currents, arguments.rows, arguments.runs, arguments.pybamm)


if __name__ == "__main__":
    main()
