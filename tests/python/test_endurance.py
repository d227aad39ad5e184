"""Endurance: the numbers of the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import lipoid
from conftest import Lipoid


def test_an_endurance_is_that_of_the_program(
    program: Lipoid, result: lipoid.Identification, tmp_path: Path
) -> None:
    result.cell.save(tmp_path / "cell.json")
    theirs = program(
        "endurance",
        "--vehicle",
        "mambo-physical",
        "--cell",
        "cell.json",
        "--health",
        "0.8+-0.05",
        "--payload-g",
        4,
        "--ensemble",
        40,
        "--seed",
        3,
        "--set",
        "step_s=0.1",
        folder=tmp_path,
    )
    made = lipoid.endurance(
        result.cell,
        vehicle="mambo-physical",
        health=(0.8, 0.05),
        payload_g=4,
        ensemble=40,
        seed=3,
        flight={"step_s": 0.1},
    )
    for key in ("minutes", "minutes_interval_95", "charge_Ah", "landing_voltage_V", "ended_by"):
        assert made.summary[key] == theirs[key], key
    low, high = made.minutes_interval_95 or (np.nan, np.nan)
    assert low < made.minutes < high
    assert made.table.loc["minutes", "low_95"] == low
    assert "minutes" in repr(made)
    assert "landing_voltage_V" in made._repr_html_()


def test_a_constant_power_takes_its_energy() -> None:
    """What the battery gave is the power times the time: conservation."""
    power_W = 6.0
    made = lipoid.endurance("gifi-600mAh-1", power=([0.0, 10.0], [0.0, power_W]), reserve=0.3)
    assert made.ended_by == "reserve"
    energy_Wh = power_W * made.minutes / 60.0
    # The current of a step is that of its start: the voltage falls by microvolts over one.
    assert made.summary["energy_Wh"] == pytest.approx(energy_Wh, rel=1e-4)


def test_an_endurance_needs_a_vehicle_or_a_power() -> None:
    with pytest.raises(lipoid.OptionError, match="vehicle or option power"):
        lipoid.endurance("gifi-600mAh-1")
    with pytest.raises(lipoid.OptionError, match="standard error"):
        lipoid.endurance("gifi-600mAh-1", vehicle="mambo-physical", health=(1.0, 2.0, 3.0))  # type: ignore[arg-type]
    with pytest.raises(lipoid.OptionError, match="level flight has no end"):
        lipoid.endurance("gifi-600mAh-1", vehicle="mambo-physical", once=True)
    with pytest.raises(lipoid.OptionError, match="rising times"):
        lipoid.endurance("gifi-600mAh-1", power=([0.0, 0.0], [1.0, 1.0]))


POWER = ([0.0, 10.0, 20.0], [0.0, 3.0, 6.0])


def test_a_power_over_dates_or_durations_is_one_over_seconds() -> None:
    dates = pd.Timestamp("2026-01-01") + pd.to_timedelta(POWER[0], unit="s")
    wanted = lipoid.endurance("gifi-600mAh-1", power=POWER).summary
    for time_s in (dates, dates - dates[0], list(dates), dates.tz_localize("Europe/Berlin")):
        assert lipoid.endurance("gifi-600mAh-1", power=(time_s, POWER[1])).summary == wanted


@pytest.mark.parametrize(
    ("power", "message"),
    [
        (([0.0, 10.0, np.inf], POWER[1]), "rising times that are finite"),
        (([0.0, 10.0, np.nan], POWER[1]), "rising times that are finite"),
        ((POWER[0], [True, True, False]), "power_W: expected numbers, found truth values"),
        ((POWER[0], ["0", "3", "6"]), "power_W: expected numbers, found texts"),
        ((POWER[0], [0j, 3j, 6j]), "power_W: expected numbers, found complex numbers"),
        ((np.zeros((2, 2)), np.zeros((2, 2))), "time_s: expected one dimension, found 2"),
    ],
)
def test_a_power_is_made_of_numbers(power: Any, message: str) -> None:
    with pytest.raises(lipoid.OptionError, match=message):
        lipoid.endurance("gifi-600mAh-1", power=power)


def test_missions_of_the_command_line_name_their_options() -> None:
    for mission in ("power=pw.csv", "waypoints=wp.toml"):
        said = rf"^option mission: .* found '{mission}'; .* waypoints=FILE, .* power=\(times_s, "
        with pytest.raises(lipoid.OptionError, match=said):
            lipoid.endurance("gifi-600mAh-1", mission=mission)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "flags", "word"),
    [
        ({"power": POWER, "payload_g": 5.0}, ["--payload-g", 5], "payload_g"),
        ({"power": POWER, "airspeed_m_per_s": 5.0}, ["--airspeed-m-per-s", 5], "airspeed_m_per_s"),
        ({"power": POWER, "gains": "aware"}, ["--gains", "aware"], "gains"),
        (
            {"power": POWER, "air": {"air_density_kg_per_m3": 1.0}},
            ["--set", "air.air_density_kg_per_m3=1"],
            "air",
        ),
        ({"power": POWER, "mission": "cruise"}, None, "mission"),
        ({"power": POWER, "cruise_speed": "best-range"}, None, "cruise_speed"),
        ({"gains": "aware"}, ["--gains", "aware"], "gains"),
        (
            {"cruise_speed": "best-range"},
            ["--airspeed-m-per-s", "best-range"],
            "cruise_speed",
        ),
        (
            {"mission": "cruise", "cruise_speed": "best-range", "airspeed_m_per_s": 3.0},
            None,
            "cruise_speed",
        ),
    ],
)
def test_what_the_mission_does_not_ask_is_refused(
    options: dict[str, Any],
    flags: list[Any] | None,
    word: str,
    program: Lipoid,
    tmp_path: Path,
) -> None:
    given = dict(options)
    if "power" not in given:
        given["vehicle"] = "mambo-physical"
    with pytest.raises(lipoid.OptionError, match=rf"^options? .*{word}"):
        lipoid.endurance("gifi-600mAh-1", **given)
    if flags is None:  # the command has one option for these, so that they cannot meet
        return
    table = pd.DataFrame({"time_s": POWER[0], "power_W": POWER[1]})
    table.to_csv(tmp_path / "power.csv", index=False)
    mission = ["--mission", "power=power.csv"] if "power" in given else []
    if not mission:
        mission = ["--vehicle", "mambo-physical"]
    cell = ["--cell", "gifi-600mAh-1"]
    assert program("endurance", *cell, *mission, *flags, folder=tmp_path)["exit_code"] == 2


def test_the_summary_says_what_was_flown(program: Lipoid, tmp_path: Path) -> None:
    pack = ["--cell", "gifi-600mAh-1", "--series", 3, "--parallel", 4]
    theirs = program(
        "endurance", *pack, "--vehicle", "f450", "--mission", "cruise", folder=tmp_path
    )
    ours = lipoid.endurance(
        "gifi-600mAh-1", series=3, parallel=4, vehicle="f450", mission="cruise"
    ).summary
    of_the_run = {"command", "exit_code", "run", "version", "wall_s", "over", "seed", "schema"}
    assert {k: v for k, v in theirs.items() if k not in of_the_run} == {
        k: v for k, v in ours.items() if k not in of_the_run
    }
    assert ours["mission"] == "cruise"


def test_a_larger_cell_has_the_heat_of_its_size(program: Lipoid, tmp_path: Path) -> None:
    options = ["--vehicle", "f450", "--cell", "grepow-32Ah-1", "--series", 4]
    size = ["--capacity-Ah", 5, "--ambient-degC", 0]
    theirs = program("endurance", *options, *size, folder=tmp_path)
    ours = lipoid.endurance(
        "grepow-32Ah-1", vehicle="f450", series=4, capacity_Ah=5.0, ambient_degC=0.0
    ).summary
    for key in ("minutes", "landing_voltage_V", "energy_Wh"):
        assert ours[key] == theirs[key], key


def test_a_share_may_be_in_percent_as_on_the_command_line() -> None:
    cell, vehicle = "gifi-600mAh-1", "mambo-physical"
    percent = lipoid.endurance(cell, vehicle=vehicle, reserve="20%")
    assert percent.minutes == lipoid.endurance(cell, vehicle=vehicle, reserve=0.2).minutes
    expected = "option reserve: expected 0% .. 99%, found '200%'"
    with pytest.raises(lipoid.OptionError, match=expected):
        lipoid.endurance(cell, vehicle=vehicle, reserve="200%")


def test_what_is_assumed_of_the_temperature_is_said_as_by_the_program(
    program: Lipoid, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    words = ["--vehicle", "mambo-physical", "--cell", "gifi-600mAh-1", "--capacity-Ah", 0.9]
    theirs = program("endurance", *words, "--ambient-degC", 5, folder=tmp_path)
    assumed = [said for said in theirs["messages"] if "typical values about" in said]
    lipoid.endurance("gifi-600mAh-1", vehicle="mambo-physical", capacity_Ah=0.9, ambient_degC=5)
    assert [said for said in caplog.messages if "typical values about" in said] == assumed
    assert len(assumed) == 1
    assert caplog.messages[1:] == [f"gifi-600mAh-1: {said}" for said in theirs["messages"][1:]]
    caplog.clear()
    lipoid.fly("hover", cell="gifi-600mAh-1", duration=0.1, ambient_degC=5.0)
    lipoid.synthesize("gifi-600mAh-1", ambient_degC=[25.0], rates_C=[2.0])
    said = "gifi-600mAh-1 knows no temperature: typical values about 25 degC are assumed, "
    # Beside it the flight says that loops ring where the battery is nearly empty.
    begun = [message for message in caplog.messages if " loop rings at " not in message]
    assert [message.startswith(said) for message in begun] == [True, True]
    caplog.clear()
    warm = lipoid.Cell.read("gifi-600mAh-1").with_typical_temperature()
    lipoid.endurance(warm, vehicle="mambo-physical", ambient_degC=5)
    lipoid.endurance("gifi-600mAh-1", vehicle="mambo-physical")
    assert "knows no temperature" not in caplog.text
