#!/usr/bin/python3
"""Do the 95 % intervals of `lipoid identify --method joint` hold the truth when the data choose the
structure? Campaigns of cells whose truth is known, made by the model of reference_cell.py.

    coverage_experiment.py LIPOID FOLDER [--kind constant|smooth] [--campaigns 200] [--first-seed 1]

LIPOID is the program, FOLDER a scratch folder: logs are kept there and made only once, results go to
FOLDER/KIND_LABEL.jsonl. `--report-only` prints the tables from there without running anything.

A campaign: a 600 mAh cell, rows of 1 s, forward hold, constant currents of 1C, 2C, 3C and 4C (--rates),
C/12 as the low rate, pulses of 4C for 30 s with 600 s of rest. The voltage has 0.2 mV of white noise and,
with equal chances, 0, 0.2 or 0.5 mV of slow noise (Ornstein-Uhlenbeck, 10 to 300 s; --slow V,s), each log
its own. Other --rates and --slow need a folder of their own. Each truth is drawn at random: alpha, beta, a v_oc(A) that is smooth and meets the cut-off at A = 0, r_s and
one branch.

    constant   r_s and r_1 are numbers
    smooth     r_s and r_1 depend on the state of charge: exponentials towards empty, a logistic step
               and a hump, none of them straight between the nodes of the fit

The report says for each quantity how many intervals held the truth, how many were given at all (a
parameter at its bound has none), the median half-width and the median error, both in percent of the
truth; and which structures were found. With two branches found, the one with the larger resistance at
half charge is compared.
"""

import argparse
import concurrent.futures
import json
import math
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import reference_cell  # noqa: E402

CAPACITY_AH = 0.6
CUTOFF_V = 3.0
WHITE_V = 2e-4
LOW_RATE = 1 / 12
PULSE_RATE, PULSE_S, REST_S = 4, 30, 600


def log_uniform(rng, low, high):
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def open_circuit(rng):
    """A fall near empty, three soft steps and a rise near full, with v_oc(0) the cut-off."""
    soc = np.linspace(-0.1, 1.0, 1101)
    rise = rng.uniform(0.45, 0.65)
    shape = rise * soc
    for _ in range(3):
        shape = shape + rng.uniform(0.01, 0.06) * np.tanh(
            (soc - rng.uniform(0.15, 0.85)) / log_uniform(rng, 0.03, 0.2))
    shape = shape + rng.uniform(0.02, 0.05) * np.exp((soc - 1.0) / rng.uniform(0.03, 0.08))
    width = rng.uniform(0.02, 0.05)
    depth = rng.uniform(0.35, 0.55)
    shape = shape - depth * np.exp(-soc / width)
    voltage = CUTOFF_V + shape - np.interp(0.0, soc, shape)
    return {"method": "monotone-cubic", "soc": soc.tolist(), "voltage_V": voltage.tolist()}


def smooth_table(rng, half_charge_Ohm):
    """A resistance over the state of charge whose value at half charge is given."""
    soc = np.linspace(-0.1, 1.0, 2201)
    shape = 1.0 + rng.uniform(0.3, 1.5) * np.exp(-soc / log_uniform(rng, 0.03, 0.2))
    shape += rng.uniform(0.1, 0.5) / (
        1.0 + np.exp((soc - rng.uniform(0.05, 0.3)) / log_uniform(rng, 0.01, 0.06)))
    shape += rng.uniform(-0.15, 0.15) * np.exp(-((soc - rng.uniform(0.3, 0.9)) / 0.15) ** 2)
    shape *= 1.0 + rng.uniform(-0.2, 0.2) * (soc - 0.5)
    return {"soc": soc.tolist(),
            "resistance_Ohm": (half_charge_Ohm * shape / np.interp(0.5, soc, shape)).tolist()}


def make_cell(kind, rng):
    table = (lambda r: smooth_table(rng, r)) if kind == "smooth" else (lambda r: r)
    return {
        "schema": "lipoid.cell/1", "name": f"coverage, {kind}", "series": 1, "parallel": 1,
        "capacity_Ah": CAPACITY_AH, "cutoff_V": CUTOFF_V,
        "diffusion": {"alpha_C": 3600 * CAPACITY_AH * float(rng.uniform(0.95, 1.05)),
                      "beta_per_sqrt_s": log_uniform(rng, 0.08, 0.4), "terms": 10, "tail": True},
        "open_circuit_voltage": open_circuit(rng),
        "series_resistance_Ohm": table(log_uniform(rng, 0.03, 0.13)),
        "branches": [{"resistance_Ohm": table(log_uniform(rng, 0.01, 0.05)),
                      "time_constant_s": log_uniform(rng, 8.0, 100.0)}],
    }


