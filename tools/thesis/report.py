"""docs/thesis-results.md from the JSON that tools/reproduce leaves: no figure is typed by hand."""

import json
import math
import textwrap

from benchmarks.report import code, number, table

from . import drawings, flights
from .poles import damping

WIDTH = 115

# What the thesis prints, with its section.
QUOTED = {
    "altitude unaware": "0.02 to 0.14 (6.2.1), up to 0.16 (6.3.1)",
    "altitude aware": "0 to 0.04 (6.3.1)",
    "square": {100: ("0.0185", "0.5336"), 200: ("0.0181", "0.4542")},
}


DRAWINGS = {
    "poles": drawings.poles,
    "altitude": lambda stage: drawings.transients(stage, "m"),
    "attitude": lambda stage: drawings.transients(stage, "degrees"),
    "compensation": drawings.compensation,
}


def files_of(file):
    """The text of every file that is made from the JSON, by its path."""
    result = json.loads(file.read_text(encoding="utf-8"))
    stages = result["stages"]
    made = {}
    parts = [head(result, file.name), summary(stages)]
    for name, section in SECTIONS.items():
        if name not in stages:
            continue
        parts.append(section(stages[name], stages))
        if name in DRAWINGS:
            drawing = file.with_name(f"{file.stem}_{name}.svg")
            made[drawing] = DRAWINGS[name](stages[name])
            parts.append(f"![{name}]({drawing.name})\n")
    made[file.with_suffix(".md")] = flow("\n".join(parts))
    return made


def flow(text):
    """Paragraphs and points filled to the width; tables, commands and headings as they are."""
    lines, open_paragraph = [], False
    for line in text.split("\n"):
        plain = line != "" and not line.startswith(("|", "    ", "#", "!"))
        if plain and open_paragraph and not line.startswith("* "):
            lines[-1] += " " + line.strip()
        else:
            lines.append(line)
        open_paragraph = plain
    return "\n".join(
        textwrap.fill(line, WIDTH, subsequent_indent="  " * line.startswith("* "),
                      break_long_words=False, break_on_hyphens=False)
        if not line.startswith(("|", "    ")) else line for line in lines)


def head(result, name):
    facts = result["machine"]
    commit = facts["commit"] + (" with changes" if facts["modified"] else "")
    return (
        "# The results of chapter 6, flown again\n\n"
        f"Made by `tools/reproduce --report` from [{name}]({name}), which `tools/reproduce` left: "
        "run both to have your own. Nothing is tuned to meet a quoted figure; where ours differs "
        "the text says why. Sections 6.5 to 6.7 of the thesis are experiments with a real "
        "vehicle: a simulation can show a trend of them, not their figures.\n\n"
        "`tools/reproduce --flights build/reproduce/flights` flies what the sections below compare "
        "and writes it as pages to replay in a browser, in three dimensions and with charts: "
        f"{', '.join(f'{page}.html' for page in flights.PAGES)}.\n\n"
        f"lipoid at commit {commit}, {facts['compiler']}, {facts['date']}.\n")


def summary(stages):
    rows = []
    for name, lines in SUMMARIES.items():
        if name in stages:
            rows += lines(stages[name])
    return "## In short\n\n" + table(["result", "thesis", "ours", "agrees"], rows)


def percent(value, digits=3):
    return f"{number(100.0 * value, digits)} %"


# Poles

def extremes(loop, key="poles"):
    """(slowest real pole, complex pair) at the lowest xi and at the highest."""
    ends = []
    for row in (loop["rows"][0], loop["rows"][-1]):
        real = [pole[0] for pole in row[key] if pole[1] == 0.0 and pole[0] > -30.0]
        pair = next(pole for pole in row[key] if pole[1] > 0.0)
        ends.append((real, pair))
    return ends


def pair_text(pole):
    return f"{number(pole[0], 3)} ± {number(pole[1], 3)}i"


def loop_of(stage, loop, gains):
    return next(row for row in stage["loops"] if (row["loop"], row["gains"]) == (loop, gains))


