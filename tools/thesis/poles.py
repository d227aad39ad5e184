"""Closed-loop poles against xi: Figs 6.12, 6.14, 6.16 and 6.19."""

import cmath
import json
import math
import statistics

from .lipoid import xis

RANGE = "0.8:0.01:1"
FIGURES = {("altitude", "unaware"): "6.12", ("altitude", "aware"): "6.16",
           ("attitude", "unaware"): "6.14", ("attitude", "aware"): "6.19"}
# Section 6.3.1 in the order in which it is printed: K_e, K_I, K_edot.
PRINTED_ORDER = {
    "schema": "lipoid.gains/1",
    "name": "aware, as printed",
    "altitude": {"proportional": 5.03, "integral": 7.87, "derivative": 1.36},
    "attitude": {"proportional": 0.99, "integral": 0.07, "derivative": 0.25},
}


def measure(lipoid):
    loops = [loop_of(lipoid, loop, gains) for loop, gains in FIGURES]
    file = lipoid.scratch / "printed-order.json"
    file.write_text(json.dumps(PRINTED_ORDER, indent=1) + "\n", encoding="utf-8")
    return {
        "loops": loops,
        "printed_order": {"gains_used": PRINTED_ORDER["altitude"],
                          **loop_of(lipoid, "altitude", "aware, as printed", file)},
        "attitude_unaware": margins(lipoid),
    }


def loop_of(lipoid, loop, gains, file=None):
    words = ["poles", loop, "--gains", file or gains, "--xi", RANGE]
    rows = lipoid.summary(*words)["rows"]
    return {
        "figure": FIGURES.get((loop, gains)),
        "loop": loop,
        "gains": gains,
        "command": lipoid.shown(*words),
        "largest_difference_of_two_ways": max(
            distance(row["poles"], row["poles_quasistatic"]) for row in rows),
        "rows": [{"xi": round(row["xi"], 6), "kappa": row["kappa"],
                  "poles": row["poles"], "poles_full": row["poles_full"]} for row in rows],
    }


def distance(some, others):
    return max(abs(complex(*a) - complex(*b)) for a, b in zip(some, others))


def margins(lipoid):
    """From which xi on the unaware attitude gains are unstable: by the poles, and in flight."""
    words = ["poles", "attitude", "--gains", "unaware", "--xi", "0.8:0.001:0.9"]
    rows = lipoid.summary(*words)["rows"]
    unstable = [round(row["xi"], 6) for row in rows if row["poles_full"][0][0] >= 0.0]
    growth = [growth_in_flight(lipoid, xi) for xi in xis(0.8, 0.9, 0.02)]
    return {
        "command": lipoid.shown(*words),
        "unstable_up_to_xi": max(unstable) if unstable else None,
        "flight_command": lipoid.shown(*flight(lipoid_xi="XI")),
        "flights": growth,
        "unstable_in_flight_below_xi": crossing(growth),
    }


# One doublet, and what it leaves: a maneuver lasts as long as its flight. Pulse widths of whole
# counts (6.1) kick the loop now and then, by as much as a weak pair grows in a minute.
def flight(lipoid_xi):
    return ["fly", "attitude-doublets", "--battery", "ideal", "--xi", lipoid_xi, "--gains",
            "unaware", "--duration", 150, "--set", "attitude-doublets.every_s=1000", "--set",
            "controller.pwm=continuous"]


# The doublet ends before 8 s, and the slow real pole has died out seventy seconds later.
SWINGING_S = 80.0


def growth_in_flight(lipoid, xi):
    """The real part of the pair that swings on: the slope of the logarithm of its peaks."""
    _, log = lipoid.log(*flight(xi), step_s=0.05)
    error = [abs(a - b) for a, b in zip(log["pitch_reference_rad"], log["pitch_rad"])]
    peaks = [(time, math.log(here)) for time, before, here, after
             in zip(log["time_s"][1:], error, error[1:], error[2:])
             if time > SWINGING_S and before < here >= after]
    return {"xi": xi, "rate_per_s": statistics.linear_regression(*zip(*peaks)).slope}


def crossing(rows):
    """Where the rate falls through zero as xi grows, by a straight line."""
    for a, b in zip(rows, rows[1:]):
        if a["rate_per_s"] >= 0.0 > b["rate_per_s"]:
            share = a["rate_per_s"] / (a["rate_per_s"] - b["rate_per_s"])
            return a["xi"] + share * (b["xi"] - a["xi"])
    return None


def damping(pole):
    """Of a pole (re, im): 1 without oscillation, 0 at the edge of stability."""
    return -math.cos(cmath.phase(complex(*pole)))
