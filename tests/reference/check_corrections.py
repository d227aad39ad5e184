#!/usr/bin/python3
"""Shows by numbers which of a printed equation and its correction holds (docs/corrections.md).

    check_corrections.py [NAME ...]

Every function below is one check: it computes the truth by a way that shares nothing with the
equation in question (the diffusion equation itself on a grid, a quadrature, a sum of 10^5 terms),
requires the corrected form to agree with it and the printed form not to, and returns a sentence
with the numbers.
"""

import math
import pathlib
import sys

import numpy as np
from scipy.integrate import quad
from scipy.linalg import solve_banded
from scipy.signal import lfilter

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import quadrotor_corrections  # noqa: E402
import reference_cell  # noqa: E402

PI = math.pi


def require(condition, text):
    if not condition:
        raise AssertionError(text)


def sigma_under_constant_current(beta, t, current=1.0, terms=100_000, first=1):
    """(4.38), integrated by hand under the sum."""
    k = np.arange(max(first, 1), terms + 1, dtype=float)
    rest = 2.0 * np.sum(-np.expm1(-beta**2 * k**2 * t) / (beta**2 * k**2))
    if first == 0:
        rest += 2.0 * t  # the integral of e^0
    return current * (t + rest)


def fick(beta, current, t, cells=800, steps=4000):
    """sigma(t) from the diffusion equation dC/dt = D d²C/dx² on a grid, with w = 1, n F S C* w = 1,
    D = (beta/pi)².

    Finite volumes, Crank-Nicolson; the flux D dC/dx = i at x = 0 and none at x = w.
    sigma = 1 - C(0)/C*, where the value at the wall follows from the first two cells and the known
    slope there (second order)."""
    d = (beta / PI) ** 2
    h, dt = 1.0 / cells, t / steps
    r = d * dt / (2.0 * h * h)
    main = np.full(cells, 1.0 + 2.0 * r)
    main[[0, -1]] = 1.0 + r
    band = np.zeros((3, cells))
    band[0, 1:], band[1], band[2, :-1] = -r, main, -r
    c = np.ones(cells)
    for _ in range(steps):
        right = c.copy()
        right[1:-1] += r * (c[2:] - 2.0 * c[1:-1] + c[:-2])
        right[0] += r * (c[1] - c[0]) - dt * current / h
        right[-1] += r * (c[-2] - c[-1])
        c = solve_banded((1, 1), band, right)
    # c(x) = a + s x + q x² with the slope s = i/D given and the means of the first two cells.
    s = current / d
    q = (c[1] - c[0] - s * h) / (2.0 * h * h)
    a = c[0] - s * h / 2.0 - q * h * h / 3.0
    return 1.0 - a


def fick_second_law():
    """(4.5), (4.37)-(4.39): the sum starts at k = 1, its kernel is e^{-beta² k² (t - tau)}."""
    beta, t, current = 0.2, 60.0, 1e-3
    grid = fick(beta, current, t)
    right = sigma_under_constant_current(beta, t, current)
    twice = sigma_under_constant_current(beta, t, current, first=0)
    require(abs(grid - right) < 1e-5 * right, f"{grid} {right}")
    require(abs(grid - twice) > 0.3 * right, f"{grid} {twice}")
    return (f"the diffusion equation on a grid gives sigma = {grid:.6f}, "
            f"the sum from k = 1 {right:.6f}, from k = 0 {twice:.6f}")


def theta_identity():
    """(4.31), (4.32): the exponent has pi²."""
    y = 2.7  # w²/(D (t - tau))
    left = sum(math.exp(-y * k * k) for k in range(-50, 51))
    right = math.sqrt(PI / y) * sum(math.exp(-PI**2 * k * k / y) for k in range(-50, 51))
    printed = math.sqrt(PI / y) * sum(math.exp(-PI * k * k / y) for k in range(-50, 51))
    require(abs(left - right) < 1e-14 and abs(left - printed) > 0.1, f"{left} {right} {printed}")
    return f"sum e^(-y k²) = {left:.6f}; with pi² {right:.6f}, with pi {printed:.6f}"