def poles_summary(stage):
    (low, low_pair), (high, high_pair) = extremes(loop_of(stage, "altitude", "unaware"))
    printed = stage["printed_order"]["rows"][-1]["poles"][0]
    attitude_low, attitude_high = extremes(loop_of(stage, "attitude", "unaware"), "poles_full")
    margins = stage["attitude_unaware"]
    return [
        ["unaware altitude poles, xi from 1 to 0.8 (Fig 6.12)",
         "real pole stays, pair moves to the origin",
         f"real pole {number(high[0], 3)} to {number(low[0], 3)}, pair {pair_text(high_pair)} to "
         f"{pair_text(low_pair)}", "yes"],
        ["aware altitude gains in the printed order (6.3.1)", "stable",
         f"unstable at xi = 1: {pair_text([printed[0], abs(printed[1])])}", "no: misprint"],
        ["unaware attitude poles (Fig 6.14)",
         "dominant real pole stays, leftmost real pole moves to the origin",
         f"real pole {number(attitude_high[0][0], 3)} to {number(attitude_low[0][0], 3)}; pair "
         f"{pair_text(attitude_high[1])} to {pair_text(attitude_low[1])}, unstable up to xi = "
         f"{margins['unstable_up_to_xi']}", "in part"],
    ]


def poles(stage, _):
    text = ("## Closed-loop poles against xi (Figs 6.12, 6.14, 6.16, 6.19)\n\n"
            "Three ways: the corrected closed form, automatic differentiation of the flight itself "
            "with the motors at their equilibrium, and the same with motor lag. The first two "
            f"differ by at most {worst_difference(stage):.1e} per second.\n\n")
    for loop in stage["loops"]:
        text += code(loop["command"])
    text += "\n" + table(
        ["loop, gains (figure)", "xi", "kappa", "quasi-static", "with motor lag",
         "damping of the pair, with lag"],
        [[f"{loop['loop']}, {loop['gains']} ({loop['figure']})", number(row["xi"], 2),
          number(row["kappa"], 4), poles_text(row["poles"]), poles_text(row["poles_full"]),
          number(pair_damping(row["poles_full"]), 3)]
         for loop in stage["loops"] for row in loop["rows"][::5]])
    aware = loop_of(stage, "altitude", "aware")
    lowest, highest = aware["rows"][0], aware["rows"][-1]
    text += (
        "\n* **Altitude, unaware.** As the thesis says: the real pole stays, the pair moves "
        "towards the origin and loses damping.\n"
        "* **Altitude, aware.** What moves with xi is the fast pole, from "
        f"{number(highest['poles'][-1][0], 3)} to {number(lowest['poles'][-1][0], 3)} per second; "
        "the dominant pair stays. This is why the response hardly changes.\n"
        "* **Attitude.** The picture is that of the altitude, because small "
        "signals see the same kappa(xi): the pair moves, the real poles stay. The thesis has a "
        "leftmost real pole that moves towards the origin; ours is the motors', near -55 per "
        "second, and hardly moves. Which blocks Simulink linearized is not printed.\n")
    return text + printed_order(stage["printed_order"]) + unstable(stage["attitude_unaware"])


def worst_difference(stage):
    return max(loop["largest_difference_of_two_ways"] for loop in stage["loops"])


def poles_text(some):
    words = []
    for real, imaginary in some:
        if imaginary > 0.0:
            words.append(pair_text([real, imaginary]))
        elif imaginary == 0.0:
            words.append(number(real, 3))
    return ", ".join(words)


def pair_damping(some):
    return damping(next(pole for pole in some if pole[1] > 0.0))


def printed_order(loop):
    gains = loop["gains_used"]
    first, last = loop["rows"][-1], loop["rows"][0]
    product = gains["derivative"] * gains["proportional"]
    return (
        "\n### The printed order of the aware altitude gains\n\n" + code(loop["command"]) + "\n"
        f"Section 6.3.1 prints [K_e K_I K_edot] = [{gains['proportional']} {gains['integral']} "
        f"{gains['derivative']}]. With the file holding just that the poles are "
        f"{poles_text(first['poles'])} at xi = 1 and {poles_text(last['poles'])} at xi = 0.8: "
        f"unstable throughout, as Routh's criterion says, K_edot K_e kappa = {number(product, 3)} "
        f"kappa < K_I = {gains['integral']}. The shipped set `aware` has the last two exchanged.\n")


def unstable(margins):
    rows = [[row["xi"], number(row["rate_per_s"], 3)] for row in margins["flights"]]
    return (
        "\n### The unaware attitude gains and motor lag\n\n" + code(margins["command"])
        + code(margins["flight_command"]) + "\n"
        "The closed form is stable for every xi, barely. With the motors' lag the pair crosses the "
        f"axis: unstable up to xi = {margins['unstable_up_to_xi']}. A flight also samples every "
        "5 ms, which costs a little more. Its real part, from the peaks of the oscillation that one "
        "doublet leaves where no rounding of pulse widths kicks it on:\n\n"
        + table(["xi", "real part in flight / s⁻¹"], rows)
        + f"\nIt changes sign near xi = {number(margins['unstable_in_flight_below_xi'], 3)}. The "
        "thesis saw no such instability: at xi = 0.8 the oscillation takes "
        f"{number(math.log(2.0) / margins['flights'][0]['rate_per_s'], 3)} s to double, "
        "and a flight 50 s.\n")


