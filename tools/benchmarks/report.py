"""docs/benchmarks.md from the JSON that tools/bench leaves: nothing in it is typed by hand."""

import json
import math
import subprocess

from . import build_times, figure
from .goals import PEER_DIGITS_V
from .process import ROOT


def number(value, digits=4):
    """So many significant digits, thousands set apart; "-" where there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if exponent < -4 or exponent >= 9:
        return f"{value:.{digits - 1}e}"
    decimals = max(0, digits - 1 - exponent)
    return f"{round(value, digits - 1 - exponent):,.{decimals}f}"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def code(command):
    return f"    {command}\n"


def write(result, figure_name):
    """(markdown, svg or None)."""
    stages = result["stages"]
    parts = [head(result), goals(result["goals"]), machine(result["machine"])]
    parts.append(campaign(result["campaign"]))
    for name, section in (("staged", staged), ("joint", joint), ("branches", branches),
                          ("optimizers", optimizers), ("csv", csv_reading), ("pybop", pybop)):
        if name in stages:
            parts.append(section(stages[name], stages))
    if "limits" in stages:
        parts.append(limits(result))
    if "step_times" in result:
        parts.append(steps(result["step_times"]))
    if "long_logs" in result:
        parts.append(long_log_table(result["long_logs"]))
    if "build_times" in result:
        parts.append(builds(result["build_times"]))
    svg = None
    if "growth" in stages:
        parts.append(growth(stages["growth"], figure_name))
        svg = figure.draw(stages["growth"])
    return "\n".join(parts), svg


def head(result):
    text = ("# Benchmarks\n\n"
            "Made by `tools/bench --report` from the JSON beside this file, which `tools/bench "
            "--peers` left: run both to\nhave your own. lipoid and its peers ran in turn, on the "
            "same files and machine, in one go; figures are medians,\nruns of each: "
            f"{result['runs']}.\n")
    if result["quick"]:
        text += ("\n**A quick run (--quick): a fiftieth of the rows, one run each. Not the figures "
                 "to quote.**\n")
    return text


def goals(rows):
    words = {True: "yes", False: "no", None: "not measured"}
    return "## Goals\n\n" + table(
        ["goal", "wanted", "found", "met"],
        [[row["goal"], row["wanted"], row["found"] or "-", words[row["met"]]] for row in rows])


def machine(facts):
    peers = facts["peers"]
    software = ", ".join(f"{name} {version}" for name, version in peers.items()) or "none"
    commit = facts["commit"] + (" with changes" if facts["modified"] else "")
    return "## Machine\n\n" + table(["", ""], [
        ["processor", f"{facts['processor']}, {facts['cores']} cores"],
        ["memory", f"{facts['memory_GB']} GB"],
        ["system", f"{facts['system']} {facts['kernel']}"],
        ["compiler", f"{facts['compiler']}, `{facts['flags']}`"],
        ["lipoid", f"commit {commit}"],
        ["peers", software],
        ["date", facts["date"]],
        ["load before the run", facts["load_average_before"]],
    ])


def campaign(facts):
    rows = [[file["file"], f"{file['rows']:,}", number(file["bytes"] / 1e6)]
            for file in facts["files"]]
    rows.append(["all", f"{facts['rows']:,}", number(facts["bytes"] / 1e6)])
    return ("## The campaign\n\n" + code(facts["command"]) + "\n"
            + table(["file", "rows", "MB"], rows)
            + "\nThe header is the peer's, its names of the files are links: both read the same "
            "bytes, which were read or\nwritten before and lie in the page cache.\n")


def ratio(theirs, ours):
    return f"{number(theirs / ours, 4)}"


def staged(stage, _):
    ours = stage["lipoid"]["median"]
    text = "## The staged run\n\n" + code(stage["lipoid"]["command"])
    if "peer" not in stage:
        text += f"\nThe SciPy peer was skipped: {stage['peer_skipped']}.\n\n"
        theirs = {}
    else:
        text += code(stage["peer"]["command"]) + "\n"
        theirs = stage["peer"]["median"]

    def line(what, our_key, their_key, factor=1.0):
        mine = ours[our_key] * factor
        other = theirs.get(their_key)
        if other is None:
            return [what, number(mine), "-", "-"]
        return [what, number(mine), number(other * factor), ratio(other * factor, mine)]

    rows = [
        line("whole run / s", "wall_s", "total_s"),
        line("the same, process time of all cores / s", "processor_s", "processor_s"),
        line("the joint fit (4.61) alone / s", "joint_fit_s", "fit_s"),
        line("peak memory / MB", "peak_memory_MB", "peak_memory_MB"),
        line("rmse of the pulses / mV", "rmse_V", "rmse_V", 1e3),
        line("evaluations of the residual by the fit", "joint_fit_evaluations", "evaluations"),
    ]
    text += table(["", "lipoid", "SciPy", "ratio"], rows)
    both = ours["fit_beta_held_s"] + ours["joint_fit_s"]
    text += (f"\nlipoid is charged for its whole process, the peer for what it prints (its TOTAL "
             "leaves the start of Python out).\nThe staged run also fits (4.60), with beta held, "
             f"which the peer does not: {number(ours['fit_beta_held_s'])} s; both fits together "
             f"{number(both)} s")
    if theirs:
        text += f", {ratio(theirs['fit_s'], both)} times faster than the peer's one"
        text += (".\nHow many evaluations the peer's differences need is luck, and differs from "
                 "branch to branch: one of its evaluations takes\n"
                 f"{number(theirs['evaluation_s'])} s, in which lipoid makes "
                 f"{number(theirs['evaluation_s'] / ours['joint_fit_s'], 3)} whole fits")
    check = stage["validation"]
    text += (f".\n`lipoid validate` recomputes the rmse from the cell file and the CSV over all "
             f"rows: {number(1e3 * check['rmse_V'], 7)} mV,\nwhich differs from the fit's by "
             f"{check['difference_V']:.1e} V (allowed {check['allowed_V']:.0e} V).\n\n")
    names = ["lipoid"] + (["peer"] if theirs else [])
    wall = {"lipoid": ("wall_s", "joint_fit_s"), "peer": ("total_s", "fit_s")}
    text += table(["run", *(f"{name}: {what} / s" for name in names for what in ("whole", "fit"))],
                  [[k + 1, *(number(stage[name]["runs"][k][key]) for name in names
                             for key in wall[name])]
                   for k in range(len(stage["lipoid"]["runs"]))])
    return text + against_truth(stage)


def against_truth(stage):
    joint = stage["joint"]
    found = {"lipoid, staged": stage["lipoid"]["runs"][-1], "lipoid, joint": joint}
    if "peer" in stage:
        found = {"SciPy": stage["peer"]["runs"][-1], **found}

    def off(name, run):
        return f"{100 * (run['parameters'][name] / joint['truth'][name] - 1):+.2g}"

    names = [name for name in joint["truth"] if all(name in run["parameters"]
                                                    for run in found.values())]
    return ("\n### Against the truth, and the joint method\n\n" + code(joint["command"]) + "\n"
            + table(["", "truth", *(f"{who} is off by / %" for who in found)],
                    [[name, number(joint["truth"][name], 6),
                      *(off(name, run) for run in found.values())] for name in names]
                    + [["rmse of the pulses / mV", "",
                        *(number(1e3 * run["rmse_V"]) for run in found.values())]])
            + f"\nThe joint method takes all logs at once: {number(joint['wall_s'], 3)} s and "
            f"{number(joint['peak_memory_MB'], 3)} MB for the whole run on the same files, its "
            "standard errors\nincluded. What the staged method, whoever runs it, is off by comes "
            "from alpha and v_oc(A), which it takes from\nlogs under load.\n")


def joint(stage, _):
    rows = []
    commands = ""
    for one in stage["campaigns"]:
        if "skipped" in one:
            rows.append([one["name"], *["-"] * 9, f"skipped: {one['skipped']}"])
            continue
        commands = commands or code(one["lipoid"]["command"])
        ours = one["lipoid"]["median"]
        line = [one["name"], number(ours["wall_s"], 3), number(ours["joint_s"], 3)]
        if "peer" not in one:
            ended = (f"the peer was killed after {stage['peer_limit_s']:.0f} s"
                     if "peer_ended" in one else f"no peer: {stage['peer_skipped']}")
            rows.append([*line, *["-"] * 7, ended])
            continue
        peer = one["peer"]["median"]
        if "peer" in one and "peer" not in commands:
            commands += code(one["peer"]["command"])
        rows.append([*line, number(peer["total_s"], 3), number(peer["fit_s"], 3),
                     ratio(peer["total_s"], ours["wall_s"]), f"{peer['rows']:,.0f}",
                     number(peer["evaluations"], 3),
                     number(1e3 * one["peer"]["judges"]["lipoid_rmse_V"]),
                     number(1e3 * peer["rmse_V"]), ""])
    return ("## The joint method\n\n" + commands + "\n"
            + table(["campaign", "lipoid: whole / s", "of it the method / s", "SciPy: whole / s",
                     "its fit / s", "ratio of the whole", "rows", "SciPy's evaluations",
                     "lipoid: rmse / mV", "SciPy: rmse / mV", ""], rows)
            + "\nlipoid is charged for its whole process: reading, the staged run, the choice of the "
            "structure and the standard\nerrors. The peer (variable projection: `nnls` inside, "
            "`least_squares` outside) is given alpha, the structure and\nthe smoothness that lipoid "
            "chose, starts from a small grid, and is charged for reading and one fit, without\nthe "
            "start of Python. Both errors are weighted (docs/joint.md, 2), by the peer's own "
            "equations at its own points.\n")


def branches(stage, _):
    text = "## Other branches\n\n"
    if "skipped" in stage:
        return text + f"Skipped: {stage['skipped']}.\n"
    truth = stage["true_beta_per_sqrt_s"]

    def off(run):
        return f"{100 * (run['beta_per_sqrt_s'] / truth - 1):+.1f}"

    def cells(run, whole):
        if run is None:
            return ["-", "-", f"> {number(stage['limit_s'], 3)}"]
        off = 100 * (run["beta_per_sqrt_s"] / truth - 1)
        return [number(1e3 * run["rmse_V"]), f"{off:+.2f}", number(run[whole], 2)]

    def line(row):
        return [number(1e3 * row["noise_V"], 1), number(1e3 * row["resistance_Ohm"], 1),
                number(row["time_constant_s"], 3), *cells(row["peer"], "total_s"),
                row["peer"]["evaluations"] if row["peer"] else "-",
                *cells(row["lipoid"], "wall_s"), *cells(row["joint"], "wall_s")]

    larger = sum(row["peer"] is not None
                 and row["lipoid"]["rmse_V"] > row["peer"]["rmse_V"] + PEER_DIGITS_V
                 for row in stage["rows"])
    return (text + f"The same cell with other branches and more noise, {stage['sampling_s']} s "
            "between rows, one run each. The first:\n\n" + code(stage["rows"][0]["command"]) + "\n"
            + table(["noise / mV", "r_1 / mOhm", "tau_1 / s", "SciPy: rmse / mV", "beta off / %",
                     "whole / s", "evaluations", "lipoid staged: rmse / mV", "beta off / %",
                     "whole / s", "lipoid joint: rmse / mV", "beta off / %", "whole / s"],
                    [line(row) for row in stage["rows"]])
            + f"\nThe staged rmse is larger than the peer's in {larger} of {len(stage['rows'])}. The "
            "peer joins 5,000 raw rows of the low rate to its\ncurve: with 1 mV on each its fit "
            "can move along that noise, which lowers its rmse here and there and takes\nmany "
            "evaluations. What is left of either rmse beyond the noise, and most of what beta is "
            "off by, is the staged\nmethod's own: alpha and v_oc(A) come from logs under load. The "
            "joint method (docs/joint.md) takes all logs at\nonce, and leaves the noise.\n")


def optimizers(stage, _):
    text = "## Optimizers\n\n"
    if "skipped" in stage:
        return text + f"Skipped: {stage['skipped']}.\n"
    rows = [[row["optimizer"], number(row["wall_s"]), number(1e3 * row["rmse_V"], 6),
             number(row["cost_above_best_percent"], 3), row["evaluations"],
             row["gradient_evaluations"] if row["gradient_evaluations"] is not None else "-",
             row["termination"]] for row in stage["rows"]]
    return (text + code(stage["command"]) + "\n"
            + table(["optimizer", "time / s", "rmse / mV", "cost above best / %", "evaluations",
                     "of gradients", "stopped"], rows)
            + "\nThe thesis needed 9,900 to 12,600 s for particle swarm.\n")


def csv_reading(stage, _):
    text = "## CSV reading\n\n" + code(stage["lipoid"]["command"])
    ours = stage["lipoid"]["median"]["wall_s"]
    megabytes = stage["bytes"] / 1e6
    rows = [["lipoid", number(ours), number(megabytes / ours), "1"]]
    if "pandas" in stage:
        theirs = stage["pandas"]["median"]["wall_s"]
        text += code(stage["pandas"]["command"])
        rows.append(["pandas", number(theirs), number(megabytes / theirs), ratio(theirs, ours)])
    text += f"\n{stage['file']}, {number(megabytes)} MB:\n\n"
    text += table(["", "time / s", "MB/s", "ratio"], rows)
    if stage["pandas_skipped"]:
        text += f"\npandas was skipped: {stage['pandas_skipped']}.\n"
    return text


def limits(result):
    stage = result["stages"]["limits"]
    rows = []
    ours = result["stages"].get("staged", {}).get("lipoid", {}).get("median")
    if ours:
        least = result["campaign"]["bytes"] / stage["page_cache_bytes_per_s"]
        rows.append(["whole run", "bytes of the CSV from the page cache", number(least, 3),
                     number(ours["wall_s"], 3), number(ours["wall_s"] / least, 3)])
    reading = result["stages"].get("csv")
    if reading:
        least = reading["bytes"] / stage["page_cache_bytes_per_s"]
        found = reading["lipoid"]["median"]["wall_s"]
        rows.append(["CSV reading", "bytes of the CSV from the page cache", number(least, 3),
                     number(found, 3), number(found / least, 3)])
    points = result["stages"].get("growth", {}).get("series", {}).get("sweep", {}).get("points")
    if points:
        most = points[-1]
        least = most["rows"] * 24 / stage["memory_bytes_per_s"]
        rows.append([f"one sweep of {most['rows']:.0e} rows", "24 bytes per row from memory",
                     number(least, 3), number(most["wall_s"], 3),
                     number(most["wall_s"] / least, 3)])
        least = most["rows"] * stage["flops_per_row"] / stage["flops_per_s"]
        rows.append(["the same", f"{stage['flops_per_row']} operations per row, one core",
                     number(least, 3), number(most["wall_s"], 3),
                     number(most["wall_s"] / least, 3)])
    return ("## Limits\n\n" + code(stage["command"]) + "\n"
            + table(["", "one core", "all cores"], [
                ["page cache / GB/s", number(stage["page_cache_bytes_per_s"] / 1e9, 3), "-"],
                ["memory / GB/s", number(stage["memory_bytes_per_s"] / 1e9, 3),
                 number(stage["memory_bytes_per_s_all_cores"] / 1e9, 3)],
                ["multiplications and additions / 1e9/s", number(stage["flops_per_s"] / 1e9, 3),
                 number(stage["flops_per_s_all_cores"] / 1e9, 3)]])
            + "\n" + table(["stage", "limit", "least / s", "found / s", "found / least"], rows)
            + "\nOperations are those of the plain recurrences with Jacobian, row by row; what an "
            "evaluation leaves out shows as\na smaller ratio, below one where it leaves out more "
            "than the machine loses.\n")


def growth(stage, figure_name):
    text = "## Growth\n\n" + code(stage["command"]) + f"\n![time against size]({figure_name})\n"
    for key, series in stage["series"].items():
        if not series["points"]:
            continue
        size = f", {series['rows']:.0e} rows" if "rows" in series else ""
        text += f"\n{key}: {series['what']}{size}\n\n" + table(
            [series["unit"], "time / ms", "1e6 rows/s"],
            [[f"{point[series['unit']]:,}", number(1e3 * point["wall_s"]),
              number(point["rows_per_s"] / 1e6)] for point in series["points"]])
    return text


STEPS = {
    "CellStep": "lipoid's own cell, a step and its voltage",
    "Exported/CellStepInDouble": "the same as exported C, double",
    "Exported/CellStepInFloat": "the same as exported C, float",
    "LiveFrame": "a frame of `lipoid sitl`: sensors, motors, body, battery; without the network",
}


def steps(rows):
    lines = [[STEPS.get(row["name"], row["name"]), number(1e9 * row["processor_s"], 3)]
             for row in rows]
    return ("## Short steps\n\nMeasured by `tools/step-times --out docs/benchmarks.json` (processor "
            "time, build of the preset dev, one core), the cell\ngifi-600mAh-1 with ten diffusion "
            "modes:\n\n" + table(["", "ns"], lines))


def long_log_table(measured):
    reading_s = measured["runs"][0]["processor_s"]
    lines = [[row["name"], number(row["processor_s"], 3), number(row["processor_s"] / reading_s, 3),
              number(row["peak_memory_MB"], 3)] for row in measured["runs"]]
    return ("## Long logs\n\nMeasured by `tools/long-logs --out docs/benchmarks.json` (preset dev): a campaign whose "
            f"low-rate log has {number(measured['rows'])} rows in\n{number(measured['bytes'] / 1e9, 3)} GB of CSV, of "
            "which more than 16,777,216 rows are thinned "
            "([formats.md](formats.md#long-logs)). Memory does not grow with the rows.\n\n"
            + code(measured["command"]) + "\n"
            + table(["", "processor time / s", "times that of inspect", "peak memory / MB"], lines)
            + "\nconvert, simulate and validate read the log twice, and the first two write every row.\n")


def keep(file, key, measured):
    """Puts what a tool of its own measured into a JSON of tools/bench, and makes its report anew."""
    result = json.loads(file.read_text(encoding="utf-8"))
    result[key] = measured
    file.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    subprocess.run([ROOT / "tools/bench", "--report", file], check=True)


def builds(facts):
    lines = [[what, f"{goal:g}", number(processor_min, 3), number(wall_min, 3)]
             for what, goal, processor_min, wall_min in build_times.rows(facts)]
    commands = [facts["configure"], *(facts[key]["command"] for key in ("lipoid", "tests"))]
    return ("## Build times\n\nMeasured by `tools/build-times --out docs/benchmarks.json`, without the "
            "compiler cache, in a folder that is new:\n\n" + "".join(code(c) for c in commands)
            + "\n" + table(["", "goal / CPU minutes", "CPU minutes", "minutes by the clock"], lines)
            + f"\nCommit {facts['commit']}, {facts['compiler']}, on {facts['cores']} cores of "
            f"{facts['processor']}; the load average at the end\nwas {facts['load_average_after']}, "
            f"which is {facts['cores']} or less on a machine that does nothing else.\n")


def pybop(stage, _):
    text = "## PyBOP\n\n"
    if "skipped" in stage:
        return text + f"Skipped: {stage['skipped']}.\n"
    text += (f"In a virtual environment with {', '.join(stage['pinned'])} (`tools/bench --peers` "
             "makes it). Both tools see the same rows, curve,\ncapacity, first state of charge, "
             "bounds and cost; the sums of squares are numpy's, of neither. PyBaMM draws straight "
             "lines\nbetween the rows of the current; lipoid holds it, backward or forward, fits "
             "both and keeps the better: its time is that of\nboth. PyBOP's runs differ by their "
             "seed; its sum is the least of them.\n")
    if "published" in stage:
        text += "\n### The published example\n\n" + duel(stage["published"])
        text += ("\nPublished, of an earlier version on another machine: "
                 f"{number(stage['published_sum_V2'], 3)} V² in 40.5 s.\n")
    else:
        text += f"\nThe published example was skipped: {stage['published_skipped']}.\n"
    if "known_truth" in stage:
        text += "\n### A cell whose truth is known\n\n" + duel(stage["known_truth"])
        text += "\n" + truth(stage["known_truth"])
    return text


def duel(stage):
    """Times and sums of squares of both, then every answer under every reading of the current."""
    ours, theirs = stage["lipoid"], stage["pybop"]
    text = "".join(code(command) for command in ours["commands"]) + code(theirs["command"]) + "\n"
    rows = [[what, number(ours["median"][key]), number(theirs["median"][key]),
             ratio(theirs["median"][key], ours["median"][key])]
            for what, key in (("fit alone / s", "fit_s"), ("process / s", "wall_s"))]
    rows.append(["sum of squares / V²", f"{number(ours['sum_of_squares_V2'])} ({ours['hold']})",
                 number(theirs["sum_of_squares_V2"]),
                 ratio(theirs["sum_of_squares_V2"], ours["sum_of_squares_V2"])])
    text += table([f"{stage['rows']:,} rows", "lipoid", "PyBOP", "ratio"], rows)
    header = ["PyBOP's runs", "fit / s", "iterations", "evaluations", "its own sum / V²"]
    text += "\n" + table(header, [
        [k + 1, number(fit["fit_s"]), fit["iterations"], fit["evaluations"],
         number(fit["own_sum_of_squares_V2"])] for k, fit in enumerate(theirs["runs"])])
    names = [name for name in ours["parameters"] if not name.startswith("tau")]
    text += "\n" + table(["", *names], [
        [tool, *(number(stage[key]["parameters"][name], 5) for name in names)]
        for tool, key in (("lipoid", "lipoid"), ("PyBOP", "pybop"))])
    conventions = list(next(iter(stage["judged_V2"].values())))
    text += "\nSum of squares / V² with the current between rows as\n\n" + table(
        ["answer", *conventions],
        [[name, *(number(sums[convention]) for convention in conventions)]
         for name, sums in stage["judged_V2"].items()])
    return text


def truth(stage):
    names = list(stage["truth"])
    rows = [["truth", *(number(stage["truth"][name]) for name in names)]]
    for tool, key in (("lipoid is off by / %", "lipoid"), ("PyBOP is off by / %", "pybop")):
        rows.append([tool, *(f"{stage[key]['off_by_percent'][name]:+.2f}" for name in names)])
    first = stage["pybop"]["runs"][0]
    return table(["", *names], rows) + (
        f"\nAt the truth PyBOP's own cost is {number(first['probe_sum_of_squares_V2'])} V². With the "
        "solver of its example it would be "
        f"{number(first['probe_with_the_examples_solver_V2'])} V², because the\nsolver then steps "
        "over whole pulses after a long rest: here it is held to steps of one second. It may take "
        "five times the\niterations of the example. The log is lipoid's (10 ms, 0.5 mV of noise), "
        "thinned for PyBOP to rows that stand densely behind\nevery switch of the current.\n")
