"""What losses of the speed controllers do to compensation: section 7.2's first open question."""

from benchmarks.process import ROOT

from .compensation import KEYS, VEHICLES

# Of one motor: a small transistor that switches to ground, and a diode across the motor.
CONTROLLERS = {
    "none": {},
    "typical": {"esc_resistance_Ohm": 0.03, "esc_switching_time_s": 1e-7,
                "esc_switching_frequency_Hz": 20e3, "esc_rectification": "diode",
                "esc_diode_V": 0.35},
    "poor": {"esc_resistance_Ohm": 0.06, "esc_switching_time_s": 2e-7,
             "esc_switching_frequency_Hz": 40e3, "esc_rectification": "diode",
             "esc_diode_V": 0.7},
}


def measure(lipoid):
    return [flight(lipoid, maneuver, vehicle, name, compensate)
            for vehicle in VEHICLES
            for name in CONTROLLERS
            for maneuver in ("altitude-steps", "hover")
            for compensate in (False, True)]


def vehicle_file(lipoid, vehicle, name):
    """A vehicle file with these controllers."""
    text = (ROOT / "fixtures/vehicles" / f"{vehicle}.toml").read_text(encoding="utf-8")
    keys = "".join(f'{key} = "{value}"\n' if isinstance(value, str) else f"{key} = {value}\n"
                   for key, value in CONTROLLERS[name].items())
    file = lipoid.scratch / f"{vehicle}-{name}.toml"
    file.write_text(keys + text, encoding="utf-8")
    return file


def flight(lipoid, maneuver, vehicle, name, compensate):
    words = ["fly", maneuver, "--cell", "gifi-600mAh-1",
             "--vehicle", vehicle_file(lipoid, vehicle, name), "--gains", "aware",
             *(["--compensate"] if compensate else [])]
    summary = lipoid.summary(*words)
    return {"maneuver": maneuver, "vehicle": vehicle, "controllers": name,
            "compensated": compensate, "command": lipoid.shown(*words),
            "peaks_m": summary["peak_altitude_error_m"], "current_A": summary["trim"]["battery_A"],
            **{key: summary[key] for key in KEYS}}
