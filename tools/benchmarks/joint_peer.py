"""The joint fit of docs/joint.md with SciPy: variable projection, nnls in, least_squares outside.

usage: joint_peer.py PROBLEM.json     prints one JSON object

PROBLEM: {"logs": [{"file", "kind", "hold", "initial_soc", "weight"}], "alpha_C", "terms", "tail",
"branches", "voltage_soc", "resistance_soc", "self_heating", "charge_transfer", "smoothness",
"charge_uncertainty", "voltage_uncertainty_V", "answer": null or another's {"rates": {"beta",
"tau_1", ...}, "voltage_V", "tables", "heating"}}.

It is spared what lipoid has to find: alpha, which terms there are, how many nodes and branches and
how smooth. Long stretches of constant current are averaged to a few points, as lipoid does in its
own way, and the inner problem is solved on its triangular factor. What it minimizes is said in
docs/joint.md, 1 and 2; the reference curve of weights and smoothing is the low-rate log's. An
answer of another's is judged by the same sum of squares.
"""

import itertools
import json
import sys
import time

import numpy as np
from scipy import linalg, optimize

LONGEST_AS_IT_IS = 2500  # rows of a log; more are averaged
GROWTH = 0.16  # of a block, of the time since the current changed
LARGEST_BLOCK = 1 / 150  # of the rows of a log
LEVEL = 0.005  # of the largest current: what may vary within a block
END_SHARE = 0.005  # of the charge: what gives the end slope of the low-rate log
BETA_BOUNDS = (1e-3, 1.0)
STARTS = {"beta": (0.02, 0.06, 0.18, 0.5), "tau": 4}  # the grid outside
POLISHED = 2  # the best of it


# ---- logs ----------------------------------------------------------------------------------------

def read_log(entry):
    """time_s, current_A, voltage_V; of repeated stamps the first row, a discharge is positive."""
    table = np.loadtxt(entry["file"], delimiter=",", skiprows=1, usecols=(0, 1, 2))
    _, first = np.unique(table[:, 0], return_index=True)
    time_s, current_A, voltage_V = table[first].T
    loaded = np.abs(current_A) > 0.05 * np.abs(current_A).max()
    if np.mean(current_A[loaded]) < 0.0:
        current_A = -current_A
    return time_s, current_A, voltage_V


def block_edges(current_A):
    """Where blocks of rows begin: each row alone, but for long stretches of one current. The last
    row of a stretch stays alone, so that the current between two points does not change."""
    n = len(current_A)
    if n <= LONGEST_AS_IT_IS:
        return np.arange(n)
    level = LEVEL * np.abs(current_A).max()
    changes = np.flatnonzero(np.abs(np.diff(current_A)) > level) + 1
    edges = []
    for first, end in itertools.pairwise([0, *changes, n]):
        k = first
        while k < end - 1:
            edges.append(k)
            k = min(k + max(1, min(int(GROWTH * (k - first)), int(LARGEST_BLOCK * n))), end - 1)
        edges.append(end - 1)
    return np.array(edges)


class Points:
    """A log as the fit sees it: block means, and the mean current between them."""

    def __init__(self, entry, alpha_C):
        time_s, current_A, voltage_V = read_log(entry)
        step_A = current_A[1:] if entry["hold"] == "backward" else current_A[:-1]
        charge_C = np.concatenate([[0.0], np.cumsum(step_A * np.diff(time_s))])
        edges = block_edges(current_A)
        self.kind = entry["kind"]
        self.rows = len(time_s)
        self.count = np.diff(np.append(edges, self.rows)).astype(float)

        def mean(column):
            return np.add.reduceat(column, edges) / self.count

        self.time_s = mean(time_s)
        self.voltage_V = mean(voltage_V)
        self.current_A = mean(current_A)
        self.dt_s = np.diff(self.time_s, prepend=self.time_s[0])
        # Between the rows the charge is a straight line: no ampere second is lost.
        charge_C = np.interp(self.time_s, time_s, charge_C)
        self.delivered_C = alpha_C * (1.0 - entry["initial_soc"]) + charge_C
        self.step_A = np.zeros(len(edges))
        self.step_A[1:] = np.diff(charge_C) / self.dt_s[1:]
        self.shortest_s = np.diff(time_s).min()
        self.longest_s = self.longest_level_s(time_s, current_A)
        self.log_weight = entry["weight"]
        self.weight = None

    @staticmethod
    def longest_level_s(time_s, current_A):
        changes = np.flatnonzero(np.abs(np.diff(current_A)) > LEVEL * np.abs(current_A).max())
        return np.diff([time_s[0], *time_s[changes], time_s[-1]]).max()


