#!/usr/bin/python3
"""The batteries of other programs in NumPy, written from their sources and documentation, as a
second statement of the laws in model/export. It shares no code with the C++ library.

Times in s, currents in A of the pack, discharge positive; currents[k] flowed since times[k-1], and
row 0 moves no charge. Every law starts full and at rest.

    export_laws.py CASES.json

CASES.json is a list of {"law": ..., "parameters": {...}, "cell": CELL.json, "mission": CSV}, paths
relative to it; parameters are named as the target names them. Prints a list of {"rmse_V",
"max_error_V", "worst_s"} against the cell of reference_cell.py, and for laws of a charge alone
{"rms_level", "max_level"}.
"""

import json
import math
import pathlib
import sys

import numpy as np
from scipy.signal import lfilter

import reference_cell

# Volts of a cell at per cent of its capacity: SIM_Battery.cpp of ArduPilot.
ARDUPILOT_TABLE = np.array([
    (4.173, 100), (4.112, 96.15), (4.085, 92.31), (4.071, 88.46), (4.039, 84.62), (3.987, 80.77),
    (3.943, 76.92), (3.908, 73.08), (3.887, 69.23), (3.854, 65.38), (3.833, 61.54), (3.801, 57.69),
    (3.783, 53.85), (3.742, 50), (3.715, 46.15), (3.679, 42.31), (3.636, 38.46), (3.588, 34.62),
    (3.543, 30.77), (3.503, 26.92), (3.462, 23.08), (3.379, 19.23), (3.296, 15.38), (3.218, 11.54),
    (3.165, 7.69), (3.091, 3.85), (2.977, 2.0), (2.8, 1.5), (2.7, 1.3), (2.5, 1.2), (2.3, 1.1),
    (2.1, 1.0), (1.9, 0.9), (1.6, 0.8), (1.3, 0.7), (1.0, 0.6), (0.6, 0.4), (0.3, 0.2),
    (0.01, 0.01), (0.001, 0.001)])[::-1]


def charge(times, currents):
    """C that left at every row."""
    return np.concatenate([[0.0], np.cumsum(np.diff(times) * currents[1:])])


def substeps(times, currents, rate_per_s):
    """The mission at a program's own steps, and which of them are rows."""
    counts = np.maximum(1, np.rint(np.diff(times) * rate_per_s)).astype(int)
    dt = np.repeat(np.diff(times) / counts, counts)
    return dt, np.repeat(currents[1:], counts), np.cumsum(counts) - 1


def ardupilot(p, times, currents):
    """Every number is a float there. The charge is summed in float, step by step, as SITL does at
    1200 Hz; the low-pass is linear and loses nothing in float."""
    full, capacity, ohm = (np.float32(p[k]) for k in ("maxVoltage", "battCapacityAh", "refBatRes"))
    dt, current, row = substeps(times, currents, 1200.0)
    steps = (current.astype(np.float32) * dt.astype(np.float32) / np.float32(3600)).astype(np.float32)
    left = np.maximum(0.0, np.cumsum(np.concatenate([[capacity], -steps]), dtype=np.float32)[1:])
    percent = 100.0 * left.astype(float) / float(capacity)
    rest = np.interp(percent, ARDUPILOT_TABLE[:, 1], ARDUPILOT_TABLE[:, 0]) / 4.173 * float(full)
    target = rest - float(ohm) * current
    volts = np.empty(len(times))
    volts[0] = full
    share = dt / (dt + 1.0 / (2.0 * math.pi * 10.0))
    filtered = np.empty(len(dt))
    start = 0
    value = float(full)
    ends = np.append(np.flatnonzero(np.abs(np.diff(share)) > 1e-12) + 1, len(dt))
    for end in ends:
        a = share[start]
        if end - start < 8:
            for k in range(start, end):
                value += a * (target[k] - value)
                filtered[k] = value
        else:
            filtered[start:end], _ = lfilter([a], [1.0, a - 1.0], target[start:end],
                                             zi=[(1.0 - a) * value])
            value = filtered[end - 1]
        start = end
    volts[1:] = filtered[row]
    return volts


def px4(p, times, currents):
    """What the numbers mean as a law; volts of the pack."""
    q_Ah = charge(times, currents) / 3600.0
    left = 1.0 - q_Ah / (p["BAT1_CAPACITY"] / 1000.0)
    cell = p["BAT1_V_EMPTY"] + left * (p["BAT1_V_CHARGED"] - p["BAT1_V_EMPTY"]) \
        - p["BAT1_R_INTERNAL"] * currents
    return p["BAT1_N_CELLS"] * cell


def px4_state_of_charge(p, times, currents, volts):
    """What PX4's estimator shows, fed with the pack's volts 100 times a second. The charge is summed
    in float as there; the rest is double here."""
    dt, current, row = substeps(times, currents, 100.0)
    first_V = volts[0]
    volts = np.repeat(volts[1:], np.diff(np.concatenate([[-1], row])))
    span = p["BAT1_V_CHARGED"] - p["BAT1_V_EMPTY"]
    corrected = volts / p["BAT1_N_CELLS"] + p["BAT1_R_INTERNAL"] * np.maximum(current, 0.0)
    taken = (current.astype(np.float32) * np.float32(1e3)
             * (dt.astype(np.float32) / np.float32(3600.0))).astype(np.float32)
    counted = 1.0 - np.cumsum(taken, dtype=np.float32).astype(float) / p["BAT1_CAPACITY"]
    counted = np.maximum(counted, 0.0)
    taken = taken.astype(float) / p["BAT1_CAPACITY"]
    share = dt / (dt + 1.0)
    low_pass = first_V / p["BAT1_N_CELLS"] + p["BAT1_R_INTERNAL"] * max(currents[0], 0.0)
    soc = min(max((low_pass - p["BAT1_V_EMPTY"]) / span, 0.0), 1.0)
    shown = np.empty(len(dt))
    start = soc
    for k in range(len(dt)):
        low_pass += share[k] * (corrected[k] - low_pass)
        by_voltage = min(max((low_pass - p["BAT1_V_EMPTY"]) / span, 0.0), 1.0)
        weight = 0.03 * (1.0 - by_voltage)
        soc = max((1.0 - weight) * soc + weight * by_voltage - taken[k], 0.0)
        soc = min(counted[k], soc)
        shown[k] = soc
    return np.concatenate([[start], shown[row]])


