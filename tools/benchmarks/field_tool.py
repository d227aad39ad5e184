"""lipoid against PyBOP: its published example on measured pulses, and a cell whose truth is known.

PyBOP runs in a virtual environment with pinned versions (a gigabyte, made once). Both see the same
rows, curve, capacity, initial state of charge, bounds and cost; numpy evaluates both answers
(thevenin.py). PyBaMM draws straight lines between the rows of the current where lipoid holds it:
the sum of squares is given for either.
"""

import csv
import json
import pathlib
import shutil

from .process import ROOT, BenchError, median, python_with, run, say

PINNED = ["pybop==26.3", "pybamm==26.10.1.1"]
LAB_LOG = ROOT.parent / "shared/data/samsung_30t_hppc/multipulse.csv"
HERE = pathlib.Path(__file__).resolve().parent
PUBLISHED_V2 = 1.94e-3  # of PyBOP v25.6, see the README beside the log

# The published example's.
EXAMPLE = {
    "capacity_Ah": 3.0,
    "start": {"r_s": 0.005, "r_1": 0.005, "c_1": 500.0, "r_2": 0.005, "c_2": 2000.0},
    "sigma": {"r_s": 5e-4, "r_1": 5e-4, "c_1": 100.0, "r_2": 5e-4, "c_2": 500.0},
    "bounds": {"r_s": [0.0, 0.1], "r_1": [0.0, 0.1], "c_1": [100.0, 1000.0],
               "r_2": [0.0, 0.1], "c_2": [1000.0, 10000.0]},
    "iterations": 100,
    "unchanged_iterations": 20,
    "largest_step_s": None,
    "probe": None,
}
TRUTH = {"r_s": 0.012, "r_1": 0.006, "c_1": 400.0, "r_2": 0.018, "c_2": 4000.0}
NOISE_V = 0.0005
# Where the truth is at stake: more iterations than the example, and no pulse stepped over.
CARE = {"iterations": 500, "unchanged_iterations": 100, "largest_step_s": 1.0, "probe": TRUTH}
HOLDS = ("backward", "forward")


def measure(settings):
    if not settings.peers:
        return {"skipped": "without --peers"}
    try:
        python = environment(settings.scratch / "venv")
    except BenchError as error:
        return {"skipped": f"the virtual environment could not be made: {error}"}
    result = {"pinned": PINNED}
    curve = None
    if LAB_LOG.is_file():
        problem = {**EXAMPLE, "log": str(LAB_LOG), "curve": None, "initial_soc": None}
        result["published"] = duel(settings, python, "published", problem)
        result["published_sum_V2"] = PUBLISHED_V2
        curve = result["published"].pop("curve")
    else:
        result["published_skipped"] = f"there is no {LAB_LOG.name}"
    if curve is not None:
        result["known_truth"] = known_truth(settings, python, curve)
    return result


def environment(folder):
    """The python of the virtual environment, made where it is missing."""
    python = folder / "bin/python"
    stamp = folder / "pinned.txt"
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != " ".join(PINNED):
        say("making a virtual environment with PyBOP (a gigabyte, once)")
        shutil.rmtree(folder, ignore_errors=True)
        run(["python3", "-m", "venv", folder])
        run([folder / "bin/pip", "install", "--quiet", *PINNED])
        stamp.write_text(" ".join(PINNED), encoding="utf-8")
    return python


def duel(settings, python, name, problem):
    """Both tools in turn on one problem, and the sums of squares of their last answers."""
    ours, theirs = [], []
    peer = None
    for k in range(settings.runs):
        say(f"PyBOP, {name} {k + 1} of {settings.runs}")
        peer = run_pybop(settings, python, {**problem, "seed": k + 1})
        theirs.append(peer)
        ours.append(run_lipoid(settings, name, problem, peer["curve"], peer["initial_soc"]))
    judged = judge(settings, problem, peer, {
        **{f"lipoid, {hold}": fit["parameters"] for hold, fit in ours[-1]["holds"].items()},
        **{f"PyBOP, run {k + 1}": fit["parameters"] for k, fit in enumerate(theirs)}})
    better = min(HOLDS, key=lambda hold: judged[f"lipoid, {hold}"][hold])
    best = min(range(len(theirs)), key=lambda k: judged[f"PyBOP, run {k + 1}"]["linear"])
    return {
        "rows": peer["rows"],
        "initial_soc": peer["initial_soc"],
        "curve": peer["curve"],
        "judged_V2": judged,
        "lipoid": {
            "commands": ours[-1]["commands"],
            "runs": [{key: fits[key] for key in ("wall_s", "fit_s")} for fits in ours],
            "median": {key: median(ours, key) for key in ("wall_s", "fit_s")},
            "hold": better,
            "parameters": ours[-1]["holds"][better]["parameters"],
            "sum_of_squares_V2": judged[f"lipoid, {better}"][better],
            "holds": ours[-1]["holds"],
        },
        "pybop": {
            "command": theirs[-1]["command"],
            "runs": [{key: fit[key] for key in (
                "wall_s", "fit_s", "model_build_s", "iterations", "evaluations",
                "own_sum_of_squares_V2", "probe_sum_of_squares_V2",
                "probe_with_the_examples_solver_V2", "parameters")}
                     for fit in theirs],
            "median": {key: median(theirs, key) for key in ("wall_s", "fit_s", "model_build_s")},
            "versions": peer["versions"],
            "parameters": theirs[best]["parameters"],
            "sum_of_squares_V2": judged[f"PyBOP, run {best + 1}"]["linear"],
        },
    }