# Altitude and attitude errors

def series_of(stage, gains, model):
    return next(row for row in stage if (row["gains"], row["model"]) == (gains, model))


def altitude_summary(stage):
    rows = []
    for gains in ("unaware", "aware"):
        still = series_of(stage, gains, "quasi-static")["rows"]
        lag = series_of(stage, gains, "with lag and clipping")["rows"]
        rows.append([f"peak altitude error, {gains}, xi from 1 to 0.8 / m",
                     QUOTED[f"altitude {gains}"],
                     f"quasi-static {peaks(still, 'peak_m')}; with lag and clipping "
                     f"{peaks(lag, 'peak_m')}",
                     "quasi-static yes, with lag no" if still[0]["peak_m"] <= 0.04
                     else f"grows; quasi-static to {percent(still[0]['peak_m'] / 0.14, 2)}"])
    return rows


def peaks(rows, key):
    return f"{number(rows[-1][key], 2)} to {number(rows[0][key], 3)}"


def altitude(stage, _):
    text = "## Altitude errors (Figs 6.13, 6.17)\n\n"
    for series in stage:
        text += code(series["command"])
    rows = []
    for k in range(len(stage[0]["rows"]) - 1, -1, -4):
        rows.append([number(stage[0]["rows"][k]["xi"], 2),
                     number(stage[0]["rows"][k]["hover_duty"], 3),
                     *(number(series["rows"][k]["peak_m"], 3) for series in stage),
                     *(number(series["rows"][k]["largest_peak_m"], 3) for series in stage[1::2])])
    text += "\nPeak of the first step up, in metres (reference above altitude):\n\n" + table(
        ["xi", "hover duty", *(f"{series['gains']}, {series['model']}" for series in stage),
         *(f"{series['gains']}, largest of five" for series in stage[1::2])], rows)
    unaware = series_of(stage, "unaware", "quasi-static")["rows"]
    aware = series_of(stage, "aware", "quasi-static")["rows"]
    wanted = series_of(stage, "aware", "with lag and clipping")["rows"][0]
    text += (
        f"\nQuoted: {QUOTED['altitude unaware']} for unaware, {QUOTED['altitude aware']} for aware "
        "gains.\n\n"
        "* **Quasi-static** (no motor lag, duty not clipped) is what the thesis analyses. At "
        "xi = 1 the inversion is exact, and the reference holds its acceleration as the controller "
        f"its output: {number(unaware[-1]['peak_m'], 2)} m are left. At xi = 0.8 the unaware gains reach "
        f"{number(unaware[0]['peak_m'], 2)} m, {percent(unaware[0]['peak_m'] / 0.14, 2)} of the "
        "quoted 0.14 m, the aware ones "
        f"{number(aware[0]['peak_m'], 2)} m, within the quoted 0.04 m: "
        f"{number(unaware[0]['peak_m'] / aware[0]['peak_m'], 2)} times less.\n"
        "* **With lag and clipping** both are larger. mambo-thesis hovers at a duty of "
        f"{number(unaware[-1]['hover_duty'], 3)} at xi = 1 and "
        f"{number(unaware[0]['hover_duty'], 3)} at xi = 0.8; a step of 0.4 m with "
        "omega_0 = 5 asks for 10 m/s² at once, more than is "
        f"left: motors are at their limit in {percent(wanted['saturated_share'], 2)} of the steps "
        "at xi = 0.8.\n"
        "* The quoted 0.14 to 0.16 m lie between the two models: with lag and clipping ours reach "
        f"them at xi = {number(reaches(stage, 0.14), 3)}. How Fig 6.13 was simulated (lag, "
        "limits, which of the five steps) is not printed.\n")
    return text


def reaches(stage, peak_m):
    """The xi at which the unaware gains with lag have this peak, by a straight line."""
    rows = series_of(stage, "unaware", "with lag and clipping")["rows"]
    for a, b in zip(rows, rows[1:]):
        if a["peak_m"] >= peak_m > b["peak_m"]:
            share = (a["peak_m"] - peak_m) / (a["peak_m"] - b["peak_m"])
            return a["xi"] + share * (b["xi"] - a["xi"])
    return math.nan


def attitude_summary(stage):
    values = {gains: series_of(stage, gains, "with lag")["rows"] for gains in ("unaware", "aware")}
    return [["pitch error as xi falls (Figs 6.15, 6.18)",
             "varies little; aware gains improve it only marginally",
             "mean square from xi = 1 to 0.8 in degrees²: " + "; ".join(
                 f"{gains} {peaks(rows, 'mse_pitch_deg2')}" for gains, rows in values.items()),
             "no: see there"]]