def gazebo(p, times, currents):
    """LinearBatteryPlugin at a physics step of 1 ms, with the current imposed."""
    dt, current, row = substeps(times, currents, 1000.0)
    tau = np.maximum(p["smooth_current_tau"], dt)
    smooth = np.empty(len(dt))
    value, start = 0.0, 0
    for end in np.append(np.flatnonzero(np.abs(np.diff(dt)) > 1e-12) + 1, len(dt)):
        a = (dt / tau)[start]
        smooth[start:end], _ = lfilter([a], [1.0, a - 1.0], current[start:end],
                                       zi=[(1.0 - a) * value])
        value = smooth[end - 1]
        start = end
    left = p["initial_charge"] - np.cumsum(dt * smooth) / 3600.0
    volts = p["open_circuit_voltage_constant_coef"] \
        + p["open_circuit_voltage_linear_coef"] * (1.0 - left / p["capacity"]) \
        - p["resistance"] * smooth
    return np.concatenate([[p["open_circuit_voltage_constant_coef"]], volts[row]])


def rakhmatov(p, times, currents):
    """RvBatteryModel of ns-3: the level by (7) of Rakhmatov and Vrudhula over the whole history, in
    mA and minutes. The sample at t takes the current then for the interval before it."""
    alpha, beta = p["RvBatteryModelAlphaValue"], p["RvBatteryModelBetaValue"]
    terms = int(p["RvBatteryModelNumOfTerms"])
    minutes, load = times / 60.0, 1000.0 * currents
    # Constant stretches are one interval.
    level = np.empty(len(times))
    edges = [0] + [k for k in range(1, len(times) - 1) if load[k + 1] != load[k]] + [len(times) - 1]
    m = np.arange(1, terms + 1)
    rate = beta ** 2 * m ** 2
    for k in range(len(times)):
        sigma = 0.0
        for a, b in zip(edges[:-1], edges[1:]):
            if a >= k:
                break
            t0, t1, now = minutes[a], minutes[min(b, k)], minutes[k]
            kept = (np.exp(-rate * (now - t1)) - np.exp(-rate * (now - t0))) / rate
            sigma += load[a + 1] * (t1 - t0 + 2.0 * kept.sum())
        level[k] = 1.0 - sigma / alpha
    return level


def equivalent_circuit(p, times, currents):
    """Resistances over the state of charge by charge alone, v_oc by straight lines; exact for a
    current that is constant over a row where the resistances hardly change over it."""
    q = charge(times, currents)
    soc = p["soc0"] - q / (3600.0 * p["capacity_Ah"])
    table = np.asarray(p["soc"])
    volts = np.interp(soc, p["ocv_soc"], p["ocv"]) - np.interp(soc, table, p["R0"]) * currents
    middle = 0.5 * (soc[1:] + soc[:-1])
    for r, tau in zip(p["R"], p["tau"]):
        drive = np.interp(middle, table, r) * currents[1:] / tau
        volts = volts - reference_cell.first_order(1.0 / tau, np.diff(times), drive)
    return volts


LAWS = {"ardupilot": ardupilot, "px4": px4, "gazebo": gazebo,
        "equivalent-circuit": equivalent_circuit}


def read_mission(path):
    data = np.genfromtxt(path, delimiter=",", names=True)
    return data["time_s"], data["current_A"]


def judge(case, folder):
    cell = json.loads((folder / case["cell"]).read_text())
    cell["series"], cell["parallel"] = case.get("series", 1), case.get("parallel", 1)
    times, currents = read_mission(folder / case["mission"])
    truth = reference_cell.predict(cell, times, currents)
    if case["law"] == "ns3":
        error = rakhmatov(case["parameters"], times, currents / cell["parallel"]) - truth["soc"]
        return {"rms_level": math.sqrt(np.mean(error ** 2)), "max_level": np.abs(error).max()}
    volts = LAWS[case["law"]](case["parameters"], times, currents)
    error = volts - truth["voltage_V"]
    worst = int(np.argmax(np.abs(error)))
    answer = {"rmse_V": math.sqrt(np.mean(error ** 2)), "max_error_V": abs(error[worst]),
              "worst_s": times[worst]}
    if case["law"] == "px4":
        shown = px4_state_of_charge(case["parameters"], times, currents, truth["voltage_V"])
        answer["rms_level"] = math.sqrt(np.mean((shown - truth["soc"]) ** 2))
    return answer


def main(arguments):
    path = pathlib.Path(arguments[0])
    cases = json.loads(path.read_text())
    print(json.dumps([judge(case, path.parent) for case in cases]))


if __name__ == "__main__":
    main(sys.argv[1:])
