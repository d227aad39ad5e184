"""Commands from the nominal and from the measured voltage: Figs 6.20 to 6.22."""

from .lipoid import between
from .transients import altitude_error

VEHICLES = ("mambo-coupled", "mambo-physical")
LOG_STEP_S = 0.005
EVERY = 20  # of the log's rows, for the drawing
SWINGS_S = (48.0, 50.0)
KEYS = ("charge_C", "minimum_voltage_V", "final_soc", "mse_altitude_m2", "saturated_share")


def measure(lipoid):
    return [flight(lipoid, maneuver, vehicle, compensate)
            for maneuver in ("altitude-steps", "hover")
            for vehicle in VEHICLES
            for compensate in (False, True)]


def flight(lipoid, maneuver, vehicle, compensate):
    words = ["fly", maneuver, "--cell", "gifi-600mAh-1", "--vehicle", vehicle, "--gains", "aware",
             *(["--compensate"] if compensate else [])]
    summary, log = lipoid.log(*words, step_s=LOG_STEP_S)
    # The voltage of one step is that of one pulse width, up or down: a mean over many.
    late = between(log["time_s"], *SWINGS_S)
    result = {
        "maneuver": maneuver,
        "vehicle": vehicle,
        "compensated": compensate,
        "command": lipoid.shown(*words),
        "peaks_m": summary["peak_altitude_error_m"],
        **{key: summary[key] for key in KEYS},
        "mean_voltage_at_the_end_V": sum(log["battery_V"][k] for k in late) / len(late),
    }
    if maneuver == "altitude-steps":
        rows = range(0, len(log["time_s"]), EVERY)
        result["step_s"] = EVERY * LOG_STEP_S
        result["curves"] = {
            "error_m": [round(abs(altitude_error(log, k)), 6) for k in rows],
            "battery_V": [round(log["battery_V"][k], 5) for k in rows],
        }
    return result