def attitude(stage, stages):
    text = "## Attitude errors (Figs 6.15, 6.18)\n\n"
    for series in stage:
        text += code(series["command"])
    rows = [[number(stage[0]["rows"][k]["xi"], 2),
             *(number(series["rows"][k]["mse_pitch_deg2"], 3) for series in stage)]
            for k in range(len(stage[0]["rows"]) - 1, -1, -4)]
    text += "\nMean square pitch error over the 50 s, in degrees²:\n\n" + table(
        ["xi", *(f"{series['gains']}, {series['model']}" for series in stage)], rows)
    low, high = (series_of(stage, "unaware", "with lag")["rows"][k] for k in (0, -1))
    aware_low = series_of(stage, "aware", "with lag")["rows"][0]
    text += (
        "\nQuasi-static here is without lag only: with omega_0 = 100 a step of 4 degrees asks for "
        "more torque than the motors have, so the reference keeps within their limits in both "
        "models.\n\n"
        "* The thesis prints no figure, and calls the variation small. Ours is not: root mean "
        f"square, the unaware gains go from {number(high['mse_pitch_deg2'] ** 0.5, 2)} to "
        f"{number(low['mse_pitch_deg2'] ** 0.5, 2)} degrees, the aware ones end at "
        f"{number(aware_low['mse_pitch_deg2'] ** 0.5, 2)}. The doublets are 4 degrees high.\n"
        "* Why: below xi = 1 the share 1 - kappa of every pitch acceleration is missing, and gains "
        "of about 1 per second squared take seconds to make up for it. The maneuver repeats "
        "every 9 s, near the period of the barely damped pair (8 s at xi = 0.8), and the errors "
        "add up. In the drawing, of the first doublet alone, they are smaller, and the two sets "
        "hardly differ.\n"
        "* The aware gains help less here than in the altitude, as the thesis says: "
        f"{number(low['mse_pitch_deg2'] / aware_low['mse_pitch_deg2'], 2)} times less squared "
        "error at xi = 0.8")
    if "altitude" in stages:
        unaware = series_of(stages["altitude"], "unaware", "with lag and clipping")["rows"][0]
        aware = series_of(stages["altitude"], "aware", "with lag and clipping")["rows"][0]
        ratio = unaware["mse_altitude_m2"] / aware["mse_altitude_m2"]
        text += f", against {number(ratio, 2)} times in the altitude"
    return text + ".\n"


# Compensation

def pairs(stage, maneuver):
    for vehicle in dict.fromkeys(flight["vehicle"] for flight in stage):
        some = [flight for flight in stage
                if (flight["maneuver"], flight["vehicle"]) == (maneuver, vehicle)]
        yield (next(flight for flight in some if not flight["compensated"]),
               next(flight for flight in some if flight["compensated"]))


def compensation_summary(stage):
    plain, better = zip(*pairs(stage, "altitude-steps"))
    errors = ", ".join(f"{number(1e3 * a['mse_altitude_m2'] ** 0.5, 3)} to "
                       f"{number(1e3 * b['mse_altitude_m2'] ** 0.5, 3)} mm ({a['vehicle']})"
                       for a, b in zip(plain, better))
    charges = ", ".join(f"{number(b['charge_C'] - a['charge_C'], 2)} C of "
                        f"{number(a['charge_C'], 4)} ({a['vehicle']})"
                        for a, b in zip(plain, better))
    return [["altitude error with compensation (Figs 6.20, 6.21)", "smaller",
             f"rms {errors}", "yes"],
            ["its charge (Fig 6.22)", "the battery discharges faster", f"{charges} more",
             "in sign; small"]]


