#!/usr/bin/python3
"""Writes the lab logs of a cell whose truth is known, with the model of reference_cell.py.

    generate_campaign.py FOLDER --truth TRUTH.json [options]

FOLDER gets cc_1c.csv ... , low_rate.csv, pulse.csv (time_s,current_A,voltage_V; discharge positive)
and campaign.toml. TRUTH.json, which should lie elsewhere, is the cell itself in the notation of the
cell file; its "run" says how the logs were made. The same arguments give the same bytes.

The cell
    --alpha-C 1353.6  --beta 0.1924  --r-s 0.1314
    --branch 0.03,1500         ohm,farad; repeatable; --no-branches: none
    --terms 10  --no-tail      modes of (4.46); the quasi-static tail is on
    --capacity-Ah 0.6          nominal: what 1C means
    --cutoff-V 3.0
    --curve typical|steep      v_oc(A); steep falls off a cliff at A = 0, so that the ohmic drop at
                               cut-off hardly shortens the discharges and (4.53) finds alpha and
                               beta almost without bias
    --scatter 0.2              multiply alpha, beta, r_s, r_j, c_j by random factors (by --seed)
                               within 1 -+ 0.2

The logs
    --rates 1 2 3 4 5 6        constant currents, in C, each until the cut-off
    --low-rate 0.05            in C; until the cut-off
    --ideal-low-rate           the low-rate log shows v_oc(A) itself, as at vanishing rate
    --pulse-rate 6  --pulse-s 30  --rest-s 1770   until the cut-off
    --validation-s 0           length of a random-current log; 0: none
    --sampling-s 1  --low-rate-sampling-s 10      (0.01 everywhere is the thesis)
    --jitter 0                 share of the sampling interval by which stamps are moved at random
    --hold backward|forward    backward: the current of row k flowed since row k-1
    --noise-V 0                standard deviation of the voltage's noise
    --noise-A 0                of the current's: the current that is logged, not the one that flowed
    --resolution-V 0           the voltmeter's last digit
    --digits 17                of the numbers in the CSV
    --seed 1

A log begins with a row at rest at time 0 in backward hold; the first row that is at or below the
cut-off, before noise, is its last.
"""

import argparse
import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import reference_cell  # noqa: E402

TYPICAL = ([0, .02, .05, .1, .2, .3, .4, .5, .6, .7, .8, .9, 1],
           [3.0, 3.3, 3.45, 3.60, 3.70, 3.74, 3.77, 3.82, 3.87, 3.95, 4.02, 4.11, 4.20])
STEEP = ([0, .002, .05, .1, .2, .3, .4, .5, .6, .7, .8, .9, 1],
         [3.0, 3.55, 3.60, 3.65, 3.70, 3.74, 3.77, 3.82, 3.87, 3.95, 4.02, 4.11, 4.20])


def parse(arguments):
    p = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--truth", type=pathlib.Path, required=True)
    p.add_argument("--alpha-C", type=float, default=1353.6)
    p.add_argument("--beta", type=float, default=0.1924)
    p.add_argument("--r-s", type=float, default=0.1314)
    p.add_argument("--branch", action="append")
    p.add_argument("--no-branches", action="store_true")
    p.add_argument("--terms", type=int, default=10)
    p.add_argument("--no-tail", action="store_true")
    p.add_argument("--capacity-Ah", type=float, default=0.6)
    p.add_argument("--cutoff-V", type=float, default=3.0)
    p.add_argument("--curve", choices=("typical", "steep"), default="typical")
    p.add_argument("--scatter", type=float, default=0.0)
    p.add_argument("--rates", type=float, nargs="*", default=[1, 2, 3, 4, 5, 6])
    p.add_argument("--low-rate", type=float, default=0.05)
    p.add_argument("--ideal-low-rate", action="store_true")
    p.add_argument("--pulse-rate", type=float, default=6.0)
    p.add_argument("--pulse-s", type=float, default=30.0)
    p.add_argument("--rest-s", type=float, default=1770.0)
    p.add_argument("--validation-s", type=float, default=0.0)
    p.add_argument("--sampling-s", type=float, default=1.0)
    p.add_argument("--low-rate-sampling-s", type=float, default=10.0)
    p.add_argument("--jitter", type=float, default=0.0)
    p.add_argument("--hold", choices=("backward", "forward"), default="backward")
    p.add_argument("--noise-V", type=float, default=0.0)
    p.add_argument("--noise-A", type=float, default=0.0)
    p.add_argument("--resolution-V", type=float, default=0.0)
    p.add_argument("--digits", type=int, default=17)
    p.add_argument("--seed", type=int, default=1)
    return p.parse_args(arguments)


def make_cell(args, rng):
    def scattered(value):
        return value * float(rng.uniform(1.0 - args.scatter, 1.0 + args.scatter))

    texts = [] if args.no_branches else args.branch or ["0.03,1500"]
    branches = [list(map(float, text.split(","))) for text in texts]
    soc, voltage = TYPICAL if args.curve == "typical" else STEEP
    return {
        "schema": "lipoid.cell/1", "name": f"generated, seed {args.seed}",
        "series": 1, "parallel": 1,
        "capacity_Ah": args.capacity_Ah, "cutoff_V": args.cutoff_V,
        "diffusion": {"alpha_C": scattered(args.alpha_C), "beta_per_sqrt_s": scattered(args.beta),
                      "terms": args.terms, "tail": not args.no_tail},
        "open_circuit_voltage": {"method": "linear", "soc": soc, "voltage_V": voltage},
        "series_resistance_Ohm": scattered(args.r_s),
        "branches": [{"resistance_Ohm": scattered(r), "capacitance_F": scattered(c)}
                     for r, c in branches],
        "run": {"source": "tests/reference/generate_campaign.py",
                "options": {k: v for k, v in vars(args).items() if k not in ("folder", "truth")}},
    }


