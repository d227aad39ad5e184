"""Options are those of the command line: names, ranges, defaults and words."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from conftest import PLAIN, ROOT
from lipoid import _core
from lipoid._health import describe_health

Description = dict[str, Any]

# Of each function: its options, the commands that have them, and what one side alone has.
# Arguments and files that commands write are not options of functions.
FILES = {"report", "latex", "output", "csv", "residuals", "cell"}
COMMON = {"summary", "seed", "threads", "quiet", "set", "help"}
LOGS = {"constant_current", "low_rate", "low_rate_charge", "pulses", "flight", "validation"}
CAMPAIGN = {*LOGS, "cutoff_V", "capacity_Ah", "name", "series", "parallel"}
READING = {"columns", "units", "current_sign", "hold", "battery", "most_rows"}
START = {"initial_soc", "initial_voltage_V"}
FUNCTIONS: dict[str, tuple[Callable[[], list[Description]], str, set[str], set[str]]] = {
    # function: (its options, the command, options of the command alone, of the function alone)
    "read_log": (
        lambda: _core.describe_reading(True),
        "inspect",
        {"all", "write_campaign", "series", "parallel", "cutoff_V"},
        # Keys of a log in a campaign file.
        {"start_s", "end_s", "lead_resistance_Ohm", "steps", "cycles", "voltage_optional"},
    ),
    "Campaign": (
        _core.describe_campaign,
        "compare",
        # Options of compare() and read_log(). The kinds of logs are files there, logs here.
        {
            *READING,
            *LOGS,
            "initial_voltage_V",
            "scaling",
            "decades",
            "target",
            "optimizers",
            "starts",
            "time_constants",
            "alpha_C",
        }
        | {"open_circuit_voltage", "branches", "no_diffusion", "fix", "start", "bounds"},
        LOGS,
    ),
    "identify": (
        _core.describe_identify,
        "identify",
        {*CAMPAIGN, *READING, *START, "truth", "verbose"},
        set(),
    ),
    "compare": (_core.describe_compare, "compare", {*CAMPAIGN, *READING, *START}, set()),
    "study": (_core.describe_study, "study", {*CAMPAIGN, *READING, *START}, set()),
    "plan": (_core.describe_plan, "plan", set(), set()),
    "fly": (
        _core.describe_fly,
        "fly",
        # Keys of the groups here; arguments of fly(); Cell.resample().
        {"battery", "controller", "wind", "gusts", "ensemble"},
        {"maneuver_options", "wind."},
    ),
    "export": (
        _core.describe_export,
        "export",
        # Arguments of export(), and a Log as the mission.
        {*READING, "to", "mission", "into", "error_limit_mV"},
        {"mission"},
    ),
    "endurance": (
        _core.describe_endurance,
        "endurance",
        # Arguments of endurance(), whose mission is read already, and words of quantities.
        {*READING, "over", "mission"},
        {"mission", "power", "waypoints", "cruise_speed"},
    ),
    "health": (
        describe_health,
        "health",
        set(),
        # Keys of a log in a campaign file.
        {"start_s", "end_s", "lead_resistance_Ohm", "steps", "cycles", "voltage_optional"},
    ),
    "synthesize": (
        _core.describe_synthesize,
        "synthesize",
        # Arguments of synthesize().
        {"protocol", "with"},
        set(),
    ),
}
# Settings of the command that other functions have.
MANEUVERS = tuple(f"{name}." for name in _core.maneuver_names())
WITHOUT_SETTINGS = {"Campaign", "read_log"}
# A group has another name where the plain one is that of an option, or where commands have none.
GROUPS = {"open_circuit_voltage_fit": "open_circuit_voltage.", "comparison": "", "flight": ""}


def help_of(command: str) -> dict[str, str]:
    """What --help says: of each option, and of each setting, the sentence beside it."""
    path = os.environ.get("LIPOID_PROGRAM", str(ROOT / "build/dev/tools/lipoid"))
    if not Path(path).exists():
        pytest.skip("the program is not built: LIPOID_PROGRAM names it")
    text = subprocess.run(
        [path, command, "--help"], env=PLAIN, capture_output=True, text=True, check=True
    )
    found: dict[str, str] = {}
    name = ""
    for line in text.stdout.splitlines():
        option = re.fullmatch(r"  (?:-\w, )?(--)?([\w.-]+)(?: \S+)?(?: \.\.\.)?(?:  +(.*))?", line)
        if option and (option[1] or not option[2].isupper()):  # no argument
            name = option[2].replace("-", "_") if option[1] else option[2]
            found[name] = option[3] or ""
        elif line.startswith(" " * 30) and name:
            found[name] += " " + line.strip()
        else:
            name = ""
    return {key: value.strip() for key, value in found.items()}


@pytest.mark.parametrize(
    ("of_command", "of_python"),
    [
        ("--bounds beta=0.3,0.1: expected", 'bounds={"beta": (0.3, 0.1)}: expected'),
        ("--bounds r_s=50,inf: expected", 'bounds={"r_s": (50, inf)}: expected'),
        ("--fix r_1=1e-3 and --start tau_1=5", 'fix={"r_1": 1e-3} and start={"tau_1": 5}'),
        ("--columns time_s=1 current_A=2", 'columns={"time_s": 1, "current_A": 2}'),
        ("say --units s,mA,V, or --series 4", 'say units="s,mA,V", or series=4'),
        ("or earlier times (--set altitude-steps.*)", "or earlier times (maneuver_options)"),
        ("--set pulses.terms=34 would tell", 'pulses={"terms": 34} would tell'),
        ("a higher one (--set design.step_m=...)", 'a higher one (design={"step_m": ...})'),
        ("`--method joint` fits all", '`method="joint"` fits all'),
        ("option -o: x.py would hide", "option output: x.py would hide"),
    ],
)
def test_messages_name_options_as_one_types_them_here(of_command: str, of_python: str) -> None:
    assert _core.in_python(of_command) == of_python


@pytest.mark.parametrize("function", FUNCTIONS)
def test_options_are_those_of_the_command(function: str) -> None:
    describe, command, of_command, of_function = FUNCTIONS[function]
    theirs = help_of(command)
    ours: dict[str, Description] = {}
    for option in describe():
        if "options" not in option:
            ours[option["name"]] = option
            continue
        prefix = GROUPS.get(option["name"], option["name"].replace("_", "-") + ".")
        if not any(key.startswith(prefix) for key in theirs):
            prefix = option["name"] + "."
        ours |= {prefix + one["name"]: one for one in option["options"]}
    expected = {
        key
        for key in theirs
        if key not in FILES | COMMON | of_command
        and ("." not in key or function not in WITHOUT_SETTINGS)
        and not key.startswith(MANEUVERS)  # keys of fly(maneuver_options=)
    }
    mine = {key for key in ours if not key.startswith("wind.") or "wind." not in of_function}
    assert mine - of_function == expected
    for name in sorted(expected):
        words = ours[name]["help"]
        assert theirs[name].startswith(words), f"{name}: {words!r} and {theirs[name]!r}"
        valid = ours[name]["valid"]
        if " .. " in valid or " | " in valid.removeprefix("true | false"):
            assert valid in theirs[name], name
        default = re.search(r"\(default (.*)\)$", theirs[name])
        if default and ours[name]["default"] != "None":
            assert default[1].replace(" ", "") == ours[name]["default"].replace(" ", ""), name


def test_no_option_is_declared_twice() -> None:
    """What command line and Python share stands in a Visit, and so in neither of them."""
    literal = re.compile(r'"((?:[^"\\]|\\.)*)"')

    def sentences(*folders: str) -> set[str]:
        texts = (p.read_text() for f in folders for p in (ROOT / f).glob("*.cc"))
        joined = (re.sub(r'"\s*\n\s*"', "", text) for text in texts)
        return {s for text in joined for s in literal.findall(text) if s.count(" ") >= 3}

    assert sentences("python/src") & sentences("tools/commands", "tools/cli") == set()
