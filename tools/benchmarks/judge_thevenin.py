"""Sums of squares of several parameter sets on one log, by numpy.

usage: judge_thevenin.py PROBLEM.json     prints {name: {convention: V²}}

PROBLEM: {"log", "capacity_Ah", "initial_soc", "curve", "parameters": {name: {...}}}. Of repeated
stamps the first row counts, as in lipoid and in PyBOP's example.
"""

import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
# pylint: disable=wrong-import-position
from benchmarks.thevenin import CONVENTIONS, sum_of_squares


def judge(problem):
    table = np.loadtxt(problem["log"], delimiter=",", skiprows=1)
    _, first = np.unique(table[:, 0], return_index=True)
    log = table[first].T
    judged = {}
    for name, parameters in problem["parameters"].items():
        cell = {**problem, "parameters": parameters}
        judged[name] = {how: sum_of_squares(log, cell, how) for how in CONVENTIONS}
    return judged


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        print(json.dumps(judge(json.load(file))))