def compensation(stage, _):
    text = "## Commands compensated for the voltage (Figs 6.20 to 6.22)\n\n"
    for flight in stage:
        text += code(flight["command"])
    text += "\n" + table(
        ["vehicle", "maneuver", "commands by", "altitude error rms / mm", "largest peak / mm",
         "charge / C", "mean voltage of the last 2 s / V", "least voltage / V", "saturated"],
        [[flight["vehicle"], flight["maneuver"],
          "measured voltage" if flight["compensated"] else "nominal voltage",
          number(1e3 * flight["mse_altitude_m2"] ** 0.5, 3),
          number(1e3 * max(flight["peaks_m"]), 3) if flight["peaks_m"] else "-",
          number(flight["charge_C"], 5), number(flight["mean_voltage_at_the_end_V"], 5),
          number(flight["minimum_voltage_V"], 4), percent(flight["saturated_share"], 2)]
         for flight in stage])
    steps, hovers = list(pairs(stage, "altitude-steps")), list(pairs(stage, "hover"))
    extra = ", ".join(percent(b["charge_C"] / a["charge_C"] - 1.0, 2) for a, b in steps)
    hover_extra = max(abs(b["charge_C"] / a["charge_C"] - 1.0) for a, b in hovers)
    drop = ", ".join(number(1e3 * (a["mean_voltage_at_the_end_V"]
                                   - b["mean_voltage_at_the_end_V"]), 2) for a, b in steps)
    gain = ", ".join(number((a["mse_altitude_m2"] / b["mse_altitude_m2"]) ** 0.5, 2)
                     for a, b in steps)
    return text + (
        f"\nThe error falls by factors of {gain}. Part of the error without compensation is no "
        "transient: while the voltage falls the integral lags behind it, and the vehicle hangs "
        "low; in hover that is all of it.\n\n"
        f"The charge grows by {extra} and the voltage at the end falls by {drop} mV: the direction "
        "of Fig 6.22, not its size. (5.60) and (5.61) compare currents at equal commanded speeds. "
        "In closed loop the controller holds the height either way, so the motors need the same "
        f"power D v_b i whichever way D was found: hovering costs the same charge to "
        f"{100.0 * hover_extra:.4f} %. "
        "What is left is the steps: compensated commands climb as steeply as the reference asks, "
        "at currents whose losses grow with their square, down to a voltage that is momentarily "
        "below the cut-off of 3 V (a flight counts as empty only after a second below it).\n")


# Losses of the speed controllers

def controller_pairs(stage, maneuver):
    """(without, with compensation) by vehicle and controllers."""
    flown = [flight for flight in stage if flight["maneuver"] == maneuver]
    return [(plain, better) for plain in flown for better in flown
            if not plain["compensated"] and better["compensated"]
            and (plain["vehicle"], plain["controllers"])
            == (better["vehicle"], better["controllers"])]


def controllers(stage, _):
    text = ("## Speed controllers that lose (section 7.2)\n\n"
            "The thesis takes speed controllers as lossless, (3.11), and names that first among its "
            "open questions, because in section 6.6 compensation worked only in part. Here each "
            "motor has a transistor and a diode across it, which does not let the current reverse: "
            "\"typical\" is 30 mOhm, 100 ns at 20 kHz and a diode of 0.35 V, \"poor\" 60 mOhm, 200 "
            "ns at 40 kHz and 0.7 V (estimates from data sheets of such parts; nobody measured the "
            "Mambo's). The controller knows nothing of it.\n\n")
    for flight in stage:
        if flight["controllers"] == "typical":
            text += code(flight["command"])
    hovers = {(a["vehicle"], a["controllers"]): (a, b)
              for a, b in controller_pairs(stage, "hover")}
    rows = []
    for plain, better in controller_pairs(stage, "altitude-steps"):
        still, held = hovers[plain["vehicle"], plain["controllers"]]
        rows.append([plain["vehicle"], plain["controllers"], number(plain["current_A"], 4),
                     number(1e3 * plain["mse_altitude_m2"] ** 0.5, 3),
                     number(1e3 * better["mse_altitude_m2"] ** 0.5, 3),
                     number((plain["mse_altitude_m2"] / better["mse_altitude_m2"]) ** 0.5, 2),
                     number(1e3 * still["mse_altitude_m2"] ** 0.5, 3),
                     number(1e3 * held["mse_altitude_m2"] ** 0.5, 3),
                     percent(better["charge_C"] / plain["charge_C"] - 1.0, 2)])
    text += "\n" + table(
        ["vehicle", "controllers", "hover current / A", "steps, nominal voltage: rms / mm",
         "measured voltage: rms / mm", "gain by compensation", "hover, nominal voltage: rms / mm",
         "measured voltage: rms / mm", "charge by compensation"], rows)
    gains = {(a["vehicle"], a["controllers"]): (a["mse_altitude_m2"] / b["mse_altitude_m2"]) ** 0.5
             for a, b in controller_pairs(stage, "altitude-steps")}
    fall = ", ".join(
        f"{number(gains[vehicle, 'none'], 2)} to {number(gains[vehicle, 'typical'], 2)} and "
        f"{number(gains[vehicle, 'poor'], 2)} ({vehicle})"
        for vehicle in dict.fromkeys(flight["vehicle"] for flight in stage))
    return text + (
        f"\n* **Figs 6.20 and 6.21.** The losses explain a part of it: compensation then gains a "
        f"factor that falls from {fall}. What they take grows with the current and so does not go "
        "with the measured voltage; the integral has to find it, and its lag behind the falling "
        "voltage stays in the altitude. Compensation still gains a factor of several: losses of "
        "this size do not undo it, as one would need for an experiment in which it hardly helps.\n"
        "* **Fig 6.22.** They explain nothing of it: the charge that compensation costs is a "
        "smaller share with them than without. Nor can they while the controller holds the height, "
        "because the losses are those of the current that hovering takes, whichever way the duty "
        "cycle was found.\n")