# ---- the model -----------------------------------------------------------------------------------

def recurrence(decay, drive):
    """x[k] = decay[k] x[k-1] + drive[k] with x[-1] = 0, along the first axis, by doubling."""
    decay, drive = decay.copy(), drive.copy()
    step = 1
    while step < len(drive):
        drive[step:] = drive[step:] + decay[step:] * drive[:-step]
        decay[step:] = decay[step:] * decay[:-step]
        step *= 2
    return drive


def shares(soc, nodes, inside):
    """The shares of straight-line nodes, one row for each state of charge."""
    matrix = np.zeros((len(soc), len(nodes)))
    if len(nodes) == 1:
        matrix[:] = 1.0
        return matrix
    lower = np.clip(np.searchsorted(nodes, soc, side="right") - 1, 0, len(nodes) - 2)
    share = (soc - nodes[lower]) / (nodes[lower + 1] - nodes[lower])
    if inside:
        share = np.clip(share, 0.0, 1.0)
    row = np.arange(len(soc))
    matrix[row, lower] = 1.0 - share
    matrix[row, lower + 1] = share
    return matrix


def tail_sum(terms):
    return np.pi ** 2 / 6.0 - sum(1.0 / m ** 2 for m in range(1, terms + 1))


class Problem:
    """The sum of squares of one structure: rows sqrt(w) (v - a'x), then those of the smoothing."""

    def __init__(self, given):
        self.given = given
        self.alpha_C = given["alpha_C"]
        self.voltage_soc = np.array(given["voltage_soc"])
        self.resistance_soc = np.array(given["resistance_soc"])
        self.branches = given["branches"]
        self.logs = [Points(entry, self.alpha_C) for entry in given["logs"]]
        self.reference_V = self.find_reference()
        self.weigh()
        self.rows = sum(log.rows for log in self.logs)
        self.points = sum(len(log.time_s) for log in self.logs)
        self.weight_sum = sum(log.log_weight for log in self.logs)
        current_A, weight = (np.concatenate([getattr(log, name) for log in self.logs])
                             for name in ("current_A", "weight"))
        self.largest_A = np.abs(current_A).max()
        loaded = np.abs(current_A) >= 0.05 * self.largest_A
        self.typical_A = np.sqrt(np.sum((weight * current_A ** 2)[loaded])
                                 / np.sum(weight[loaded]))
        pulses = [log for log in self.logs if log.kind == "pulses"] or self.logs
        self.tau_bounds = (0.5 * min(log.shortest_s for log in pulses),
                           max(log.longest_s for log in pulses))
        self.tables = 1 + self.branches + given["charge_transfer"]
        self.smoothing = self.smoothing_rows()
        self.evaluations = 0

    def find_reference(self):
        """The low-rate log at the nodes, rising; below its end it goes on with its end slope."""
        log = next(log for log in self.logs if log.kind == "low-rate")
        loaded = log.current_A > 0.0
        soc = 1.0 - log.delivered_C[loaded][::-1] / self.alpha_C
        voltage_V = log.voltage_V[loaded][::-1]
        end = np.searchsorted(soc, soc[0] + END_SHARE)
        slope_V = (voltage_V[end] - voltage_V[0]) / (soc[end] - soc[0])
        below_V = slope_V * np.minimum(self.voltage_soc - soc[0], 0.0)
        return np.maximum.accumulate(np.interp(self.voltage_soc, soc, voltage_V) + below_V)

    def weigh(self):
        slopes_V = np.diff(self.reference_V) / np.diff(self.voltage_soc)
        for log in self.logs:
            soc = 1.0 - log.delivered_C / self.alpha_C
            piece = np.clip(np.searchsorted(self.voltage_soc, soc, side="right") - 1, 0,
                            len(slopes_V) - 1)
            charge_V = self.given["charge_uncertainty"] * slopes_V[piece]
            spread = charge_V / self.given["voltage_uncertainty_V"]
            log.weight = log.log_weight * log.count / log.rows / (1.0 + spread ** 2)

    def smoothing_rows(self):
        scale = self.given["smoothness"] * np.sqrt(self.weight_sum)
        voltages, nodes = len(self.voltage_soc), len(self.resistance_soc)
        second, first = np.diff(np.eye(voltages), 2, axis=0), np.diff(np.eye(voltages), axis=0)
        of_curve = scale * np.concatenate([second, 1e-3 * first])
        second, first = np.diff(np.eye(nodes), 2, axis=0), np.diff(np.eye(nodes), axis=0)
        of_table = scale * np.concatenate([second, 0.1 * first])
        matrix = linalg.block_diag(of_curve, *[of_table] * self.tables,
                                   *[np.zeros((0, 1))] * self.given["self_heating"])
        right = np.zeros(len(matrix))
        right[:len(of_curve)] = of_curve @ self.reference_V
        return matrix, right

    def names(self):
        return ["beta", *(f"tau_{j + 1}" for j in range(self.branches)),
                *["tau_h"] * self.given["self_heating"], *["i_0"] * self.given["charge_transfer"]]

    def bounds(self):
        limits = {"beta": BETA_BOUNDS, "tau_h": (30.0, 1e4),
                  "i_0": (0.01 * self.largest_A, 2.0 * self.largest_A)}
        return np.log([limits.get(name, self.tau_bounds) for name in self.names()]).T

    def soc_of(self, log, beta):
        """At the points, and where the steps to them begin, under their currents."""
        rates = (beta * np.arange(1, self.given["terms"] + 1)) ** 2
        decay = np.exp(-np.outer(log.dt_s, rates))
        gain = -np.expm1(-np.outer(log.dt_s, rates)) / rates
        held_C = 2.0 * recurrence(decay, gain * log.step_A[:, None]).sum(axis=1)
        tail_s = 2.0 * tail_sum(self.given["terms"]) / beta ** 2 if self.given["tail"] else 0.0
        at = 1.0 - (log.delivered_C + held_C + tail_s * log.current_A) / self.alpha_C
        before = np.append(log.delivered_C[0], (log.delivered_C + held_C)[:-1])
        return at, 1.0 - (before + tail_s * log.step_A) / self.alpha_C

    def rows_of(self, log, rates):
        at, start = self.soc_of(log, rates["beta"])
        of_table = shares(at, self.resistance_soc, inside=True)
        of_start = shares(start, self.resistance_soc, inside=True)
        drop = -log.current_A / self.typical_A
        columns = [shares(at, self.voltage_soc, inside=False), of_table * drop[:, None]]
        for j in range(self.branches):
            decay = np.exp(-log.dt_s / rates[f"tau_{j + 1}"])[:, None]
            drive = (1.0 - decay) * of_start * (log.step_A / self.typical_A)[:, None]
            columns.append(-recurrence(np.broadcast_to(decay, drive.shape), drive))
        if self.given["charge_transfer"]:
            i_0 = rates["i_0"]
            drop = -i_0 * np.arcsinh(log.current_A / i_0) / self.typical_A
            columns.append(of_table * drop[:, None])
        if self.given["self_heating"]:
            decay = np.exp(-log.dt_s / rates["tau_h"])
            warmth_A2 = recurrence(decay, (1.0 - decay) * log.step_A ** 2)
            columns.append((warmth_A2 * log.current_A / self.typical_A ** 3)[:, None])
        return np.sqrt(log.weight)[:, None] * np.concatenate(columns, axis=1)

    def system(self, theta):
        """(matrix, right) of the linear unknowns at the logarithms of the rates."""
        rates = dict(zip(self.names(), np.exp(theta)))
        matrix = np.concatenate([*(self.rows_of(log, rates) for log in self.logs),
                                 self.smoothing[0]])
        right = np.concatenate([*(np.sqrt(log.weight) * log.voltage_V for log in self.logs),
                                self.smoothing[1]])
        return matrix, right

    def solve(self, matrix, right):
        """The linear unknowns: rises of v_oc and resistances, none below zero."""
        voltages = len(self.voltage_soc)
        rises = matrix.copy()
        rises[:, :voltages] = np.cumsum(matrix[:, voltages - 1::-1], axis=1)[:, ::-1]
        factor = linalg.qr(np.column_stack([rises, right]), mode="r", overwrite_a=True)[0]
        n = rises.shape[1]
        found, _ = optimize.nnls(factor[:n, :n], factor[:n, n])
        found[:voltages] = np.cumsum(found[:voltages])
        return found

    def residuals(self, theta):
        self.evaluations += 1
        matrix, right = self.system(theta)
        return right - matrix @ self.solve(matrix, right)

    def rmse_V(self, residuals):
        """Weighted, without the smoothing."""
        return float(np.sqrt(np.sum(residuals[:self.points] ** 2) / self.weight_sum))

    def judge(self, answer):
        """Residuals of an answer of another's."""
        theta = np.log([answer["rates"][name] for name in self.names()])
        matrix, right = self.system(theta)
        unknowns = np.concatenate([
            answer["voltage_V"],
            *(np.multiply(table, self.typical_A) for table in answer["tables"]),
            np.array([answer["heating"] * self.typical_A ** 3] * self.given["self_heating"])])
        return right - matrix @ unknowns


