"""PyBOP's published example of a multi-pulse fit, in PyBOP: run by tools/bench --peers in its own
virtual environment, prints one JSON object.

usage: pybop_peer.py SETTINGS.json

SETTINGS: {"log": CSV, "capacity_Ah", "curve": null or {"soc", "voltage_V"}, "initial_soc": null or
a number (null: from the first voltage), "start", "bounds", "sigma" by parameter, "iterations",
"unchanged_iterations", "seed", "largest_step_s": null or what the solver may step at once, "probe":
null or parameters at which to evaluate PyBOP's own cost, with that step and with the example's}.
A null curve is that of PyBaMM's example Thevenin parameters.
"""

import json
import sys
import time

import numpy as np
import pybamm
import pybop

NAMES = {"r_s": "R0 [Ohm]", "r_1": "R1 [Ohm]", "c_1": "C1 [F]", "r_2": "R2 [Ohm]", "c_2": "C2 [F]"}
CURVE = "Open-circuit voltage [V]"
# Beyond 0..1, where pulses of a full cell may end.
CURVE_SOC = np.linspace(-0.05, 1.05, 1101)


def read_log(file):
    """time_s, current_A, voltage_V; of repeated stamps the first row, as the example does."""
    table = np.loadtxt(file, delimiter=",", skiprows=1)
    _, first = np.unique(table[:, 0], return_index=True)
    return table[first].T


def parameters_of(settings):
    values = pybamm.ParameterValues("ECM_Example")
    capacity_Ah = settings["capacity_Ah"]
    values.update({
        "Cell capacity [A.h]": capacity_Ah, "Nominal cell capacity [A.h]": capacity_Ah,
        "Element-1 initial overpotential [V]": 0.0, "Upper voltage cut-off [V]": 4.2,
        "Lower voltage cut-off [V]": 2.5,
    })
    values.update({"R2 [Ohm]": 2e-3, "C2 [F]": 3e4, "Element-2 initial overpotential [V]": 0.0},
                  check_already_exists=False)
    if settings["curve"] is not None:
        soc, voltage_V = (np.array(settings["curve"][key]) for key in ("soc", "voltage_V"))
        values.update({CURVE: lambda x: pybamm.Interpolant(soc, voltage_V, x)})
    return values


def curve_of(values):
    """The open-circuit voltage as PyBaMM evaluates it."""
    return np.array([np.asarray(values[CURVE](pybamm.Scalar(float(soc))).evaluate()).item()
                     for soc in CURVE_SOC])


def soc_at(voltage_V, curve_V):
    """Where the curve has that voltage: it rises, to be inverted."""
    return float(np.interp(voltage_V, curve_V, CURVE_SOC))


def make_problem(values, dataset, largest_step_s):
    """The example's solver, which may be held to smaller steps."""
    setup = {} if largest_step_s is None else {"max_step_size": largest_step_s}
    solver = pybamm.CasadiSolver(mode="safe", dt_max=40, extra_options_setup=setup)
    model = pybamm.equivalent_circuit.Thevenin(options={"number of rc elements": 2})
    simulator = pybop.pybamm.Simulator(model, parameter_values=values, protocol=dataset,
                                       solver=solver)
    return pybop.Problem(simulator, pybop.SumSquaredError(dataset))


def cost_at(problem, parameters):
    if parameters is None:
        return None
    point = np.array([parameters[name] for name in NAMES])
    return float(np.squeeze(problem.evaluate(point).values))


def fit(settings):
    time_s, current_A, voltage_V = read_log(settings["log"])
    values = parameters_of(settings)
    curve_V = curve_of(values)
    initial_soc = settings["initial_soc"]
    if initial_soc is None:
        initial_soc = soc_at(voltage_V[0], curve_V)
    for name, key in NAMES.items():
        start, sigma = settings["start"][name], settings["sigma"][name]
        values[key] = pybop.Parameter(distribution=pybop.Gaussian(
            start, sigma, truncated_at=list(settings["bounds"][name])), initial_value=start)
    values["Initial SoC"] = initial_soc
    dataset = pybop.Dataset({"Time [s]": time_s, "Current [A]": current_A,
                             "Voltage [V]": voltage_V})
    np.random.seed(settings["seed"])

    began = time.perf_counter()
    problem = make_problem(values, dataset, settings["largest_step_s"])
    built_s = time.perf_counter() - began
    options = pybop.PintsOptions(max_iterations=settings["iterations"],
                                 max_unchanged_iterations=settings["unchanged_iterations"])
    began = time.perf_counter()
    result = pybop.XNES(problem, options=options).run()
    fit_s = time.perf_counter() - began
    return {
        "versions": {"pybop": pybop.__version__, "pybamm": pybamm.__version__},
        "parameters": dict(zip(NAMES, map(float, result.x))),
        "own_sum_of_squares_V2": float(result.best_cost),
        "fit_s": fit_s,
        "model_build_s": built_s,
        "probe_sum_of_squares_V2": cost_at(problem, settings["probe"]),
        "probe_with_the_examples_solver_V2": cost_at(make_problem(values, dataset, None),
                                                     settings["probe"]),
        "iterations": int(result.n_iterations),
        "evaluations": int(result.n_evaluations),
        "initial_soc": initial_soc,
        "rows": len(time_s),
        "curve": {"soc": CURVE_SOC.tolist(), "voltage_V": curve_V.tolist()},
    }


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        print(json.dumps(fit(json.load(file))))