def write_campaign(kind, seed, folder, args):
    """The logs of one campaign, its campaign.toml, and truth.json."""
    rng = np.random.default_rng([seed, {"constant": 0, "smooth": 1}[kind]])
    cell = make_cell(kind, rng)
    alpha = cell["diffusion"]["alpha_C"]
    slow_V = float(rng.choice([0.0, 2e-4, 5e-4]))
    slow_s = log_uniform(rng, 10.0, 300.0)
    if args.slow:
        slow_V, slow_s = (float(number) for number in args.slow.split(","))
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["[cell]", f'name = "{cell["name"]}, seed {seed}"', f"capacity_Ah = {CAPACITY_AH}",
             f"cutoff_V = {CUTOFF_V}"]

    def write(name, log_kind, current):
        t = np.arange(len(current), dtype=float)
        voltage = reference_cell.predict(cell, t, current, "forward")["voltage_V"]
        end = int(np.flatnonzero(voltage <= CUTOFF_V)[0]) + 1
        kept = math.exp(-1.0 / slow_s)
        fresh = rng.standard_normal(end) * math.sqrt(1.0 - kept * kept)
        fresh[0] = rng.standard_normal()
        slow = slow_V * reference_cell.lfilter([1.0], [1.0, -kept], fresh)
        noisy = voltage[:end] + slow + WHITE_V * rng.standard_normal(end)
        np.savetxt(folder / name, np.column_stack([t[:end], current[:end], noisy]), delimiter=",",
                   comments="", header="time_s,current_A,voltage_V", fmt=("%d", "%.6g", "%.7f"))
        lines.extend(["", "[[log]]", f'kind = "{log_kind}"', f'file = "{name}"', 'hold = "forward"'])

    for rate in (float(number) for number in args.rates.split(",")):
        amps = rate * CAPACITY_AH
        write(f"cc_{rate:g}c.csv", "constant-current", np.full(int(1.02 * alpha / amps), amps))
    amps = LOW_RATE * CAPACITY_AH
    write("low_rate.csv", "low-rate", np.full(int(1.02 * alpha / amps), amps))
    amps = PULSE_RATE * CAPACITY_AH
    pulse = np.concatenate([np.full(PULSE_S, amps), np.zeros(REST_S)])
    write("pulse.csv", "pulses", np.tile(pulse, int(1.02 * alpha / (amps * PULSE_S)) + 1))
    (folder / "truth.json").write_text(json.dumps(
        {"cell": cell, "slow_V": slow_V, "slow_s": slow_s}))
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")


def truths(cell):
    """What a report may ask for: the name in `parameters[]` and its true value."""
    branch = cell["branches"][0]

    def at(table, soc):
        return float(reference_cell.resistance(table, soc))

    r_s, r_1 = cell["series_resistance_Ohm"], branch["resistance_Ohm"]
    values = {"alpha": cell["diffusion"]["alpha_C"], "beta": cell["diffusion"]["beta_per_sqrt_s"],
              "tau_1": branch["time_constant_s"], "r_total(0.5)": at(r_s, 0.5) + at(r_1, 0.5)}
    for soc in (0.2, 0.5, 0.8):
        values[f"r_s({soc})"] = at(r_s, soc)
        values[f"r_1({soc})"] = at(r_1, soc)
    return values


def pulse_resistance(cell, test):
    """What a pulse from rest would show of this cell."""
    time_s, current_A = [0.0, test["after_s"]], [0.0, test["current_A"]]
    voltage = reference_cell.predict(cell, time_s, current_A, initial_soc=test["soc"])["voltage_V"]
    return float((voltage[0] - voltage[1]) / test["current_A"])


def compare(summary, truth):
    """One row per quantity of the truth: its value, the estimate and the interval."""
    found = {p["name"]: p for p in summary["parameters"]}
    joint = summary["joint"]

    def size(j):
        p = found.get(f"r_{j}(0.5)") or found.get(f"r_{j}")
        return p["estimate"] if p else 0.0

    branch = max(range(1, joint["branches"] + 1), key=size, default=1)
    rows = {}
    for name, value in truths(truth["cell"]).items():
        asked = name.replace("_1", f"_{branch}")
        p = found.get(asked) or found.get(asked.split("(")[0])
        if name == "r_total(0.5)" and p is None:
            p = found.get("r_s") or found.get("r_s(0.5)")
        if p is None:
            continue
        low, high = p["interval_95"] or (None, None)
        rows[name] = {"truth": value, "estimate": p["estimate"], "low": low, "high": high,
                      "standard_error": p["standard_error"], "verdict": p["verdict"]}
    for test in summary["resistance"]:
        low, high = test["interval_95"] or (None, None)
        rows[f"R({test['after_s']:g} s)"] = {
            "truth": pulse_resistance(truth["cell"], test), "estimate": test["resistance_Ohm"],
            "low": low, "high": high, "standard_error": None if low is None else high - low,
            "verdict": None}
    return {"structure": {k: joint[k] for k in ("branches", "resistance_nodes", "voltage_nodes",
                                                "self_heating", "charge_transfer", "smoothness")},
            "rmse_V": joint["rmse_V"], "wall_s": joint["wall_s"], "slow_V": truth["slow_V"],
            "slow_s": truth["slow_s"],
            "mean_error_percent": float(np.mean([log["mean_error_percent"] for log in summary["logs"]]))
            if summary["logs"] and "mean_error_percent" in summary["logs"][0] else None,
            "parameters": rows}