def steady_unavailable_charge():
    """(4.40), (4.53): pi²/(3 beta²), not pi³/(3 beta²)."""
    beta = 0.2
    held = sigma_under_constant_current(beta, 1e4) - 1e4
    # 10^5 terms leave out 2/(beta² 10^5).
    require(abs(held - PI**2 / (3 * beta**2)) < 3.0 / (beta**2 * 1e5), f"{held}")
    require(abs(held - PI**3 / (3 * beta**2)) > 100.0, f"{held}")
    return (f"held back per ampere in the long run: {held:.3f} s; "
            f"pi²/(3 beta²) = {PI**2 / 3 / beta**2:.3f} s, "
            f"pi³/(3 beta²) = {PI**3 / 3 / beta**2:.3f} s")


def finite_time():
    """(4.40) is the limit of (4.37) for beta² L >> 1."""
    lines = []
    for x, low, high in ((50.0, -1e-9, 1e-9), (5.0, 1e-3, 1e-2), (0.5, 0.2, 0.8)):  # beta² L
        beta = 0.1
        t = x / beta**2
        exact = sigma_under_constant_current(beta, t) + 2.0 / (beta**2 * 100_000.5)
        limit = t + PI**2 / (3 * beta**2)
        error = limit / exact - 1.0
        require(low < error < high, f"{x} {error}")
        lines.append(f"{100 * error:.2g} % at beta² L = {x:g}")
    return "the alpha of (4.40) is too large by " + ", ".join(lines)


def truncation():
    """(4.41): ten terms lose 5.8 % of the steady unavailable charge."""
    lost = 100.0 * (PI**2 / 6 - sum(1.0 / k**2 for k in range(1, 11))) / (PI**2 / 6)
    require(abs(lost - 5.785) < 0.001, f"{lost}")
    return f"{lost:.3f} % lost at M = 10"


def discrete_time():
    """(4.46), (4.47), (4.50) as printed are exact for a current held between the samples."""
    beta, alpha, r, tau, ts = 0.2, 1353.6, 0.03, 45.0, 10.0
    current = np.array([3.0, 0.0, -1.0, 2.0, 2.0, 0.5, 0.0])
    t = ts * np.arange(len(current))
    cell = {"diffusion": {"alpha_C": alpha, "beta_per_sqrt_s": beta, "terms": 10, "tail": False},
            "open_circuit_voltage": {"method": "linear", "soc": [0, 1], "voltage_V": [0, 1]},
            "series_resistance_Ohm": 0.0,
            "branches": [{"resistance_Ohm": r, "time_constant_s": tau}]}
    ours = reference_cell.predict(cell, t, current, hold="forward")
    worst = 0.0
    for row in range(1, len(t)):
        sigma = drop = 0.0
        for k in range(row):  # quadrature of (4.38) and of the solution of (4.44)
            a, b = t[k], t[k + 1]
            sigma += current[k] * (b - a)
            for m in range(1, 11):
                rate = (beta * m) ** 2
                sigma += 2.0 * current[k] * quad(lambda s: math.exp(-rate * (t[row] - s)), a, b)[0]
            drop += current[k] * r / tau * quad(lambda s: math.exp(-(t[row] - s) / tau), a, b)[0]
        worst = max(worst, abs(ours["voltage_V"][row] - (1.0 - sigma / alpha - drop)))
    require(worst < 2e-12, f"{worst}")
    return f"largest difference to the quadrature of (4.38) and (4.44): {worst:.1e} V"


