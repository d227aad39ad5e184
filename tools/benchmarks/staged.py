"""The whole staged run against the SciPy peer, alternating, on the same files.

lipoid is charged for its whole process, from the start to the cell file on disk; the peer for what
it prints: TOTAL, without the start of Python, and its fit alone.
"""

import json
import re

from . import campaign
from .process import BenchError, median, python_with, run, say

AGREEMENT_V = 1e-9  # of the fit's rmse with that of `lipoid validate`
PEER_LINE = re.compile(
    r"alpha ([\d.]+) .*load ([\d.]+) s eval ([\d.]+) s fit ([\d.]+) s nfev (\d+) rmse ([\d.]+) "
    r"theta \[([^\]]+)\] TOTAL ([\d.]+) s")


def measure(settings):
    peer, why_not = find_peer(settings.peer_script)
    ours = []
    theirs = []
    for k in range(settings.runs):
        say(f"staged run {k + 1} of {settings.runs}: lipoid")
        ours.append(run_lipoid(settings, settings.campaign))
        if peer is not None:
            say(f"staged run {k + 1} of {settings.runs}: the SciPy peer")
            theirs.append(run_peer(peer, settings.campaign))
    result = {
        "lipoid": {
            "command": ours[0].pop("command"),
            "runs": [{key: value for key, value in figures.items() if key != "command"}
                     for figures in ours],
            "median": medians(ours),
        },
        "validation": check_by_validation(settings, ours[-1]["rmse_V"]),
        "joint": run_joint(settings, settings.campaign),
        "peer_skipped": why_not,
    }
    if theirs:
        result["peer"] = {
            "command": theirs[0].pop("command"),
            "runs": [{key: value for key, value in figures.items() if key != "command"}
                     for figures in theirs],
            "median": medians(theirs),
        }
    return result


def find_peer(script):
    """(command, None), or (None, why the peer does not run)."""
    if not script.is_file():
        return None, f"there is no {script.name}; --peer-script names it"
    python = python_with("numpy", "scipy", "pandas")
    if python is None:
        return None, "no python3 with numpy, scipy and pandas (Debian: python3-pandas)"
    return [python, script], None


def cell_file(folder):
    """Beside the folder of the logs, so that no campaign overwrites another's."""
    return folder.with_name(f"{folder.name}.cell.json")


def run_lipoid(settings, folder):
    summary_file = folder.with_name(f"{folder.name}.summary.json")
    ended = run([settings.lipoid, "identify", folder / "campaign.toml", "--method", "staged", "-o", cell_file(folder),
                 "--summary", summary_file, "--quiet"])
    summary = json.loads(summary_file.read_text(encoding="utf-8"))
    joint = summary["stages"]["pulses"]
    held = summary["stages"]["pulses_beta_held"]
    return {
        "command": ended.command,
        **ended.figures(),
        "command_wall_s": summary["wall_s"],
        "joint_fit_s": joint["wall_s"],
        "fit_beta_held_s": held["wall_s"],
        "joint_fit_evaluations": joint["evaluations"],
        "rmse_V": joint["rmse_V"],
        "parameters": {"alpha": summary["alpha_C"], **joint["parameters"]},
    }


def run_joint(settings, folder):
    """The same logs by the joint method, which the peer does not have."""
    summary_file = folder.with_name("joint.summary.json")
    ended = run([settings.lipoid, "identify", folder / "campaign.toml", "--method", "joint", "-o",
                 folder.with_name("joint.cell.json"), "--summary", summary_file, "--truth", folder / "truth.json", "--quiet"])
    summary = json.loads(summary_file.read_text(encoding="utf-8"))
    pulses = next(log for log in summary["logs"] if log["file"] == "pulses.csv")
    return {
        "command": ended.command,
        **ended.figures(),
        "rmse_V": pulses["rmse_V"],
        "truth": {name: entry["truth"] for name, entry in summary["truth"]["parameters"].items()},
        "parameters": {name: entry["estimate"]
                       for name, entry in summary["truth"]["parameters"].items()},
    }


def run_peer(peer, folder, limit_s=None):
    """Its figures; None where it did not end within the limit."""
    ended = run([*peer, campaign.peer_folder(folder)], limit_s is None, limit_s)
    if limit_s is not None and ended.exit_code < 0:
        return None
    match = PEER_LINE.search(ended.out)
    if match is None:
        raise BenchError(f"{ended.command} printed no line of figures:\n{ended.out[-1000:]}")
    alpha, load_s, evaluation_s, fit_s, evaluations, rmse_V, theta, total_s = match.groups()
    beta, series, resistance, capacitance = (float(word) for word in theta.split())
    return {
        "command": ended.command,
        **ended.figures(),
        "load_s": float(load_s),
        "evaluation_s": float(evaluation_s),
        "fit_s": float(fit_s),
        "evaluations": int(evaluations),
        "rmse_V": float(rmse_V),
        "parameters": {"alpha": float(alpha), "beta": beta, "r_s": series, "r_1": resistance,
                       "c_1": capacitance},
        "total_s": float(total_s),
    }


def medians(runs):
    return {key: median(runs, key) for key, value in runs[0].items()
            if isinstance(value, (int, float))}


def check_by_validation(settings, rmse_V):
    """The rmse of the fit again, by another command from the cell file and the CSV."""
    summary_file = settings.scratch / "validation.summary.json"
    ended = run([settings.lipoid, "validate", cell_file(settings.campaign),
                 settings.campaign / "pulses.csv", "--summary", summary_file, "--quiet"])
    log = json.loads(summary_file.read_text(encoding="utf-8"))["logs"][0]
    difference_V = abs(log["rmse_V"] - rmse_V)
    if not difference_V <= AGREEMENT_V:
        raise BenchError(f"validate finds an rmse of {log['rmse_V']} V, the fit says {rmse_V} V")
    return {"command": ended.command, "rmse_V": log["rmse_V"], "difference_V": difference_V,
            "allowed_V": AGREEMENT_V}
