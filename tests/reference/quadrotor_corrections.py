"""Checks of the corrections to chapters 3, 5 and 6, run by check_corrections.py.

Each goes back to what the equation in question was derived from: the rotation matrix, Euler's
equation, the balance of one motor, eigenvalues of the loop that a sign closes.
"""

import math

import numpy as np
from scipy.optimize import brentq

G = 9.81
MASS, K_T, K_N = 0.063, 3.9865e-8, 9.6223e-11
K_E, R_A, B = 7.4041e-4, 0.49, 1e-6
INERTIA = np.diag([5.82857e-5, 7.16914e-5, 1e-4])
GAMMA = (K_E**2 + R_A * B) / (R_A * K_N)
HOVER = math.sqrt(MASS * G / (4.0 * K_T))


def require(condition, text):
    if not condition:
        raise AssertionError(text)


def rotation(rho):
    (sx, sy, sz), (cx, cy, cz) = np.sin(rho), np.cos(rho)
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x


def s_matrix(rho):
    s, c, t = math.sin(rho[0]), math.cos(rho[0]), math.tan(rho[1])
    sec = 1.0 / math.cos(rho[1])
    return np.array([[1, s * t, c * t], [0, c, -s], [0, s * sec, c * sec]])


def steady_speed(motor_V):
    """The speed at which a motor's torque is what friction and drag take, by (3.9) and (3.10)."""
    def surplus(w):
        return K_E * (motor_V - K_E * w) / R_A - B * w - K_N * w * w
    return brentq(surplus, 0.0, 1e5, xtol=1e-12, rtol=1e-15)


def holding_voltage(w):
    return R_A * (B * w + K_N * w * w) / K_E + K_E * w


def gyroscopic_term():
    """(3.49), (5.38): the gyroscopic torque is added; (5.41), (5.42): S' W, and minus."""
    rng = np.random.default_rng(3)
    worst_right, least_printed = 0.0, math.inf
    for _ in range(50):
        rho, omega = rng.uniform(-0.8, 0.8, 3), rng.uniform(-5.0, 5.0, 3)
        nu, xi = rng.uniform(-20.0, 20.0, 3), 0.85
        tau_xi = rng.uniform(-1e-3, 1e-3, 3)
        gyro = np.cross(omega, INERTIA @ omega)
        s = s_matrix(rho)

        def s_rate(h=1e-5):
            return (s_matrix(rho + h * s @ omega) - s_matrix(rho - h * s @ omega)) / (2.0 * h)

        def angle_acceleration(tau, h=1e-5):
            turn = np.linalg.solve(INERTIA, tau - gyro)  # Euler's equation
            ahead = s_matrix(rho + h * s @ omega) @ (omega + h * turn)
            behind = s_matrix(rho - h * s @ omega) @ (omega - h * turn)
            return (ahead - behind) / (2.0 * h)

        inner = INERTIA @ np.linalg.solve(s, nu - s_rate() @ omega)
        worst_right = max(worst_right, np.abs(angle_acceleration(inner + gyro) - nu).max())
        least_printed = min(least_printed, np.abs(angle_acceleration(inner - gyro) - nu).max())

        tau = xi * (inner + gyro) + tau_xi
        turn = np.linalg.solve(INERTIA, tau - gyro)
        truth = angle_acceleration(tau)
        worst_right = max(worst_right, np.abs(s_rate() @ omega + s @ turn - truth).max())
        least_printed = min(least_printed, np.abs(s_rate() @ turn + s @ turn - truth).max())
        drive = xi * nu + s @ np.linalg.solve(INERTIA, tau_xi)
        pull = s @ np.linalg.solve(INERTIA, gyro)
        right = drive + (1.0 - xi) * (s_rate() @ omega - pull)
        printed = drive + (1.0 - xi) * (s_rate() @ turn + pull)
        worst_right = max(worst_right, np.abs(right - truth).max())
        least_printed = min(least_printed, np.abs(printed - truth).max())
    require(worst_right < 1e-6 < 1e-2 < least_printed, f"{worst_right} {least_printed}")
    return (f"rho'' off by at most {worst_right:.0e} rad/s² as corrected, by "
            f"{least_printed:.2f} or more as printed")


