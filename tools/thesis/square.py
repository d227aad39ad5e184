"""The square by a slow and a fast attitude reference: section 6.7."""

import math
import statistics

from benchmarks.process import ROOT

VEHICLES = ("mambo-coupled", "mambo-physical")
OMEGAS = (100, 200)
SEEDS = range(1, 11)
# Times the noise of the optical flow that is the default.
FLOW_NOISE_M_PER_S = (0.02, 0.01)
KEYS = ("mse_altitude_m2", "mse_pitch_deg2", "charge_C")


def measure(lipoid):
    return {
        "true_state": [true_state(lipoid, vehicle, omega)
                       for vehicle in VEHICLES for omega in OMEGAS],
        "estimated": [estimated(lipoid, vehicle, noise)
                      for vehicle in VEHICLES for noise in FLOW_NOISE_M_PER_S],
        "causes": causes(lipoid),
    }


def words(vehicle, omega):
    return ["fly", "square", "--cell", "gifi-600mAh-1", "--vehicle", vehicle, "--gains", "aware",
            "--set", f"controller.attitude_omega_rad_per_s={omega}"]


def true_state(lipoid, vehicle, omega):
    summary = lipoid.summary(*words(vehicle, omega))
    return {"vehicle": vehicle, "omega_rad_per_s": omega,
            "command": lipoid.shown(*words(vehicle, omega)), **{key: summary[key] for key in KEYS}}


def estimated(lipoid, vehicle, noise):
    def command(omega, seed):
        return [*words(vehicle, omega), "--estimate", "--set",
                f"sensors.flow_noise_m_per_s={noise}", "--seed", seed]

    flights = {omega: [lipoid.summary(*command(omega, seed), expected=(0, 1)) for seed in SEEDS]
               for omega in OMEGAS}
    whole = [k for k in range(len(SEEDS))
             if all(flights[omega][k]["outcome"] == "completed" for omega in OMEGAS)]
    return {
        "vehicle": vehicle,
        "flow_noise_m_per_s": noise,
        "command": lipoid.shown(*command("OMEGA", "SEED")),
        "seeds": list(SEEDS),
        "rows": [{
            "omega_rad_per_s": omega,
            "completed": sum(row["outcome"] == "completed" for row in flights[omega]),
            **{key: spread([row[key] for row in flights[omega] if row["outcome"] == "completed"])
               for key in KEYS},
        } for omega in OMEGAS],
        # The same seed gives both the same noise.
        "fast_minus_slow": {
            "pairs": len(whole),
            **{key: spread([flights[OMEGAS[1]][k][key] - flights[OMEGAS[0]][k][key]
                            for k in whole]) for key in KEYS},
        },
    }


def causes(lipoid):
    """Why the fast reference loses flights with sensors: the same with one thing changed. On an
    ideal source, where alone motors can be without lag."""
    file = lipoid.scratch / "light-about-z.toml"
    text = (ROOT / "fixtures/vehicles/mambo-physical.toml").read_text(encoding="utf-8")
    file.write_text(text.replace("1e-4]", "2e-5]", 1).replace("mambo-physical", "light-about-z", 1),
                    encoding="utf-8")
    return [cause(lipoid, "nothing", "mambo-physical"),
            cause(lipoid, "no motor lag", "mambo-physical", "--set", "simulation.motor_lag=false"),
            cause(lipoid, "a fifth of the inertia about z", file)]


def cause(lipoid, changed, vehicle, *extra):
    def command(seed):
        return ["fly", "square", "--battery", "ideal", "--vehicle", vehicle, "--gains", "aware",
                "--set", f"controller.attitude_omega_rad_per_s={OMEGAS[1]}", "--estimate", *extra,
                "--seed", seed]

    outcomes = [lipoid.summary(*command(seed), expected=(0, 1))["outcome"] for seed in SEEDS]
    return {"changed": changed, "command": lipoid.shown(*command("SEED")), "seeds": len(SEEDS),
            "completed": outcomes.count("completed")}


def spread(values):
    """Mean, standard deviation, and standard error of the mean; None where there are too few."""
    if len(values) < 2:
        return None
    deviation = statistics.stdev(values)
    return {"mean": statistics.fmean(values), "deviation": deviation,
            "error_of_mean": deviation / math.sqrt(len(values))}