# Square

def pitch_verdict(slow, fast):
    """By the fast reference the thesis' error is 15 % smaller."""
    change = fast["mse_pitch_deg2"] / slow["mse_pitch_deg2"] - 1.0
    if abs(change) < 0.02:
        return "hardly differs"
    if change > 0.0:
        return "opposite"
    return f"smaller at 200, too (by {percent(-change, 2)}, there by 15 %)"


def square_summary(stage):
    rows = []
    for vehicle in dict.fromkeys(row["vehicle"] for row in stage["true_state"]):
        some = [row for row in stage["true_state"] if row["vehicle"] == vehicle]
        rows.append([
            f"square at omega_0 = 100 and 200, {vehicle}: mean square error of altitude and pitch",
            "; ".join(f"{a} m², {b} degrees²" for a, b in QUOTED["square"].values())
            + " (experiment)",
            "; ".join(f"{number(row['mse_altitude_m2'], 3)} m², "
                      f"{number(row['mse_pitch_deg2'], 3)} degrees²" for row in some),
            f"altitude equal: yes; pitch: {pitch_verdict(*some)}"])
        rows.append([f"charge of the square, {vehicle}", "less at 200, hardly",
                     " and ".join(f"{number(row['charge_C'], 6)} C" for row in some), "yes"])
    return rows


def square(stage, _):
    text = "## The square at omega_0 = 100 and 200 (section 6.7)\n\n"
    for row in stage["true_state"]:
        text += code(row["command"])
    quoted = QUOTED["square"]
    text += "\nThe controller sees the true state:\n\n" + table(
        ["vehicle", "omega_0 / rad/s", "altitude / m²", "thesis", "pitch / degrees²", "thesis",
         "charge / C"],
        [[row["vehicle"], row["omega_rad_per_s"], number(row["mse_altitude_m2"], 4),
          quoted[row["omega_rad_per_s"]][0], number(row["mse_pitch_deg2"], 4),
          quoted[row["omega_rad_per_s"]][1], number(row["charge_C"], 6)]
         for row in stage["true_state"]])
    text += "\nThe controller sees the sensors through the estimator:\n\n"
    for case in stage["estimated"]:
        text += code(case["command"])
    text += f"\nSeeds {stage['estimated'][0]['seeds'][0]} to {stage['estimated'][0]['seeds'][-1]}, "
    text += "mean ± standard deviation of the flights that were completed:\n\n" + table(
        ["vehicle", "noise of the flow / m/s", "omega_0 / rad/s", "completed", "altitude / m²",
         "pitch / degrees²", "charge / C"],
        [[case["vehicle"], case["flow_noise_m_per_s"], row["omega_rad_per_s"],
          f"{row['completed']} of {len(case['seeds'])}", spread(row["mse_altitude_m2"]),
          spread(row["mse_pitch_deg2"]), spread(row["charge_C"], 6)]
         for case in stage["estimated"] for row in case["rows"]])
    return text + square_findings(stage)


def spread(value, digits=3):
    return "-" if value is None else (f"{number(value['mean'], digits)} ± "
                                      f"{number(value['deviation'], 2)}")