def stamps(duration, sampling, jitter, rng):
    t = sampling * np.arange(int(np.ceil(duration / sampling)) + 2)
    if jitter:
        t[1:] += sampling * rng.uniform(-0.5 * jitter, 0.5 * jitter, len(t) - 1)
    return t


def with_rest_row(current, hold):
    """In backward hold the row at time 0 closes the rest before the test: no current."""
    if hold == "backward":
        current = current.copy()
        current[0] = 0.0
    return current


class Lab:
    def __init__(self, args, cell, rng):
        self.args, self.cell, self.rng = args, cell, rng

    def until_cutoff(self, t, current):
        out = reference_cell.predict(self.cell, t, current, self.args.hold)
        below = np.flatnonzero(out["voltage_V"] <= self.args.cutoff_V)
        if len(below) == 0:
            raise SystemExit("the cut-off is not reached: does it lie below the curve?")
        end = below[0] + 1
        return t[:end], current[:end], out["voltage_V"][:end]

    def write(self, name, t, current, voltage):
        args = self.args
        voltage = voltage + args.noise_V * self.rng.standard_normal(len(t))
        if args.resolution_V:
            voltage = np.round(voltage / args.resolution_V) * args.resolution_V
        current = current + args.noise_A * self.rng.standard_normal(len(t))
        np.savetxt(args.folder / name, np.column_stack([t, current, voltage]), delimiter=",",
                   comments="", header="time_s,current_A,voltage_V", fmt=f"%.{args.digits}g")

    def constant_current(self, name, current_A):
        duration = 1.02 * self.cell["diffusion"]["alpha_C"] / current_A
        t = stamps(duration, self.args.sampling_s, self.args.jitter, self.rng)
        current = with_rest_row(np.full(len(t), current_A), self.args.hold)
        self.write(name, *self.until_cutoff(t, current))

    def low_rate(self, name, current_A):
        duration = 1.02 * self.cell["diffusion"]["alpha_C"] / current_A
        t = stamps(duration, self.args.low_rate_sampling_s, self.args.jitter, self.rng)
        current = with_rest_row(np.full(len(t), current_A), self.args.hold)
        if not self.args.ideal_low_rate:
            self.write(name, *self.until_cutoff(t, current))
            return
        soc = 1.0 - current_A * t / self.cell["diffusion"]["alpha_C"]
        voltage = reference_cell.Curve(self.cell["open_circuit_voltage"])(soc)
        end = np.flatnonzero(voltage <= self.args.cutoff_V)[0] + 1
        self.write(name, t[:end], current[:end], voltage[:end])

    def pulses(self, name, current_A):
        args = self.args
        period = args.pulse_s + args.rest_s
        alpha = self.cell["diffusion"]["alpha_C"]
        count = int(np.ceil(1.05 * alpha / (current_A * args.pulse_s))) + 1
        t = stamps(count * period, args.sampling_s, 0.0, self.rng)
        # The middle of the interval through which a row's current flows decides: no edge is rounded.
        half = 0.5 * args.sampling_s
        middle = t - half if args.hold == "backward" else t + half
        on = (middle > 0.0) & (np.mod(middle, period) < args.pulse_s)
        if args.jitter:
            t[1:] += half * args.jitter * self.rng.uniform(-1.0, 1.0, len(t) - 1)
        self.write(name, *self.until_cutoff(t, np.where(on, current_A, 0.0)))

    def random_currents(self, name, duration, largest_A):
        args = self.args
        t = stamps(duration, args.sampling_s, args.jitter, self.rng)
        levels = self.rng.uniform(-0.2 * largest_A, largest_A, int(duration / 20.0) + 2)
        level = np.minimum((t / 20.0).astype(int), len(levels) - 1)
        current = with_rest_row(levels[level], args.hold)
        out = reference_cell.predict(self.cell, t, current, args.hold)
        below = np.flatnonzero(out["voltage_V"] <= args.cutoff_V)
        end = below[0] + 1 if len(below) else len(t)
        self.write(name, t[:end], current[:end], out["voltage_V"][:end])


def main(arguments):
    args = parse(arguments)
    rng = np.random.default_rng(args.seed)
    cell = make_cell(args, rng)
    args.folder.mkdir(parents=True, exist_ok=True)
    lab = Lab(args, cell, rng)
    logs = []
    for rate in args.rates:
        name = f"cc_{rate:g}".replace(".", "p") + "c.csv"
        lab.constant_current(name, rate * args.capacity_Ah)
        logs.append(("constant-current", name))
    if args.low_rate > 0.0:
        lab.low_rate("low_rate.csv", args.low_rate * args.capacity_Ah)
        logs.append(("low-rate", "low_rate.csv"))
    if args.pulse_rate > 0.0:
        lab.pulses("pulse.csv", args.pulse_rate * args.capacity_Ah)
        logs.append(("pulses", "pulse.csv"))
    if args.validation_s > 0.0:
        lab.random_currents("validation.csv", args.validation_s, 2.0 * args.capacity_Ah)
        logs.append(("validation", "validation.csv"))
    lines = ["[cell]", f'name = "{cell["name"]}"',
             f"capacity_Ah = {args.capacity_Ah!r}", f"cutoff_V = {args.cutoff_V!r}"]
    for kind, name in logs:
        lines += ["", "[[log]]", f'kind = "{kind}"', f'file = "{name}"']
        if args.hold == "forward":
            lines.append('hold = "forward"')
    (args.folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    args.truth.parent.mkdir(parents=True, exist_ok=True)
    args.truth.write_text(json.dumps(cell, indent=2) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
