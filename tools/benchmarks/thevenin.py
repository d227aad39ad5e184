"""The two-branch Thevenin cell in numpy, exactly: what judges lipoid and PyBOP, and is neither.

Between two rows the current is a straight line ("linear", as PyBaMM interpolates), that of the row
that ends the interval ("backward", as cyclers log) or that of the row that begins it ("forward").
"""

import numpy as np

CONVENTIONS = ("linear", "backward", "forward")


def interval_currents(current_A, convention):
    """The current at both ends of every interval."""
    if convention == "linear":
        return current_A[:-1], current_A[1:]
    held = current_A[1:] if convention == "backward" else current_A[:-1]
    return held, held


def branch_voltage(time_s, current_A, resistance_Ohm, time_constant_s, convention):
    """v' = (r i - v)/tau with i along a line: the closed form of every interval."""
    begin, end = interval_currents(current_A, convention)
    dt = np.diff(time_s)
    decay = np.exp(-dt / time_constant_s)
    slope = (end - begin) / dt
    gain = resistance_Ohm * (begin * (1 - decay) + slope * (dt - time_constant_s * (1 - decay)))
    voltage = np.zeros(len(time_s))
    for k in range(len(dt)):
        voltage[k + 1] = decay[k] * voltage[k] + gain[k]
    return voltage


def voltage_of(log, cell, convention):
    """log: time_s, current_A; cell: capacity_Ah, initial_soc, curve, parameters."""
    time_s, current_A = log[0], log[1]
    begin, end = interval_currents(current_A, convention)
    charge_C = np.concatenate([[0.0], np.cumsum(0.5 * (begin + end) * np.diff(time_s))])
    soc = cell["initial_soc"] - charge_C / (3600.0 * cell["capacity_Ah"])
    p = cell["parameters"]
    voltage = np.interp(soc, cell["curve"]["soc"], cell["curve"]["voltage_V"])
    voltage -= p["r_s"] * current_A
    for j in ("1", "2"):
        voltage -= branch_voltage(time_s, current_A, p[f"r_{j}"], p[f"r_{j}"] * p[f"c_{j}"],
                                  convention)
    return voltage


def sum_of_squares(log, cell, convention):
    return float(np.sum((voltage_of(log, cell, convention) - log[2]) ** 2))