def square_findings(stage):
    slow, fast = [row for row in stage["true_state"] if row["vehicle"] == "mambo-physical"]
    saved = slow["charge_C"] - fast["charge_C"]
    text = (
        "\n* **Altitude.** The two are equal to "
        f"{percent(abs(fast['mse_altitude_m2'] / slow['mse_altitude_m2'] - 1.0), 1)}, as in the "
        "experiment. Its 0.018 m² (0.13 m rms) hold air, sensors and take-off; ours is the lag of "
        "the integral behind the falling voltage.\n"
        f"* **Pitch.** By mambo-physical {number(slow['mse_pitch_deg2'], 3)} degrees² at 100 and "
        f"{number(fast['mse_pitch_deg2'], 3)} at 200, in the experiment 0.534 and 0.454: "
        f"{pitch_verdict(slow, fast)}. The motors, with 18 ms, are slower than either reference, "
        "and the limits of its acceleration are those of the motors in both: the choice changes "
        "little.\n"
        f"* **Charge.** With the true state the fast reference saves "
        f"{number(1e3 * saved, 2)} mC of "
        f"{number(slow['charge_C'], 4)} C: the sign of the thesis' hypothesis, and "
        f"{percent(saved / slow['charge_C'], 1)}. ")
    noise = [case["rows"][0]["charge_C"] for case in stage["estimated"]
             if case["vehicle"] == "mambo-physical"][0]
    text += (f"From one flight with sensors to the next the charge varies by "
             f"{number(1e3 * noise['deviation'], 2)} mC: no single pair of flights shows it.\n")
    paired = [case for case in stage["estimated"] if case["fast_minus_slow"]["pairs"] > 1]
    for case in paired:
        both = case["fast_minus_slow"]
        text += (f"* **With sensors** ({case['vehicle']}, flow noise {case['flow_noise_m_per_s']} "
                 f"m/s, {both['pairs']} pairs with the same noise) the fast one costs "
                 f"{number(both['charge_C']['mean'], 3)} ± "
                 f"{number(both['charge_C']['error_of_mean'], 2)} C *more*, and its pitch error "
                 f"is larger by {number(both['mse_pitch_deg2']['mean'], 2)} ± "
                 f"{number(both['mse_pitch_deg2']['error_of_mean'], 1)} degrees²: omega_0² times "
                 "the noise of the velocity goes to the motors.\n")
    lost = [f"{case['vehicle']} at {case['flow_noise_m_per_s']} m/s" for case in stage["estimated"]
            if case["rows"][1]["completed"] == 0]
    if lost:
        text += lost_flights(stage["causes"], lost)
    return text + (
        "* **To conclude.** The simulation supports that the choice hardly matters for the charge. "
        "It cannot confirm that a faster reference saves any: the saving is smaller than the "
        "spread of single flights, and noise turns its sign.\n")


def lost_flights(causes, lost):
    """Why none of them is completed."""
    return (
        f"* **Lost flights.** At omega_0 = 200 no flight is completed by {'; '.join(lost)}; at 100 "
        "all are. The noise of the velocity reaches the pitch reference through the position gains "
        "(0.61 rad s/m, ours; the thesis prints none) and its acceleration by omega_0². While the "
        "vehicle is rolled, the inversion answers each pitch acceleration by yaw, of which the "
        "motors have little: pitch and yaw together pull the four of them apart, and because they "
        "lag while thrust goes with the square of the speed, what remains on the mean is a torque "
        "about the roll axis that grows with the roll angle. Changing one thing at a time shows "
        "it:\n\n" + "".join(code(case["command"]) for case in causes) + "\n"
        + table(["changed", "completed"],
                [[case["changed"], f"{case['completed']} of {case['seeds']}"] for case in causes])
        + "\n")


# Hover

def hover_summary(stage):
    one = {(row["vehicle"], row["cell"]): row for row in stage["rows"]}
    coupled, physical = (one[(vehicle, "gifi-600mAh-1")]
                         for vehicle in ("mambo-coupled", "mambo-physical"))
    return [["hover on the identified 600 mAh cell", "-",
             f"mambo-thesis cannot; mambo-coupled {number(coupled['battery_A'], 3)} A, "
             f"{number(coupled['endurance_s'] / 60, 2)} min; mambo-physical "
             f"{number(physical['battery_A'], 3)} A, {number(physical['endurance_s'] / 60, 2)} min",
             "-"]]


RESISTANCE_OHM = 0.1314


def needed_W(stage):
    """Of mambo-thesis in hover, by the cells that carry it."""
    row = next(row for row in stage["rows"] if row["hovers"] and row["vehicle"] == "mambo-thesis")
    return row["battery_V"] * row["battery_A"]


def hover(stage, _):
    rows = []
    for row in stage["rows"]:
        if row["hovers"]:
            rows.append([row["vehicle"], row["cell"], number(row["speed_rad_per_s"], 4),
                         number(row["duty"], 3), number(row["battery_V"], 4),
                         number(row["battery_A"], 4), number(row["endurance_s"] / 60.0, 4),
                         number(row["charge_C"], 5), percent(row["final_soc"], 2)])
        else:
            rows.append([row["vehicle"], row["cell"], number(row["speed_rad_per_s"], 4),
                         f"{number(row['duty'], 3)} wanted", "cannot hover", "-", "-", "-", "-"])
    return ("## What hovers on what\n\n" + code(stage["command"])
            + "\nHover at the first instant of a full cell, and until the battery is empty:\n\n"
            + table(["vehicle", "cell", "speed / rad/s", "duty", "voltage / V", "current / A",
                     "endurance / min", "charge / C", "SOC left"], rows)
            + "\n* mambo-thesis cannot hover on the 600 mAh cells: with the friction b = 1e-6 of "
            f"Table 6.1 it needs {number(needed_W(stage), 3)} W, and a source of 4.2 V behind "
            f"{RESISTANCE_OHM} ohm (Table 4.11) gives at most "
            f"{number(4.2 ** 2 / (4.0 * RESISTANCE_OHM), 3)} "
            "W.\n"
            "* The mass is the vehicle's as given; that of the cell is not modelled. A 32 Ah cell "
            "weighs several times what these vehicles can lift: its rows show what a stiff "
            "supply does, not a flight.\n"
            "* On the small cells a part of the charge stays behind: at 2 to 3 A the voltage is "
            "at the cut-off before the cell is empty.\n")