def run_pybop(settings, python, problem):
    file = settings.scratch / "pybop.settings.json"
    file.write_text(json.dumps(problem), encoding="utf-8")
    ended = run([python, "-W", "ignore", HERE / "pybop_peer.py", file])
    return {**json.loads(ended.out), "command": ended.command, "wall_s": ended.wall_s}


def run_lipoid(settings, name, problem, curve, initial_soc):
    """With either hold of the current, of which the better is kept: the time is that of both."""
    curve_file = settings.scratch / "curve.csv"
    write_table(curve_file, ["soc", "voltage_V"], zip(curve["soc"], curve["voltage_V"]))
    bounds = [f"{key}={low},{high}" for key, (low, high) in problem["bounds"].items()]
    fits = {"commands": [], "wall_s": 0.0, "fit_s": 0.0, "holds": {}}
    for hold in HOLDS:
        summary_file = settings.scratch / f"{name}.{hold}.summary.json"
        ended = run([settings.lipoid, "identify", "--method", "staged", "--pulses", problem["log"], "--units", "s,A,V",
                     "--hold", hold, "--no-diffusion", "--branches", "2",
                     "--open-circuit-voltage", curve_file, "--cutoff-V", "2.5",
                     "--alpha-C", repr(3600.0 * problem["capacity_Ah"]),
                     "--initial-soc", repr(initial_soc), "--bounds", *bounds,
                     "-o", settings.scratch / f"{name}.{hold}.json",
                     "--summary", summary_file, "--quiet"])
        fit = json.loads(summary_file.read_text(encoding="utf-8"))["stages"]["pulses"]
        fits["commands"].append(ended.command)
        fits["wall_s"] += ended.wall_s
        fits["fit_s"] += fit["wall_s"]
        fits["holds"][hold] = {key: fit[key] for key in (
            "parameters", "rmse_V", "at_bound", "evaluations")}
    return fits


def judge(settings, problem, peer, parameters):
    file = settings.scratch / "judge.json"
    file.write_text(json.dumps({
        "log": problem["log"], "capacity_Ah": problem["capacity_Ah"],
        "initial_soc": peer["initial_soc"], "curve": peer["curve"], "parameters": parameters,
    }), encoding="utf-8")
    python = python_with("numpy")
    if python is None:
        raise BenchError("no python3 with numpy (Debian: python3-numpy)")
    return json.loads(run([python, HERE / "judge_thevenin.py", file]).out)


def known_truth(settings, python, curve):
    """A two-branch cell without diffusion, its log made by lipoid and thinned for PyBOP."""
    log, initial_soc = thinned_log(settings, curve)
    problem = {**EXAMPLE, **CARE, "log": str(log), "curve": curve, "initial_soc": initial_soc}
    result = duel(settings, python, "known_truth", problem)
    result.pop("curve")
    result["truth"] = TRUTH
    for tool in ("lipoid", "pybop"):
        found = result[tool]["parameters"]
        result[tool]["off_by_percent"] = {
            name: 100.0 * (found[name] / true - 1.0) for name, true in TRUTH.items()}
    return result


def thinned_log(settings, curve):
    """(file, state of charge of its first row). Rows stand densely after every switch of the
    current, on both sides of it, and in growing steps behind: PyBOP would need hours for all."""
    folder = settings.scratch / "two_branches"
    cell = settings.scratch / "two_branches.json"
    nodes = zip(curve["soc"], curve["voltage_V"])
    inside = [(soc, v) for soc, v in nodes if -1e-9 < soc < 1 + 1e-9]
    cell.write_text(json.dumps({
        "schema": "lipoid.cell/1", "name": "two branches", "capacity_Ah": EXAMPLE["capacity_Ah"],
        "cutoff_V": 3.0, "diffusion": None,
        "open_circuit_voltage": {"method": "linear", "soc": [soc for soc, _ in inside],
                                 "voltage_V": [v for _, v in inside]},
        "series_resistance_Ohm": TRUTH["r_s"],
        "branches": [{"resistance_Ohm": TRUTH[f"r_{j}"], "capacitance_F": TRUTH[f"c_{j}"]}
                     for j in (1, 2)],
    }), encoding="utf-8")
    run([settings.lipoid, "synthesize", cell, "--pulse-rate-C", "2", "--rest-s", "870",
         "--voltage-noise-V", NOISE_V, "--seed", "1", "-o", folder])
    return thin(folder / "pulses.csv", folder / "thinned.csv")


def thin(full, thinned):
    """From the rest after the first pulse to the sixth pulse; the charge of rows left out stays,
    because the current is the same all along them."""
    with open(full, encoding="utf-8") as lines:
        rows = [tuple(map(float, line)) for line in list(csv.reader(lines))[1:]]
    edges = [k for k in range(1, len(rows)) if rows[k][1] != rows[k - 1][1]]
    first = edges[2] - 1  # the last row of the first rest
    kept = set()
    for begin, end in zip(edges[2:13], edges[3:14]):
        k, step = begin, 1.0
        while k < end:
            kept.add(int(k))
            k += step
            step *= 1.1
        kept.add(end - 1)
    write_table(thinned, ["time_s", "current_A", "voltage_V"],
                [rows[first]] + [rows[k] for k in sorted(kept)])
    charge_C = sum((rows[k][0] - rows[k - 1][0]) * rows[k][1] for k in range(1, first + 1))
    return thinned, 1.0 - charge_C / (3600.0 * EXAMPLE["capacity_Ah"])


def write_table(file, header, rows):
    with open(file, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([repr(float(value)) for value in row] for row in rows)
