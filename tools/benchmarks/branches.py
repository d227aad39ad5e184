"""The staged run against the SciPy peer on other branches and with more noise.

One campaign says little of the next: the times needed and the errors left depend on the branch. A
fiftieth of the rows (0.5 s between them), one run each, so that all of them end. Beside both stands
the joint method, which the peer does not have.
"""

from . import campaign
from .process import say
from .staged import find_peer, run_joint, run_lipoid, run_peer

SAMPLING_S = 0.5
RESISTANCES = (0.0003, 0.0005, 0.001)  # Ohm; r_s is 0.0016
TIME_CONSTANTS = (10, 30, 100)  # s
NOISES = (0.0002, 0.001)  # V
LIMIT_S = 120.0
TRUE_BETA = 0.2074  # Table 4.8


def measure(settings):
    peer, why_not = find_peer(settings.peer_script)
    if peer is None:
        return {"skipped": why_not}
    rows = []
    for noise_V in NOISES:
        for resistance in RESISTANCES:
            for time_constant in TIME_CONSTANTS:
                say(f"branch of {resistance} Ohm and {time_constant} s, {noise_V} V of noise")
                rows.append(compare(settings, peer, resistance, time_constant, noise_V))
    return {"sampling_s": SAMPLING_S, "limit_s": LIMIT_S, "true_beta_per_sqrt_s": TRUE_BETA,
            "rows": rows}


def chosen(figures, *keys):
    return {**{key: figures[key] for key in keys}, "beta_per_sqrt_s": figures["parameters"]["beta"]}


def compare(settings, peer, resistance, time_constant, noise_V):
    folder = settings.scratch / "branches" / f"{resistance}_{time_constant}_{noise_V}"
    folder.parent.mkdir(parents=True, exist_ok=True)
    branch = {"r_1": resistance, "c_1": round(time_constant / resistance)}
    made = campaign.make(settings.lipoid, folder, SAMPLING_S, branch, noise_V)
    ours = run_lipoid(settings, folder)
    joint = run_joint(settings, folder)
    theirs = run_peer(peer, folder, LIMIT_S)
    return {
        "resistance_Ohm": resistance,
        "time_constant_s": time_constant,
        "noise_V": noise_V,
        "command": made["command"],
        "lipoid": chosen(ours, "wall_s", "rmse_V"),
        "joint": chosen(joint, "wall_s", "rmse_V"),
        "peer": theirs and chosen(theirs, "total_s", "rmse_V", "evaluations"),
    }
