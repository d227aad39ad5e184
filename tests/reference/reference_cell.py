#!/usr/bin/python3
"""An independent lithium-polymer cell in NumPy, written from chapter 4 of the thesis and its
corrections, and the two terms beyond it from docs/theory.md.

It shares no code and no formulas-as-typed with the C++ library: the modes of (4.46) are filtered
one by one with scipy.signal.lfilter where the sampling is uniform and with a plain loop where it is
not, the tail is summed from pi^2/6, the monotone cubic is SciPy's PCHIP and the polynomial is
NumPy's Chebyshev series.

    reference_cell.py predict CELL.json RECORD.csv OUT.csv [--hold backward|forward]
                      [--initial-soc A] [--plain-loop]

RECORD.csv has the columns time_s,current_A of the whole pack, discharge positive. OUT.csv gets
time_s,current_A,voltage_V,open_circuit_V,soc with 17 digits. --plain-loop never uses lfilter.

    reference_cell.py batch FOLDER

does the same for every NAME.case.json in FOLDER: {"cell": CELL.json, "record": RECORD.csv,
"output": OUT.csv, "hold": ..., "initial_soc": ..., "plain_loop": ...}, paths relative to FOLDER.
"""

import argparse
import json
import math
import pathlib
import sys

import numpy as np
from numpy.polynomial import chebyshev
from scipy.interpolate import PchipInterpolator
from scipy.signal import lfilter

# Shorter runs of one sampling interval are looped over: lfilter costs more to start than they take.
SHORTEST_FILTERED_RUN = 64


class Curve:
    """v_oc = f(A), (4.49), in the notation of the cell file; continued with its end slopes."""

    def __init__(self, table):
        method = table["method"]
        if method in ("linear", "monotone-cubic"):
            soc = np.asarray(table["soc"], float)
            voltage = np.asarray(table["voltage_V"], float)
            self.lo, self.hi = soc[0], soc[-1]
            if method == "linear":
                self._inside = lambda a: np.interp(a, soc, voltage)
                self._slopes = ((voltage[1] - voltage[0]) / (soc[1] - soc[0]),
                                (voltage[-1] - voltage[-2]) / (soc[-1] - soc[-2]))
            else:
                cubic = PchipInterpolator(soc, voltage)
                self._inside = cubic
                self._slopes = tuple(float(s) for s in cubic.derivative()(soc[[0, -1]]))
            return
        self.lo, self.hi = table["soc_range"]
        if method == "polynomial":
            if table["basis"] != "chebyshev":
                raise ValueError("basis")
            series = chebyshev.Chebyshev(table["coefficients_V"], domain=[self.lo, self.hi])
            self._inside = series
            slope = series.deriv()
            self._slopes = (slope(self.lo), slope(self.hi))
        elif method == "fourier":
            cosine, sine = table["cosine_V"], table["sine_V"]
            w = table["frequency_rad"]

            def value(a):
                total = np.full(np.shape(a), cosine[0], float)
                for k in range(1, len(cosine)):
                    total = total + cosine[k] * np.cos(k * w * a) + sine[k - 1] * np.sin(k * w * a)
                return total

            def slope(a):
                return sum(k * w * sine[k - 1] * math.cos(k * w * a)
                           - k * w * cosine[k] * math.sin(k * w * a)
                           for k in range(1, len(cosine)))

            self._inside = value
            self._slopes = (slope(self.lo), slope(self.hi))
        else:
            raise ValueError(f"unknown method {method}")

    def __call__(self, a):
        a = np.asarray(a, float)
        inside = np.clip(a, self.lo, self.hi)
        below, above = np.minimum(a - self.lo, 0.0), np.maximum(a - self.hi, 0.0)
        return self._inside(inside) + self._slopes[0] * below + self._slopes[1] * above


def resistance(table, soc):
    """A number, or straight lines between nodes and constant beyond them."""
    if isinstance(table, dict):
        return np.interp(soc, table["soc"], table["resistance_Ohm"])
    return np.full(np.shape(soc), float(table))


def first_order(rate, dt, drive, initial=0.0, plain_loop=False):
    """The solution at every row of x' = -rate x + drive, x(row 0) = initial, where drive[k] is
    constant over the dt[k] that lead from row k to row k + 1. Exact:
    x+ = e^{-rate dt} x + (1 - e^{-rate dt})/rate drive."""
    x = np.empty(len(dt) + 1)
    x[0] = initial
    if len(dt) == 0:
        return x
    if rate == 0.0:
        x[1:] = initial + np.cumsum(drive * dt)
        return x
    start = 0
    ends = np.append(np.flatnonzero(np.diff(dt) != 0.0) + 1, len(dt))
    for end in ends:
        h = dt[start]
        decay, gain = math.exp(-rate * h), -math.expm1(-rate * h) / rate
        if plain_loop or end - start < SHORTEST_FILTERED_RUN:
            for k in range(start, end):
                x[k + 1] = decay * x[k] + gain * drive[k]
        else:
            x[start + 1:end + 1], _ = lfilter(
                [gain], [1.0, -decay], drive[start:end], zi=[decay * x[start]])
        start = end
    return x


