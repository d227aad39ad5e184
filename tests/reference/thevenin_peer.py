#!/usr/bin/env python3
"""Runs the package thevenin itself on exported YAML files and compares it with the cell.

    thevenin_peer.py CASES.json

CASES.json is a list of {"file": YAML, "cell": CELL.json, "mission": CSV, "series": n, "parallel": n},
paths relative to it. Prints a list of {"rmse_V", "max_error_V"} of the pack. Needs thevenin and
numpy, with scipy, which reference_cell.py needs.
"""

import json
import math
import pathlib
import sys

import numpy as np
import thevenin

import reference_cell


def simulate(path, times, currents):
    """The cell's voltage at every row; every stretch of constant current is one step."""
    model = thevenin.Simulation(str(path))
    experiment = thevenin.Experiment(rtol=1e-8, atol=1e-9)
    edges = [0] + [k for k in range(1, len(times) - 1) if currents[k + 1] != currents[k]]
    edges.append(len(times) - 1)
    for begin, end in zip(edges[:-1], edges[1:]):
        experiment.add_step("current_A", float(currents[begin + 1]),
                            times[begin:end + 1] - times[begin])
    solution = model.run(experiment)
    volts = np.empty(len(times))
    steps = [solution.get_steps(k) for k in range(len(edges) - 1)]
    volts[0] = steps[0].vars["voltage_V"][0]
    for begin, end, step in zip(edges[:-1], edges[1:], steps):
        assert len(step.vars["voltage_V"]) == end - begin + 1, step.message
        volts[begin + 1:end + 1] = step.vars["voltage_V"][1:]
    return volts


def judge(case, folder):
    cell = json.loads((folder / case["cell"]).read_text())
    cell["series"], cell["parallel"] = 1, 1
    data = np.genfromtxt(folder / case["mission"], delimiter=",", names=True)
    times, currents = data["time_s"], data["current_A"] / case["parallel"]
    truth = reference_cell.predict(cell, times, currents)["voltage_V"]
    error = case["series"] * (simulate(folder / case["file"], times, currents) - truth)
    return {"rmse_V": math.sqrt(np.mean(error ** 2)), "max_error_V": np.abs(error).max()}


def main(arguments):
    path = pathlib.Path(arguments[0])
    cases = json.loads(path.read_text())
    print(json.dumps([judge(case, path.parent) for case in cases]))


if __name__ == "__main__":
    main(sys.argv[1:])
