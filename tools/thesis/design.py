"""Gains by (6.2) to (6.5) against the printed ones."""

from benchmarks.process import say

CASES = {  # equation: loop, gain set, optimizers
    "6.2": ("altitude", "unaware", ("particle-swarm",)),
    "6.3": ("altitude", "aware", ("particle-swarm",)),
    "6.4": ("attitude", "unaware", ("levenberg-marquardt", "particle-swarm")),
    "6.5": ("attitude", "aware", ("levenberg-marquardt", "particle-swarm")),
}


def flown(lipoid):
    """The aware altitude gains, printed and found, on a cell instead of a voltage that stays."""
    file = lipoid.scratch / "altitude-aware.json"
    find = ["design", "altitude", "--aware", "--optimizer", "levenberg-marquardt", "--check",
            "never", "-o", file]
    found = lipoid.summary(*find)
    rows = []
    for name, gains in (("printed", "aware"), ("found", file)):
        fly = ["fly", "altitude-steps", "--vehicle", "mambo-physical", "--gains", gains]
        summary = lipoid.summary(*fly)
        rows.append({"gains": name, "command": lipoid.shown(*fly),
                     "mse_altitude_m2": summary["mse_altitude_m2"],
                     "peaks_m": summary["peak_altitude_error_m"]})
    return {"command": lipoid.shown(*find), "gains": found["gains"], "rows": rows}


def measure(lipoid):
    return [design(lipoid, equation, loop, gains, optimizer)
            for equation, (loop, gains, optimizers) in CASES.items() for optimizer in optimizers]


def design(lipoid, equation, loop, gains, optimizer):
    say(f"design ({equation}) by {optimizer}")
    words = ["design", loop, *(["--aware"] if gains == "aware" else []), "--optimizer", optimizer,
             "--check", "always"]
    found = lipoid.summary(*words, expected=(0, 1))
    return {
        "equation": equation, "loop": loop, "printed_set": gains, "optimizer": optimizer,
        "command": lipoid.shown(*words),
        "printed": found["start"],
        **found["search"],
        **{key: found[key] for key in ("bounds", "polished_cost", "evaluations", "termination",
                                       "message", "wall_s")},
        "longer_run": found["longer_run"],
    }