def share_rounded_intervals(dt, t):
    """Stamps such as 0.01 k are rounded: neighbouring intervals that agree within it are one."""
    if len(dt) == 0:
        return dt
    tolerance = 4.0 * np.finfo(float).eps * np.abs(t[2:])
    starts = np.concatenate([[True], np.abs(np.diff(dt)) > tolerance])
    return dt[np.maximum.accumulate(np.where(starts, np.arange(len(dt)), 0))]


def predict(cell, t, i, hold="backward", initial_soc=1.0, plain_loop=False):
    """The pack's voltage_V, open_circuit_V and soc at every row, relaxed at the start."""
    t = np.asarray(t, float)
    i = np.asarray(i, float) / cell.get("parallel", 1)
    dt = np.diff(t)
    # The current that flows from row k to row k + 1.
    flow = i[1:] if hold == "backward" else i[:-1]
    curve = Curve(cell["open_circuit_voltage"])

    diffusion = cell["diffusion"]
    alpha = diffusion["alpha_C"] if diffusion else 3600.0 * cell["capacity_Ah"]
    sigma = first_order(0.0, dt, flow)  # sigma_d
    tail = 0.0
    shared = dt if plain_loop else share_rounded_intervals(dt, t)
    if diffusion:
        b2 = diffusion["beta_per_sqrt_s"] ** 2
        terms = diffusion["terms"]
        for m in range(1, terms + 1):
            sigma = sigma + 2.0 * first_order(b2 * m * m, shared, flow, plain_loop=plain_loop)
        if diffusion["tail"]:
            kept = math.fsum(1.0 / m ** 2 for m in range(1, terms + 1))
            tail = 2.0 / b2 * (math.pi ** 2 / 6.0 - kept)

    soc = initial_soc - (sigma + tail * i) / alpha  # (4.48), at the rows
    soc_at_start = initial_soc - (sigma[:-1] + tail * flow) / alpha  # of the step after each row

    open_circuit = curve(soc)
    series_Ohm = resistance(cell["series_resistance_Ohm"], soc)
    if "self_heating" in cell:
        heating = cell["self_heating"]
        tau = heating["time_constant_s"]
        warmth = first_order(1.0 / tau, shared, flow ** 2 / tau, plain_loop=plain_loop)
        series_Ohm = np.maximum(
            series_Ohm - heating["resistance_drop_Ohm_per_A2"] * warmth, series_Ohm / 4.0)
    voltage = open_circuit - series_Ohm * i
    if "charge_transfer" in cell:
        i0 = cell["charge_transfer"]["current_A"]
        ratio = i / i0  # asinh by its logarithm
        bent = np.sign(ratio) * np.log1p(
            np.abs(ratio) + ratio ** 2 / (1.0 + np.sqrt(1.0 + ratio ** 2)))
        voltage = voltage - resistance(cell["charge_transfer"]["resistance_Ohm"], soc) * i0 * bent
    for branch in cell["branches"]:
        r = branch["resistance_Ohm"]
        tau = branch["time_constant_s"] if "time_constant_s" in branch \
            else r * branch["capacitance_F"]
        drive = resistance(r, soc_at_start) * flow
        if tau == 0.0:  # no inertia: the drop of the step that led to the row
            drop = np.concatenate([[0.0], drive])
        else:
            drop = first_order(1.0 / tau, shared, drive / tau, plain_loop=plain_loop)  # (4.50)
        voltage = voltage - drop
    series = cell.get("series", 1)
    return {"voltage_V": series * voltage, "open_circuit_V": series * open_circuit, "soc": soc}


def read_record(path):
    columns = np.genfromtxt(path, delimiter=",", names=True)
    return np.atleast_1d(columns["time_s"]), np.atleast_1d(columns["current_A"])


def run(cell_path, record_path, output_path, hold, initial_soc, plain_loop=False):
    cell = json.loads(pathlib.Path(cell_path).read_text())
    t, i = read_record(record_path)
    out = predict(cell, t, i, hold, initial_soc, plain_loop)
    rows = np.column_stack([t, i, out["voltage_V"], out["open_circuit_V"], out["soc"]])
    np.savetxt(output_path, rows, delimiter=",", fmt="%.17g", comments="",
               header="time_s,current_A,voltage_V,open_circuit_V,soc")


def main(arguments):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("predict")
    for name in ("cell", "record", "output"):
        one.add_argument(name)
    one.add_argument("--hold", choices=("backward", "forward"), default="backward")
    one.add_argument("--initial-soc", type=float, default=1.0)
    one.add_argument("--plain-loop", action="store_true")
    many = commands.add_parser("batch")
    many.add_argument("folder")
    args = parser.parse_args(arguments)
    if args.command == "predict":
        run(args.cell, args.record, args.output, args.hold, args.initial_soc, args.plain_loop)
        return
    folder = pathlib.Path(args.folder)
    for path in sorted(folder.glob("*.case.json")):
        case = json.loads(path.read_text())
        run(folder / case["cell"], folder / case["record"], folder / case["output"],
            case["hold"], case["initial_soc"], case["plain_loop"])


if __name__ == "__main__":
    main(sys.argv[1:])
