"""The joint method's whole run against SciPy doing the same fit, on lab logs and at thesis scale.

lipoid is charged for its whole process, with the choice of the structure, the staged run before it
and the standard errors behind it. The peer gets alpha, the structure and the smoothness that lipoid
found, and is charged for reading the logs and for the fit. Both answers are judged by the peer's
own sum of squares.
"""

import json
import pathlib
import tomllib

from .process import ROOT, BenchError, median, python_with, run, say

DATA = ROOT.parent / "shared/data"
# Name, campaign below the lab logs, seconds that it may take.
LAB_CAMPAIGNS = (
    ("nissan", "nissan_leaf_33ah/campaign.toml", 0.5),
    ("dmegc", "dmegc_inr18650_26_r1/campaign.toml", 0.5),
    ("panasonic", "panasonic_18650pf/campaign.toml", 1.0),
)
THESIS_SCALE = "thesis-scale"
THESIS_GOAL_S = 1.5
GOALS_S = {**{name: goal_s for name, _, goal_s in LAB_CAMPAIGNS}, THESIS_SCALE: THESIS_GOAL_S}
LIMIT_S = 600.0  # of one run of the peer
COMPARABLE = 1.05  # rmse of the one over that of the other
PEER = pathlib.Path(__file__).resolve().with_name("joint_peer.py")


def measure(settings):
    python = python_with("numpy", "scipy")
    rows = []
    for name, place in ((name, DATA / file) for name, file, _ in LAB_CAMPAIGNS):
        if place.is_file():
            rows.append(duel(settings, python, name, place))
        else:
            rows.append({"name": name, "skipped": f"there is no {place.relative_to(DATA)}"})
    rows.append(duel(settings, python, THESIS_SCALE, settings.campaign / "campaign.toml"))
    return {"peer_limit_s": LIMIT_S, "comparable": COMPARABLE, "campaigns": rows,
            "peer_skipped": None if python else "no python3 with numpy and scipy"}


def duel(settings, python, name, campaign):
    """Both in turn; what the peer is given comes from the first run of lipoid."""
    ours, theirs = [], []
    problem_file = settings.scratch / f"joint.{name}.problem.json"
    given = None
    for k in range(settings.runs):
        say(f"joint, {name}, run {k + 1} of {settings.runs}: lipoid")
        figures, summary, cell = run_lipoid(settings, name, campaign)
        ours.append(figures)
        if given is None:
            given = problem(campaign, summary, cell)
            problem_file.write_text(json.dumps(given), encoding="utf-8")
        if python is None or None in theirs:
            continue
        say(f"joint, {name}, run {k + 1} of {settings.runs}: the SciPy peer")
        theirs.append(run_peer(python, problem_file))
    result = {
        "name": name,
        "structure": {key: given[key] for key in ("branches", "self_heating", "charge_transfer")},
        "lipoid": listed(ours, ("wall_s", "processor_s", "joint_s", "peak_memory_MB", "rmse_V")),
    }
    if theirs and None not in theirs:
        result["peer"] = listed(theirs, ("total_s", "fit_s", "load_s", "processor_s", "rows",
                                         "points", "unknowns", "evaluations", "rmse_V"))
        result["peer"]["judges"] = {"lipoid_rmse_V": theirs[-1]["judged"]["rmse_V"],
                                    "lipoid_cost_V2": theirs[-1]["judged"]["cost_V2"],
                                    "own_cost_V2": theirs[-1]["cost_V2"]}
        result["peer"]["rates"] = theirs[-1]["rates"]
    elif theirs:
        result["peer_ended"] = False
    return result


def listed(runs, keys):
    return {"command": runs[0]["command"],
            "runs": [{key: one[key] for key in keys} for one in runs],
            "median": {key: median(runs, key) for key in keys}}


def run_lipoid(settings, name, campaign):
    summary_file = settings.scratch / f"joint.{name}.summary.json"
    cell_file = settings.scratch / f"joint.{name}.cell.json"
    ended = run([settings.lipoid, "identify", campaign, "--method", "joint", "-o", cell_file,
                 "--summary", summary_file, "--quiet"])
    summary = json.loads(summary_file.read_text(encoding="utf-8"))
    figures = {"command": ended.command, **ended.figures(), "joint_s": summary["joint"]["wall_s"],
               "rmse_V": summary["joint"]["rmse_V"]}
    return figures, summary, json.loads(cell_file.read_text(encoding="utf-8"))


def run_peer(python, problem_file):
    """Its figures; None where it did not end within the limit."""
    ended = run([python, PEER, problem_file], False, LIMIT_S)
    if ended.exit_code < 0:
        return None
    if ended.exit_code != 0:
        raise BenchError(f"{ended.command} ended with {ended.exit_code}:\n{ended.err[-2000:]}")
    return {"command": ended.command, **ended.figures(), **json.loads(ended.out)}



def table_of(resistance):
    return resistance["resistance_Ohm"] if isinstance(resistance, dict) else [resistance]


def problem(campaign, summary, cell):
    """What joint_peer.py reads: the logs, and all that lipoid had to find but the fit itself."""
    series = cell["series_resistance_Ohm"]
    heating = cell.get("self_heating")
    transfer = cell.get("charge_transfer")
    options = cell["run"]["options"]["joint"]
    tables = [table_of(resistance) for resistance in (
        series, *(branch["resistance_Ohm"] for branch in cell["branches"]),
        *([transfer["resistance_Ohm"]] if transfer else []))]
    rates = {"beta": cell["diffusion"]["beta_per_sqrt_s"],
             **{f"tau_{j + 1}": time_constant_of(branch)
                for j, branch in enumerate(cell["branches"])}}
    if heating:
        rates["tau_h"] = heating["time_constant_s"]
    if transfer:
        rates["i_0"] = transfer["current_A"]
    return {
        "logs": logs_of(campaign),
        "alpha_C": cell["diffusion"]["alpha_C"],
        "terms": cell["diffusion"]["terms"],
        "tail": cell["diffusion"]["tail"],
        "branches": len(cell["branches"]),
        "voltage_soc": cell["open_circuit_voltage"]["soc"],
        "resistance_soc": series["soc"] if isinstance(series, dict) else [0.5],
        "self_heating": heating is not None,
        "charge_transfer": transfer is not None,
        "smoothness": summary["joint"]["smoothness"],
        "charge_uncertainty": options["charge_uncertainty"],
        "voltage_uncertainty_V": options["voltage_uncertainty_V"],
        "answer": {"rates": rates, "voltage_V": cell["open_circuit_voltage"]["voltage_V"],
                   "tables": tables,
                   "heating": heating["resistance_drop_Ohm_per_A2"] if heating else 0.0},
    }


def time_constant_of(branch):
    if "time_constant_s" in branch:
        return branch["time_constant_s"]
    return branch["resistance_Ohm"] * branch["capacitance_F"]


def logs_of(campaign):
    """The logs that take part. Those of these campaigns need no key beyond these."""
    with open(campaign, "rb") as file:
        entries = tomllib.load(file)["log"]
    return [{"file": str(campaign.parent / entry["file"]), "kind": entry["kind"],
             "hold": entry.get("hold", "backward"), "initial_soc": entry.get("initial_soc", 1.0),
             "weight": entry.get("weight", 1.0)}
            for entry in entries if entry["kind"] != "validation"]
