"""Errors as the voltage falls: altitude (Figs 6.13, 6.17) and pitch (Figs 6.15, 6.18)."""

from .lipoid import between, xis

CURVES_XI = (0.8, 0.85, 0.9, 0.95, 1.0)
GAINS = ("unaware", "aware")
DEGREES_PER_RADIAN = 57.29577951308232

ALTITUDE = {
    "maneuver": "altitude-steps",
    "figures": {"unaware": "6.13", "aware": "6.17"},
    "models": {
        "quasi-static": ["--set", "simulation.motor_lag=false", "--set",
                         "controller.saturate=false"],
        "with lag and clipping": [],
    },
    "span_s": (12.5, 17.5),
    "step_s": 0.05,
}
ATTITUDE = {
    "maneuver": "attitude-doublets",
    "figures": {"unaware": "6.15", "aware": "6.18"},
    "models": {
        "quasi-static": ["--set", "simulation.motor_lag=false"],
        "with lag": [],
    },
    "span_s": (5.0, 9.5),
    "step_s": 0.025,
}


def altitude(lipoid):
    return [series(lipoid, ALTITUDE, gains, model, altitude_row, altitude_error)
            for gains in GAINS for model in ALTITUDE["models"]]


def attitude(lipoid):
    return [series(lipoid, ATTITUDE, gains, model, attitude_row, pitch_error)
            for gains in GAINS for model in ATTITUDE["models"]]


def series(lipoid, task, gains, model, row_of, error_of):
    def words(xi):
        return ["fly", task["maneuver"], "--battery", "ideal", "--xi", xi, "--gains", gains,
                *task["models"][model]]

    rows = [{"xi": xi, **row_of(lipoid.summary(*words(xi)))} for xi in xis()]
    curves = []
    for xi in CURVES_XI:
        _, log = lipoid.log(*words(xi), step_s=task["step_s"])
        span = between(log["time_s"], *task["span_s"])
        curves.append({"xi": xi, "error": [round(error_of(log, k), 6) for k in span]})
    return {
        "figure": task["figures"][gains],
        "gains": gains,
        "model": model,
        "command": lipoid.shown(*words("XI")),
        "rows": rows,
        "from_s": task["span_s"][0],
        "step_s": task["step_s"],
        "curves": curves,
    }


def altitude_row(summary):
    peaks = summary["peak_altitude_error_m"]
    return {
        "peak_m": peaks[0],
        "largest_peak_m": max(peaks),
        "mse_altitude_m2": summary["mse_altitude_m2"],
        "hover_duty": summary["trim"]["duty"],
        "saturated_share": summary["saturated_share"],
    }


def attitude_row(summary):
    return {
        "mse_pitch_deg2": summary["mse_pitch_deg2"],
        "mse_altitude_m2": summary["mse_altitude_m2"],
        "saturated_share": summary["saturated_share"],
    }


def altitude_error(log, k):
    return log["altitude_reference_m"][k] - log["altitude_m"][k]


def pitch_error(log, k):
    return DEGREES_PER_RADIAN * (log["pitch_reference_rad"][k] - log["pitch_rad"][k])