# ---- the fit -------------------------------------------------------------------------------------

def starts(problem):
    """A small grid: every beta with every choice of time constants; the rest amid their bounds."""
    lower, upper = problem.bounds()
    middle = 0.5 * (lower + upper)
    taus = np.linspace(*np.log(problem.tau_bounds), STARTS["tau"] + 2)[1:-1]
    for beta in np.log(STARTS["beta"]):
        for chosen in itertools.combinations(taus, problem.branches):
            theta = middle.copy()
            theta[0] = beta
            theta[1:1 + problem.branches] = chosen
            yield theta


def fit(given):
    began = time.perf_counter()
    problem = Problem(given)
    loaded_s = time.perf_counter() - began
    grid = sorted(starts(problem), key=lambda theta: np.sum(problem.residuals(theta) ** 2))
    lower, upper = problem.bounds()
    ends = [optimize.least_squares(problem.residuals, theta, bounds=(lower, upper), x_scale=1.0,
                                   diff_step=1e-4, xtol=1e-6, ftol=1e-8)
            for theta in grid[:POLISHED]]
    best = min(ends, key=lambda end: end.cost)
    total_s = time.perf_counter() - began
    result = {
        "rows": problem.rows,
        "points": problem.points,
        "unknowns": problem.smoothing[0].shape[1],
        "load_s": loaded_s,
        "fit_s": total_s - loaded_s,
        "total_s": total_s,
        "evaluations": problem.evaluations,
        "cost_V2": 2.0 * float(best.cost),
        "rmse_V": problem.rmse_V(best.fun),
        "rates": dict(zip(problem.names(), np.exp(best.x).tolist())),
    }
    if given["answer"] is not None:
        residuals = problem.judge(given["answer"])
        result["judged"] = {"cost_V2": float(residuals @ residuals),
                            "rmse_V": problem.rmse_V(residuals)}
    return result


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        print(json.dumps(fit(json.load(file))))
