"""Endurance: the numbers of the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
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