def transfer_functions():
    """(4.52): t_s is missing, and the numerators belong to another hold."""
    beta, m, ts, r, c = 0.2, 3, 0.01, 0.03, 1500.0
    current = np.ones(2001)
    t = ts * (len(current) - 1)
    b2 = beta**2 * m**2
    p, q = math.exp(-b2 * ts), math.exp(-ts / (r * c))
    truth_u, truth_v = -math.expm1(-b2 * t) / b2, -r * math.expm1(-t / (r * c))
    right_u = lfilter([0.0, (1 - p) / b2], [1.0, -p], current)[-1]
    right_v = lfilter([0.0, r * (1 - q)], [1.0, -q], current)[-1]
    right_d = lfilter([0.0, ts], [1.0, -1.0], current)[-1]
    printed_u = lfilter([1.0], [1.0, -math.exp(-b2)], current)[-1]
    printed_d = lfilter([1.0], [1.0, -1.0], current)[-1]
    printed_v = lfilter([1.0 / c], [1.0, -math.exp(-1.0 / (r * c))], current)[-1]
    for right, truth in ((right_u, truth_u), (right_v, truth_v), (right_d, t)):
        require(abs(right - truth) < 1e-9 * truth, f"{right} {truth}")
    for printed, truth in ((printed_u, truth_u), (printed_v, truth_v), (printed_d, t)):
        require(abs(printed - truth) > 0.1 * truth, f"{printed} {truth}")
    return (f"after {t:g} s at 1 A: delivered {right_d:.3f} C (printed {printed_d:.0f}), "
            f"sigma_u3 {right_u:.4f} C (printed {printed_u:.4f}), "
            f"v_c {right_v:.5f} V (printed {printed_v:.5f})")


def tables():
    """Tables 4.12, 4.13: alpha of a 600 mAh cell. Tables 4.8-4.13: no branch was identified."""
    nominal = 0.6 * 3600.0
    require(0.5 < 1.3555e3 / nominal < 1.0 and 1.3555e5 / nominal > 50.0, "")
    drop = 5.0 * 2.3643e-5
    require(drop < 1e-3 * 0.1314 * 5.0, "")
    return (f"1.3555e3 C is {1.3555e3 / nominal:.2f} of 600 mAh, 1.3555e5 C is "
            f"{1.3555e5 / nominal:.0f} times as much; the branch of Table 4.11 drops "
            f"{1e3 * drop:.2f} mV at 5 A, r_s {1e3 * 5 * 0.1314:.0f} mV")


def percent():
    """(4.59): the factor 100 of (4.42) is missing; here A is a fraction everywhere."""
    alpha, sigma = 1353.6, 338.4
    require(100.0 * (alpha - sigma) / alpha == 75.0, "")
    return "three quarters left are 75 % by (4.42) and 0.75 % by (4.59)"


def gauge():
    """alpha is a gauge: scaled together with the axis of v_oc(A) it changes no voltage."""
    rng = np.random.default_rng(1)
    t = np.cumsum(rng.uniform(0.1, 20.0, 300))
    current = rng.uniform(-1.0, 2.0, 300)
    soc, voltage = np.array([0.0, 0.1, 0.5, 1.0]), [3.0, 3.6, 3.8, 4.2]
    out = []
    for scale in (1.0, 1.1):
        cell = {"diffusion": {"alpha_C": 5000.0 * scale, "beta_per_sqrt_s": 0.2,
                              "terms": 10, "tail": True},
                "open_circuit_voltage": {"method": "linear", "soc": list(1 - (1 - soc) / scale),
                                         "voltage_V": voltage},
                "series_resistance_Ohm": 0.1, "branches": []}
        out.append(reference_cell.predict(cell, t, current)["voltage_V"])
    worst = np.max(np.abs(out[0] - out[1]))
    require(worst < 1e-13 and np.ptp(out[0]) > 0.1, f"{worst}")
    return f"alpha 10 % larger, axis rescaled: voltages differ by {worst:.0e} V"


CHECKS = (fick_second_law, theta_identity, steady_unavailable_charge, finite_time, truncation,
          discrete_time, transfer_functions, tables, percent, gauge) + quadrotor_corrections.CHECKS


def main(names):
    known = {check.__name__: check for check in CHECKS}
    for name in names:
        if name not in known:
            print(f"no check '{name}'; there are {', '.join(known)}", file=sys.stderr)
            return 2
    failed = 0
    for name in names or known:
        try:
            print(f"{name}: {known[name]()}")
        except AssertionError as error:
            failed = 1
            print(f"{name}: FAILED: {known[name].__doc__} {error}", file=sys.stderr)
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