def thrust_sign():
    """(3.54): thrust lifts, so G2 is positive and (3.58) follows."""
    rho, nu = np.array([0.3, -0.2, 1.0]), -1.0
    lean = math.cos(rho[0]) * math.cos(rho[1])
    for sign, right in ((1.0, True), (-1.0, False)):
        thrust = (G - nu) / (sign * lean / MASS)
        fall = (rotation(rho) @ [0, 0, -thrust / MASS] + [0, 0, G])[2]
        require((abs(fall - nu) < 1e-12) == right, f"{fall}")
    return "Z'' is what was asked for with +cos cos/m; as printed the motors would push down"


def reference_sign():
    """(3.59): as printed the reference model runs away."""
    w0, zeta = 5.0, 1.0
    right = np.linalg.eigvals([[0, 1], [-w0**2, -2 * zeta * w0]]).real.max()
    printed = np.linalg.eigvals([[0, 1], [w0**2, -2 * zeta * w0]]).real.max()
    require(right < 0.0 < printed, f"{right} {printed}")
    return f"largest real part of the poles: {right:.2f} 1/s, as printed {printed:+.2f}"


def position_signs():
    """(3.67), (3.68): roll takes the minus sign, pitch the plus."""
    def acceleration(roll, pitch):
        down = rotation([roll, pitch, 0.0])[:, 2]
        return -G * down / down[2]
    tiny = 1e-6
    per_pitch, per_roll = acceleration(0, tiny)[0] / tiny, acceleration(tiny, 0)[1] / tiny
    kp, kd = 0.3, 0.4

    def unstable(per_angle, error_sign, kp_sign, kd_sign):
        """error = error_sign * (position - reference)"""
        loop = [[0, 1], [per_angle * kp_sign * kp * error_sign, per_angle * kd_sign * kd]]
        return np.linalg.eigvals(loop).real.max() > 0.0
    require(not unstable(per_pitch, 1, 1, 1), "pitch")
    require(unstable(per_roll, 1, 1, 1) and unstable(per_roll, -1, 1, 1), "roll as printed")
    require(not unstable(per_roll, 1, -1, -1), "roll")
    return (f"X'' = {per_pitch:.2f} Theta, Y'' = {per_roll:+.2f} Phi: the printed roll law is "
            "unstable whichever way its error is counted")


def steady_motor():
    """(5.27): gamma w_C belongs under 4 xi (...), as in (5.10); (5.56) is linear only at Xi = 1."""
    xi, commanded = 0.8, 1.15 * HOVER
    truth = steady_speed(xi * holding_voltage(commanded))
    right = 0.5 * (-GAMMA + math.sqrt(GAMMA**2 + 4 * xi * (commanded**2 + GAMMA * commanded)))
    printed = 0.5 * (-GAMMA + math.sqrt(GAMMA**2 + 4 * xi * commanded**2 + GAMMA * commanded))
    linear = xi * commanded
    require(abs(right - truth) < 1e-6, f"{right} {truth}")
    require(abs(printed - truth) > 100.0 and abs(linear - truth) > 10.0, f"{printed} {linear}")
    return (f"{commanded:.0f} rad/s commanded at xi = 0.8 become {truth:.1f}; (5.27) as printed "
            f"gives {printed:.1f}, (5.56) {linear:.1f}")


def small_signals():
    """(5.28)-(5.31), (5.48): a small command comes out kappa(xi) times as large."""
    def kappa(xi):
        commanded = 0.5 * (-GAMMA + math.sqrt(GAMMA**2 + 4 * (HOVER**2 + GAMMA * HOVER) / xi))
        return xi * HOVER * (2 * commanded + GAMMA) / (commanded * (2 * HOVER + GAMMA)), commanded

    texts = []
    for xi in (1.0, 0.9, 0.8):
        right, commanded = kappa(xi)
        u0 = 4 * K_T * commanded**2 / MASS
        require(abs(4 * K_T * steady_speed(xi * holding_voltage(commanded))**2 - MASS * G) < 1e-9, "")

        def lift(u):
            """T/m of equal motors told to give u."""
            w = steady_speed(xi * holding_voltage(math.sqrt(MASS * u / (4 * K_T))))
            return 4 * K_T * w * w / MASS
        h = 1e-3
        truth = (lift(u0 + h) - lift(u0 - h)) / (2 * h)

        def roll(torque):
            """Of two motors faster and two slower; arm 1 m."""
            total = 0.0
            for sign in (1, -1):
                square = commanded**2 + sign * torque / (4 * K_T)
                total += 2 * sign * K_T * steady_speed(xi * holding_voltage(math.sqrt(square)))**2
            return total
        turned = roll(1e-3) / 1e-3
        # (5.28) over K_I as printed, at the equilibrium of this xi: g - K_I eps = u0.
        root = math.sqrt(u0 / (4 * K_T))
        printed = (4 * GAMMA * K_T * xi * (MASS / (4 * K_T) + GAMMA / (8 * K_T * root))
                   / (MASS * math.sqrt(4 * xi * (GAMMA * root + MASS * u0 / (4 * K_T)) + GAMMA**2))
                   - GAMMA * xi / (2 * math.sqrt(MASS * u0 / (4 * K_T))) - xi)
        require(abs(right - truth) < 1e-7, f"{right} {truth}")
        require(abs(right - turned) < 1e-6, f"{right} {turned}")
        require(abs(abs(printed) - truth) > 0.1, f"{printed}")
        require(xi == 1.0 or abs(truth - xi) > 0.01, "")
        texts.append(f"xi = {xi:g}: {truth:.4f} (printed {printed:+.3f})")
    return "; ".join(texts)