def run_one(args, kind, seed):
    folder = args.folder / f"{kind}_{seed:04d}"
    if not (folder / "campaign.toml").exists():
        write_campaign(kind, seed, folder, args)
    summary = folder / f"summary_{args.label}.json"
    command = [str(args.lipoid), "identify", str(folder / "campaign.toml"), "--method", "joint",
               "-o", str(folder / f"cell_{args.label}.json"), "--summary", str(summary)]
    for setting in args.set or []:
        command += ["--set", setting]
    command += args.option or []
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        return {"seed": seed, "failed": done.stderr.strip()}
    result = compare(json.loads(summary.read_text()), json.loads((folder / "truth.json").read_text()))
    return {"seed": seed, "exit": done.returncode, **result}


def structure_text(s):
    text = "constant" if s["resistance_nodes"] == 1 else f"{s['resistance_nodes']} nodes"
    text += f", {s['branches']} branch{'' if s['branches'] == 1 else 'es'}"
    return text + (", self-heating" if s["self_heating"] else "") + (
        ", charge transfer" if s["charge_transfer"] else "")


def report(kind, results):
    failed = [r for r in results if "failed" in r]
    results = [r for r in results if "failed" not in r]
    print(f"\n{kind}: {len(results)} campaigns, {len(failed)} failed")
    print(f"{'quantity':14s} {'held':>5s} {'given':>6s} {'share':>7s} {'half-width':>11s} {'error':>8s}")
    for name in results[0]["parameters"] if results else ():
        rows = [r["parameters"][name] for r in results if name in r["parameters"]]
        given = [p for p in rows if p["standard_error"] is not None
                 and p["low"] is not None and p["high"] is not None]
        held = sum(p["low"] <= p["truth"] <= p["high"] for p in given)
        widths = [50 * (p["high"] - p["low"]) / p["truth"] for p in given]
        errors = [100 * abs(p["estimate"] / p["truth"] - 1) for p in rows]
        share = f"{100 * held / len(given):6.1f}%" if given else "      -"
        print(f"{name:14s} {held:5d} {len(given):6d} {share} {np.median(widths or [np.nan]):10.3f}% "
              f"{np.median(errors):7.3f}%")
    counts = {}
    for r in results:
        text = structure_text(r["structure"])
        counts[text] = counts.get(text, 0) + 1
    for text, count in sorted(counts.items(), key=lambda item: -item[1]):
        print(f"  {count:4d}  {text}")
    if results:
        print(f"  seconds of the fit: median {np.median([r['wall_s'] for r in results]):.2f}")


def main(arguments):
    p = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("lipoid", type=pathlib.Path)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--kind", choices=("constant", "smooth"), action="append")
    p.add_argument("--rates", default="1,2,3,4", help="of the constant currents, in C")
    p.add_argument("--slow", help="V,s of the slow noise of every campaign")
    p.add_argument("--campaigns", type=int, default=200)
    p.add_argument("--first-seed", type=int, default=1)
    p.add_argument("--jobs", type=int, default=2)
    p.add_argument("--label", default="now", help="of the results file, to compare programs")
    p.add_argument("--set", action="append", help="handed on to lipoid identify --set")
    p.add_argument("--option", action="append", help="one more argument of lipoid identify")
    p.add_argument("--report-only", action="store_true")
    args = p.parse_args(arguments)
    args.folder.mkdir(parents=True, exist_ok=True)
    for kind in args.kind or ["constant", "smooth"]:
        path = args.folder / f"{kind}_{args.label}.jsonl"
        if not args.report_only:
            seeds = range(args.first_seed, args.first_seed + args.campaigns)
            with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool, path.open("w") as out:
                for result in pool.map(lambda seed: run_one(args, kind, seed), seeds):
                    out.write(json.dumps(result) + "\n")
                    out.flush()
        report(kind, [json.loads(line) for line in path.read_text().splitlines()])


if __name__ == "__main__":
    main(sys.argv[1:])
