"""Flights and exports: the numbers of the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import lipoid
from conftest import Lipoid


def test_a_flight_is_that_of_the_program(program: Lipoid, tmp_path: Path) -> None:
    theirs = program(
        "fly",
        "square",
        "--cell",
        "gifi-600mAh-1",
        "--vehicle",
        "mambo-physical",
        "--gusts",
        3,
        "--seed",
        1,
        "-o",
        "flight.csv",
        folder=tmp_path,
    )
    flight = lipoid.fly(
        "square",
        cell="gifi-600mAh-1",
        vehicle="mambo-physical",
        seed=1,
        wind={"gusts_m_per_s": 3.0},
    )
    for key in flight.summary:
        if key != "wall_s":
            assert flight.summary[key] == theirs[key], key
    of_the_run = {"command", "exit_code", "version", "run", "schema", "seed"}
    assert set(theirs) - of_the_run == set(flight.summary)
    written = pd.read_csv(tmp_path / "flight.csv", dtype=float, float_precision="round_trip")
    pd.testing.assert_frame_equal(flight.data, written, check_exact=True)
    assert len(flight.plot()) == 4
    assert "square" in repr(flight)
    assert "outcome" in flight._repr_html_()


def test_says_before_and_after_a_flight_what_the_program_says(
    program: Lipoid, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Three cells in series on a vehicle for one, and an ideal source that cannot carry it."""
    theirs = program("fly", "hover", "--series", 3, folder=tmp_path)
    flight = lipoid.fly("hover", series=3)
    assert flight.summary["messages"] == theirs["messages"]
    assert "is made for 1 cell in series, and this pack has 3" in flight.summary["messages"][0]
    said = [*theirs["messages"], *theirs["doubts"]]
    assert len(said) > 1
    assert caplog.messages == [f"gifi-600mAh-1: {each}" for each in said]
    caplog.clear()
    flight = lipoid.fly("altitude-steps", cell=None, xi=0.6, duration=2.0)
    assert (
        "ideal source, xi = 0.6: altitude-steps: nothing is asked for within 2 s; give"
        in caplog.text
    )
    assert (
        "ideal source, xi = 0.6: mambo-thesis cannot hover on this battery: it would" in caplog.text
    )