def compensation_current():
    """(5.60), (5.61): more current for equal commands, the same at equal thrust."""
    battery_V, nominal_V = 3.6, 4.2

    def battery_current(w):
        return 4 * holding_voltage(w) / battery_V * (B * w + K_N * w * w) / K_E
    plain = steady_speed(battery_V / nominal_V * holding_voltage(HOVER))
    require(battery_current(HOVER) > 1.1 * battery_current(plain), "")
    # Without compensation the loop commands more until the thrust is the weight again.
    commanded = brentq(lambda w: steady_speed(battery_V / nominal_V * holding_voltage(w)) - HOVER,
                       HOVER, 2 * HOVER)
    duty = holding_voltage(commanded) / nominal_V
    same = 4 * duty * (B * HOVER + K_N * HOVER**2) / K_E
    require(abs(same / battery_current(HOVER) - 1.0) < 1e-9, f"{same}")
    return (f"{battery_current(HOVER):.2f} A against {battery_current(plain):.2f} A for the same "
            f"commands; {same:.2f} A either way once both hover")


def table_of_parameters():
    """Table 6.1: k_T, k_N, J and b."""
    radius, density = 0.033, 1.184
    area = math.pi * radius**2
    k_t = 0.0107 * area * radius**2
    k_n = 7.82634e-4 * area * radius**3
    require(abs(k_t / 3.9865e-8 - 1) < 1e-4 and abs(density * k_t / 4.720e-8 - 1) < 1e-4, f"{k_t}")
    require(abs(k_n / 9.6223e-11 - 1) < 1e-4, f"{k_n}")
    require(abs(density * k_n / 1.1393e-10 - 1) < 1e-4, "")
    printed = (5e-4, 7e-4, 1e-4)
    require(printed[1] > printed[0] + printed[2], "")
    body = np.diag(INERTIA)
    require(all(2 * j < sum(body) for j in body), "")
    hover_printed = math.sqrt(MASS * G / (4 * 7.4041e-4))
    # The most that 4.2 V behind the r_s of Table 4.11 can give, and what hover takes.
    power = 4 * holding_voltage(HOVER) * (B * HOVER + K_N * HOVER**2) / K_E
    most = 4.2**2 / (4 * 0.1314)
    require(power > most, f"{power} {most}")
    excess = printed[1] - printed[0] - printed[2]
    return (f"k_T as printed hovers at {hover_printed:.0f} rad/s, corrected at {HOVER:.0f}; J_y "
            f"exceeds J_x + J_z by {excess:.0e} kg m²; with b = 1e-6 hover takes {power:.0f} W of at "
            f"most {most:.0f} W")


def gain_order():
    """Section 6.3.1: K_I and K_edot are printed in each other's place."""
    def slowest(k_e, k_i, k_edot):
        return np.roots([1.0, k_edot, k_e, k_i]).real.max()
    right, printed = slowest(5.03, 1.36, 7.87), slowest(5.03, 7.87, 1.36)
    require(right < 0.0 < printed, f"{right} {printed}")
    return f"slowest pole at xi = 1: {right:.2f} 1/s; as printed {printed:+.2f}"


CHECKS = (gyroscopic_term, thrust_sign, reference_sign, position_signs, steady_motor, small_signals,
          compensation_current, table_of_parameters, gain_order)