# Design

def design_summary(stage):
    rows = []
    for case in best_designs(stage):
        rows.append([f"gains by ({case['equation']}), {case['loop']} {case['printed_set']}: "
                     "[K_e K_I K_edot]", gains_text(case["printed"]["gains"]),
                     f"{gains_text(case['gains'])}, "
                     f"{number(case['printed']['cost'] / case['cost'], 3)} times less cost", "no"])
    return rows


def best_designs(stage):
    for equation in dict.fromkeys(case["equation"] for case in stage):
        yield min((case for case in stage if case["equation"] == equation),
                  key=lambda case: case["cost"])


def gains_text(gains):
    return " ".join(number(gains[key], 3) for key in ("proportional", "integral", "derivative"))


def designed(stage, _):
    printed, found = stage["rows"]
    errors = [f"{number(1e3 * row['mse_altitude_m2'] ** 0.5, 3)} mm" for row in (printed, found)]
    return ("### The gains of (6.3) on a cell\n\n" + code(stage["command"])
            + code(printed["command"]) + code(found["command"])
            + f"\nThe altitude error is {errors[0]} rms with the printed gains and {errors[1]} "
            f"with those found ({gains_text(stage['gains'])}). (6.3) holds the voltage still in "
            "each of its flights; on a cell it falls all the time, and what carries the vehicle "
            "through that is the integral, of which the gains found have less.\n")


def design(stage, _):
    text = "## Gains by optimization, (6.2) to (6.5), against the printed ones\n\n"
    for case in stage:
        text += code(case["command"])
    text += "\n" + table(
        ["problem", "optimizer", "printed K_e, K_I, K_edot", "its cost", "found", "its cost",
         "bound", "evaluations", "time / s", "gap to ten times longer"],
        [[f"({case['equation']}) {case['loop']}, {case['printed_set']}", case["optimizer"],
          gains_text(case["printed"]["gains"]), number(case["printed"]["cost"], 4),
          gains_text(case["gains"]), number(case["cost"], 4),
          number(case["bounds"]["proportional"], 2), f"{case['evaluations']:,}",
          number(case["wall_s"], 3), f"{number(case['longer_run']['gap_percent'], 1)} %"]
         for case in stage])
    text += (
        "\nCosts are integrals of the squared error in m² s (altitude) and rad² s (attitude), "
        "summed over 21 values of xi for the aware gains. Motor lag and saturation are included, "
        "and have to be: at xi = 1 without them the inversion is exact, the error is zero for any "
        "gains and (6.2), (6.4) have no answer of their own.\n\n"
        "* **The printed gains are no optima of this plant**, and the swarm's answers are those "
        "of a run ten times longer. Bounds are active: K_edot stands at its "
        "bound in every problem, so the bound, not the plant, chooses the answer.\n")
    stuck = [case for case in stage if case["cost"] > 1.01 * case["polished_cost"]]
    for case in stuck:
        text += (f"* **{case['optimizer']} on ({case['equation']})** ends in a corner of the box "
                 f"({gains_text(case['gains'])}) at {number(case['cost'], 4)}; started again from "
                 f"near there it finds {number(case['polished_cost'], 4)}, as the swarm does: "
                 "the corner is no minimum, and the swarm's answer is the one to take.\n")
    return text + (
        "* (6.2) to (6.5) know nothing of noise, which large gains amplify. The printed gains are "
        "data, and what lipoid flies by default.\n")


SECTIONS = {"poles": poles, "altitude": altitude, "attitude": attitude,
            "compensation": compensation, "controllers": controllers, "square": square,
            "hover": hover, "design": design, "designed": designed}
SUMMARIES = {"poles": poles_summary, "altitude": altitude_summary, "attitude": attitude_summary,
             "compensation": compensation_summary, "square": square_summary,
             "hover": hover_summary, "design": design_summary}