def test_a_payload_and_an_aged_pack_are_options_as_of_the_program(
    program: Lipoid, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A cell that gives 63 % of its label, in another size, in the cold: every doubt is said."""
    asked: dict[str, Any] = {
        "series": 4,
        "payload_g": 200.0,
        "capacity_Ah": 5.0,
        "health": 0.8,
        "resistance_factor": 1.5,
        "ambient_degC": 5.0,
        "duration": 5.0,
    }
    words: list[Any] = []
    for name, value in asked.items():
        words += ["--" + name.replace("_", "-"), value]
    theirs = program(
        "fly", "hover", "--cell", "gifi-600mAh-1", "--vehicle", "f450", *words, folder=tmp_path
    )
    flight = lipoid.fly("hover", cell="gifi-600mAh-1", vehicle="f450", **asked)
    for key in ("charge_C", "final_voltage_V", "mass_kg", "capacity_Ah", "final_temperature_degC"):
        assert flight.summary[key] == theirs[key], key
    size = [said for said in caplog.messages if "of its nominal capacity" in said]
    assert len(size) == 1
    said = size[0].removeprefix("gifi-600mAh-1: ").replace("capacity_Ah=7.98", "--capacity-Ah 7.98")
    assert said in theirs["messages"]
    with pytest.raises(lipoid.OptionError, match="are for a cell; an ideal source has xi"):
        lipoid.fly("hover", cell=None, health=0.8)


def test_pack_and_start_are_options_as_of_the_program(program: Lipoid, tmp_path: Path) -> None:
    """A pack of two in parallel, which rested at 3.9 V."""
    theirs = program(
        "fly",
        "hover",
        "--cell",
        "gifi-600mAh-1",
        "--duration",
        5,
        "--parallel",
        2,
        "--initial-voltage-V",
        3.9,
        "-o",
        "flight.csv",
        folder=tmp_path,
    )
    asked = {"duration": 5.0, "parallel": 2, "initial_voltage_V": 3.9}
    flight = lipoid.fly("hover", cell="gifi-600mAh-1", **asked)  # type: ignore[arg-type]
    for key in ("charge_C", "final_voltage_V", "final_soc"):
        assert flight.summary[key] == theirs[key], key
    for wrong in ({"series": 2}, {"initial_soc": 0.5}):
        with pytest.raises(lipoid.OptionError, match="are for a cell; an ideal source has xi"):
            lipoid.fly("hover", cell=None, **wrong)
    with pytest.raises(lipoid.OptionError, match="initial_soc and initial_voltage_V: give one"):
        lipoid.fly("hover", initial_soc=0.5, initial_voltage_V=3.9)
    with pytest.raises(lipoid.OptionError, match="starts full: give a mission, or no start"):
        lipoid.export("gifi-600mAh-1", "thevenin", tmp_path / "c.yaml", initial_soc=0.5)


def test_a_flight_is_a_log_of_its_cell() -> None:
    flight = lipoid.fly("hover", cell="gifi-600mAh-1", duration=5.0)
    log = flight.log()
    predicted = lipoid.Cell.read("gifi-600mAh-1").simulate(log).voltage_V
    # The battery's samples are taken at the start of a step, the prediction at its end.
    assert log.voltage_V is not None
    assert abs(predicted[2:-2] - log.voltage_V[2:-2]).max() < 0.02


def test_a_flight_on_a_cell_that_warms_has_its_temperature() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    flight = lipoid.fly("hover", cell=cell, duration=60.0, ambient_degC=10.0)
    warm = flight.log().temperature_degC
    assert warm is not None
    assert warm[0] == pytest.approx(10.0)
    assert 10.1 < warm[-1] < 25.0
    assert warm[-1] == pytest.approx(flight.summary["final_temperature_degC"], abs=0.01)
    predicted = cell.with_typical_temperature().simulate(flight.log()).voltage_V
    assert predicted == pytest.approx(flight.data["battery_V"].to_numpy(), abs=2e-3)
    assert lipoid.fly("hover", cell=cell, duration=0.1).log().temperature_degC is None


def test_unknown_maneuvers_and_options_name_the_known() -> None:
    with pytest.raises(lipoid.OptionError, match="square"):
        lipoid.fly("squares")
    with pytest.raises(lipoid.OptionError, match="ideal source"):
        lipoid.fly("endurance", cell=None)
    with pytest.raises(lipoid.OptionError, match="simulation"):
        lipoid.fly("hover", substeps=3)  # type: ignore[call-arg]
    with pytest.raises(lipoid.OptionError, match="waypoints=FILE"):
        lipoid.fly("waypoints")


def test_an_export_is_that_of_the_program(program: Lipoid, tmp_path: Path) -> None:
    theirs = program(
        "export", "gifi-600mAh-1", "--to", "thevenin", "-o", "theirs.yaml", folder=tmp_path
    )
    ours = lipoid.export("gifi-600mAh-1", "thevenin", tmp_path / "ours.yaml")
    assert ours["parameters"] == theirs["parameters"]
    assert ours["rmse_V"] == theirs["rmse_V"]
    assert (tmp_path / "ours.yaml").exists()
    assert "thevenin" in lipoid.targets()


def test_a_mission_is_a_log_or_its_file_as_of_the_program(
    program: Lipoid, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = range(0, 2000, 10)
    current = "time_s,current_A\n" + "".join(f"{t},{t // 100 % 2}\n" for t in rows)
    power = "time_s,power_W\n" + "".join(f"{t},{4 * (t // 100 % 2)}\n" for t in rows)
    cell = "gifi-600mAh-1"
    for name, text in (("current.csv", current), ("power.csv", power)):
        mission = tmp_path / name
        mission.write_text(text)
        words = ["export", cell, "--to", "thevenin", "-o", "theirs.yaml", "--mission", mission]
        theirs = program(*words, folder=tmp_path)
        ours = lipoid.export(cell, "thevenin", tmp_path / "ours.yaml", mission=mission)
        assert (ours["rmse_V"], ours["naive"]) == (theirs["rmse_V"], theirs["naive"]), name
    log = lipoid.read_log(tmp_path / "current.csv", voltage_optional=True)
    of_log = lipoid.export(cell, "thevenin", tmp_path / "log.yaml", mission=log)
    of_path = lipoid.export(
        cell, "thevenin", tmp_path / "path.yaml", mission=str(tmp_path / "current.csv")
    )
    assert of_log["rmse_V"] == of_path["rmse_V"]
    caplog.clear()
    log = lipoid.Log(time_s=range(0, 2000, 10), current_A=[1.0] * 200)
    lipoid.export(cell, "thevenin", tmp_path / "log.yaml", mission=log)
    assert "the cell reaches its cut-off of 3 V; " in caplog.text


def test_the_lists() -> None:
    assert "square" in lipoid.maneuvers()
    assert "mambo-physical" in lipoid.vehicles()
    assert "levenberg-marquardt" in lipoid.optimizers()
    assert "gifi-600mAh-1" in lipoid.cells()


def test_a_name_of_the_command_line_within_a_group_is_found() -> None:
    with pytest.raises(lipoid.OptionError, match=r'say wind=\{"gusts_m_per_s": ...\}'):
        lipoid.fly("hover", gusts=3)  # type: ignore[call-arg]


def test_what_flies_an_ensemble_is_said() -> None:
    options: Any = {"ensemble": 20}
    with pytest.raises(
        lipoid.OptionError, match=r"'ensemble'; .* fly on each of cell.resample\(20\)"
    ):
        lipoid.fly("hover", **options)


def test_a_flight_is_no_log() -> None:
    flight: Any = lipoid.fly("hover", duration=0.1)
    with pytest.raises(
        lipoid.OptionError, match=r"expected logs, found a Flight; its log\(\) is one"
    ):
        lipoid.health("gifi-600mAh-1", flight)
