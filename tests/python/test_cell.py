"""Cells: voltages against an independent solution, ensembles, files."""

from __future__ import annotations

import datetime
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import lipoid
from conftest import Lipoid

T = np.arange(0.0, 1200.0, 2.0)
I = np.where((T >= 60) & (T < 600), 1.2, 0.0)  # noqa: E741


def closed_form(cell: lipoid.Cell, t: np.ndarray, i: np.ndarray) -> np.ndarray:
    """The equations (4.46), (4.50), (4.51) written down again, by NumPy.

    Backward hold: the current of a row flows since the row before. Between rows each state decays
    exactly.
    """
    data = cell.to_dict()
    diffusion = data["diffusion"]
    alpha, beta = diffusion["alpha_C"], diffusion["beta_per_sqrt_s"]
    m = np.arange(1, diffusion["terms"] + 1)
    rates = (beta * m) ** 2
    modes = np.zeros(len(m))
    branch = data["branches"][0]
    r, c = branch["resistance_Ohm"], branch["capacitance_F"]
    v_c, charge = 0.0, 0.0
    tail = 2.0 * (np.pi**2 / 6.0 - np.sum(1.0 / m**2)) / beta**2 if diffusion["tail"] else 0.0
    curve = data["open_circuit_voltage"]
    out = np.empty_like(t)
    for k in range(len(t)):
        if k:
            dt = t[k] - t[k - 1]
            decay = np.exp(-rates * dt)
            modes = modes * decay + i[k] * (1.0 - decay) / rates
            charge += i[k] * dt
            v_c = v_c * np.exp(-dt / (r * c)) + r * i[k] * (1.0 - np.exp(-dt / (r * c)))
        sigma = charge + 2.0 * modes.sum() + tail * i[k] * (k > 0)
        soc = 1.0 - sigma / alpha
        v_oc = np.interp(soc, curve["soc"], curve["voltage_V"])
        out[k] = v_oc - data["series_resistance_Ohm"] * i[k] - v_c
    return out


def test_the_voltage_is_that_of_the_equations() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    rounding_V = 1e-9  # of sums of ten modes over 600 rows
    np.testing.assert_allclose(
        cell.simulate(T, I).voltage_V, closed_form(cell, T, I), rtol=0, atol=rounding_V
    )


def test_many_currents_are_each_alone() -> None:
    cell = lipoid.Cell.read("grepow-32Ah-1").pack(series=4)
    scales = np.linspace(0.0, 30.0, 37)
    many = cell.simulate(T, scales[:, None] * I)
    assert many.voltage_V.shape == (37, len(T))
    for k in (0, 17, 36):
        one = cell.simulate(T, scales[k] * I)
        np.testing.assert_array_equal(many.voltage_V[k], one.voltage_V)
        np.testing.assert_array_equal(many.soc[k], one.soc)
        np.testing.assert_array_equal(many.open_circuit_V[k], one.open_circuit_V)


def test_it_is_what_the_program_simulates(program: Lipoid, tmp_path: Path) -> None:
    import pandas as pd

    pd.DataFrame({"time_s": T, "current_A": I}).to_csv(tmp_path / "current.csv", index=False)
    program("simulate", "gifi-600mAh-1", "--current", "current.csv", "-o", "v.csv", folder=tmp_path)
    written = pd.read_csv(tmp_path / "v.csv", dtype=float, float_precision="round_trip")
    ours = lipoid.Cell.read("gifi-600mAh-1").simulate(T, I).to_pandas()
    pd.testing.assert_frame_equal(ours, written, check_exact=True)


def test_what_was_simulated_stays_when_the_callers_arrays_change() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    time_s, current_A = np.arange(0.0, 60.0), np.full(60, 0.3)
    flown = cell.simulate(time_s, current_A)
    time_s += 1000.0
    current_A[:] = 0.6
    assert flown.time_s[-1] == 59.0
    assert flown.current_A[0] == 0.3
    flown.open_circuit_V[0] = 0.0  # an array of the caller's
    assert flown.open_circuit_V[0] > 3.0


def test_shapes_and_order_are_checked() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    with pytest.raises(lipoid.OptionError, match="do not go with"):
        cell.simulate(T, I[:-1])
    with pytest.raises(lipoid.OptionError, match="times that increase"):
        cell.simulate(T[::-1], I)
    with pytest.raises(lipoid.OptionError, match="hold: expected"):
        cell.simulate(T, I, hold="sideways")  # type: ignore[arg-type]


def test_a_warm_cell_is_written_as_the_program_writes_it(program: Lipoid, tmp_path: Path) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1").with_typical_temperature()
    cell.save(tmp_path / "cell.json")
    frame = pd.DataFrame({"time_s": T, "current_A": I, "temperature_degC": 5.0 + T / 100.0})
    frame.to_csv(tmp_path / "current.csv", index=False)
    # A log that has measured its temperature is as warm as it says, whatever the room was.
    given = ["--current", "current.csv", "-o", "v.csv", "--ambient-degC", 30]
    program("simulate", "cell.json", *given, folder=tmp_path)
    written = pd.read_csv(tmp_path / "v.csv", dtype=float)
    ours = cell.simulate(lipoid.Log(frame), ambient_degC=30.0).to_pandas()
    pd.testing.assert_frame_equal(ours, written, check_exact=True)
    assert list(ours.columns)[-1] == "temperature_degC"


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("DatetimeIndex", lambda t: pd.Timestamp("2026-03-29 00:50") + pd.to_timedelta(t, "s")),
        ("TimedeltaIndex", lambda t: pd.to_timedelta(t, unit="s")),
        (
            "of a zone that changes its clock",
            lambda t: (
                (pd.Timestamp("2026-03-29 00:50") + pd.to_timedelta(t, unit="s"))
                .tz_localize("UTC")
                .tz_convert("Europe/Berlin")
            ),
        ),
        ("datetime64[s]", lambda t: t.astype("datetime64[s]")),
        ("timedelta64[ms]", lambda t: (1000 * t).astype("timedelta64[ms]")),
        (
            "polars",
            lambda t: pytest.importorskip("polars").Series((1000 * t).astype("datetime64[ms]")),
        ),
        (
            "list of datetime",
            lambda t: [
                datetime.datetime(2026, 1, 1) + datetime.timedelta(seconds=one) for one in t
            ],
        ),
        ("list of Timestamp", lambda t: [pd.Timestamp(one, unit="s", tz="UTC") for one in t]),
        ("list of timedelta", lambda t: [datetime.timedelta(seconds=one) for one in t]),
    ],
)
def test_dates_and_durations_are_seconds(name: str, make: Callable[[Any], Any]) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    wanted = cell.simulate(T, I)
    found = cell.simulate(make(T), I)
    np.testing.assert_array_equal(found.voltage_V, wanted.voltage_V, err_msg=name)
    np.testing.assert_array_equal(found.time_s, T)
    np.testing.assert_array_equal(lipoid.Log(time_s=make(T), current_A=I).time_s, T)


@pytest.mark.parametrize(
    ("time_s", "current_A", "message"),
    [
        (T, I > 0, "current_A: expected numbers, found truth values"),
        (T, I + 1j, "current_A: expected numbers, found complex numbers"),
        (T, [str(one) for one in I], "current_A: expected numbers, found texts"),
        (T, np.stack([I, I]) > 0, "current_A: expected numbers, found truth values"),
        (
            np.stack([T, T]).astype("datetime64[s]"),
            np.stack([I, I]),
            "time_s: expected numbers, found dates",
        ),
        (np.arange(len(T)).astype("timedelta64[M]"), I, "time_s: expected times of a fixed length"),
        ([pd.Timestamp(0), pd.Timestamp(1, tz="UTC")], [0.0, 1.0], "all have a time zone or none"),
        (0.0, 1.0, "current_A: expected a column of numbers"),
        (dict(enumerate(T)), I, "expected times or a Log, found a dict"),
        (pd.DataFrame({"time_s": T, "current_A": I}), None, "times or a Log, found a DataFrame"),
        (T, np.zeros((1, 1, len(T))), "current_A: expected one dimension or two, found 3"),
    ],
)
def test_what_is_no_number_is_no_current(time_s: Any, current_A: Any, message: str) -> None:
    with pytest.raises(lipoid.OptionError, match=message):
        lipoid.Cell.read("gifi-600mAh-1").simulate(time_s, current_A)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"initial_soc": 1.0, "initial_voltage_V": 4.0}, "initial_soc and initial_voltage_V"),
        ({"current_A": I}, "the log says its current; leave current_A out"),
        ({"hold": "forward"}, "the log says its hold; leave hold out"),
        ({"ambient_degC": -80.0}, "ambient_degC: expected -60 .. 150, found '-80.0'"),
        ({"threads": -1}, "option threads: expected a whole number of at least 0, found -1"),
        ({"threads": 2.5}, "option threads: expected a whole number"),
        ({"threads": 2**31}, "expected a whole number of at most 2147483647, found 2147483648"),
        ({"initial_soc": [0.5]}, "option initial_soc: expected a number"),
    ],
)
def test_what_contradicts_itself_is_not_dropped(options: dict[str, Any], message: str) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    log = lipoid.Log(time_s=T, current_A=I)
    with pytest.raises(lipoid.OptionError, match=message):
        cell.simulate(log, **options)


def test_packs_are_whole() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    assert cell.pack(np.int64(3)).series == 3  # type: ignore[arg-type]
    for wrong in (2.0, 0, True, 2**40):
        with pytest.raises(lipoid.OptionError, match="option series: expected a whole number"):
            cell.pack(wrong)  # type: ignore[arg-type]


def test_unknown_cells_name_the_known() -> None:
    with pytest.raises(lipoid.LoadError, match="gifi-600mAh-1"):
        lipoid.Cell.read("gifi-600mAh-9")


def test_a_cell_is_not_made_by_its_name() -> None:
    with pytest.raises(TypeError, match=r"Cell\.read"):
        lipoid.Cell()
    with pytest.raises(TypeError, match="identify"):
        lipoid.Cell("gifi-600mAh-1")


def test_an_identification_stands_for_its_cell(result: lipoid.Identification) -> None:
    by_result = lipoid.fly("hover", cell=result, vehicle="mambo-physical", seed=1)
    by_cell = lipoid.fly("hover", cell=result.cell, vehicle="mambo-physical", seed=1)
    assert by_result.summary["charge_C"] == by_cell.summary["charge_C"] > 0.0


def test_files_and_pickles_are_the_same_cell(tmp_path: Path) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-2").pack(3, 2)
    cell.save(tmp_path / "cell.json")
    assert lipoid.Cell.read(tmp_path / "cell.json") == cell
    assert lipoid.Cell.from_dict(json.loads((tmp_path / "cell.json").read_text())) == cell
    assert pickle.loads(pickle.dumps(cell)) == cell
    assert "3S2P" in repr(cell)
    assert "mOhm" in cell._repr_html_()
    assert len(cell.plot()) == 2


def test_a_cell_shows_its_pack_and_that_it_knows_temperature() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    assert "pack" not in cell._repr_html_() and "temperature" not in repr(cell)
    warm = cell.pack(4, 2).with_typical_temperature()
    assert "4 in series, 2 in parallel" in warm._repr_html_()
    assert "temperature</th><td>known, by typical values<" in warm._repr_html_()
    assert repr(warm).endswith("cut-off 3 V, 4S2P, knows temperature)")
    data = warm.to_dict()
    data["temperature"] |= {"assumed": False, "seen_degC": [-10.0, 35.5]}
    assert "known, seen from -10 to 35.5 degC<" in lipoid.Cell.from_dict(data)._repr_html_()


# Before, they were errors of NumPy and pandas: the truth value of an array is ambiguous.
def test_results_that_hold_arrays_are_equal_to_themselves_alone() -> None:
    one = lipoid.Cell.read("gifi-600mAh-1")
    for make in (
        lambda: one.simulate(T, I),
        lambda: lipoid.fly("hover", cell=one, duration=0.1),
        lambda: lipoid.identify_many([], seed=1, threads=1),
    ):
        made = make()
        assert made == made and made != make()


# Before, nanobind told of the overloads of its functions.
def test_none_is_said_to_be_none_by_the_name_of_the_argument(
    result: lipoid.Identification, tmp_path: Path
) -> None:
    none: Any = None
    cell = result.cell
    for argument, call in (
        ("name_or_file", lambda: lipoid.Cell.read(none)),
        ("file", lambda: cell.save(none)),
        ("file", lambda: lipoid.Campaign.read(none)),
        ("cell", lambda: lipoid.synthesize(none)),
        ("cell", lambda: lipoid.validate(none, tmp_path / "log.csv")),
        ("cell", lambda: lipoid.health(none, [lipoid.Log(time_s=T, current_A=I)])),
        ("cell", lambda: lipoid.endurance(none)),
        ("cell", lambda: lipoid.plan(none)),
        ("cell", lambda: lipoid.export(none, "pybamm", tmp_path / "cell.json")),
        ("output", lambda: lipoid.export(cell, "pybamm", none)),
        ("file", lambda: result.report(none)),
        ("file", lambda: lipoid.report(result, none)),
    ):
        with pytest.raises(TypeError, match=f"^{argument}: expected .*, found None$"):
            call()


def test_cells_drawn_have_the_covariance(result: lipoid.Identification) -> None:
    cells = result.cell.resample(2000, seed=3)
    assert cells[7] == result.cell.resample(8, seed=3)[7]
    uncertainty = result.cell.to_dict()["uncertainty"]
    k = uncertainty["parameters"].index("beta")
    sigma = np.sqrt(uncertainty["covariance"][k][k])
    beta = [one.to_dict()["diffusion"]["beta_per_sqrt_s"] for one in cells]
    nu = uncertainty["degrees_of_freedom"]
    # Student's distribution is wider than the normal one; beta is drawn in its logarithm. The
    # standard deviation of 2000 draws is known to 5 % within three sigma.
    expected = sigma * np.sqrt(nu / (nu - 2.0))
    assert np.std(beta) == pytest.approx(expected, rel=0.15)


def test_a_cell_without_uncertainty_says_so() -> None:
    with pytest.raises(lipoid.OptionError, match="no uncertainty"):
        lipoid.Cell.read("gifi-600mAh-1").resample(3)


def test_the_band_holds_the_estimate(result: lipoid.Identification) -> None:
    low, high = result.cell.band(T, I, cells=100)
    voltage_V = result.cell.simulate(T, I).voltage_V
    assert np.mean((low <= voltage_V) & (voltage_V <= high)) > 0.9


def test_the_band_is_as_warm_as_what_is_simulated(
    result: lipoid.Identification, program: Lipoid, tmp_path: Path
) -> None:
    cell = result.cell.with_typical_temperature()
    cell.save(tmp_path / "cell.json")
    frame = pd.DataFrame({"time_s": T, "current_A": I, "temperature_degC": 10.0 + T / 100.0})
    start: list[Any] = ["--initial-voltage-V", 4.1, "--ensemble", 50, "--seed", 3]
    bare = frame.drop(columns="temperature_degC")
    for ambient_degC, initial_degC, given in (
        (None, None, frame),
        (-5.0, None, bare),
        (-5.0, 20.0, bare),
    ):
        given.to_csv(tmp_path / "load.csv", index=False)
        room: list[Any] = [] if ambient_degC is None else ["--ambient-degC", ambient_degC]
        room += [] if initial_degC is None else ["--initial-degC", initial_degC]
        files = ["--current", "load.csv", "-o", "v.csv"]
        program("simulate", "cell.json", *files, *start, *room, folder=tmp_path)
        theirs = pd.read_csv(tmp_path / "v.csv", dtype=float)
        low_V, high_V = cell.band(
            lipoid.Log(given),
            cells=50,
            seed=3,
            initial_voltage_V=4.1,
            ambient_degC=ambient_degC,
            initial_degC=initial_degC,
        )
        rows = len(theirs)  # before the cut-off
        assert rows > len(T) // 4
        np.testing.assert_array_equal(low_V[:rows], theirs["voltage_low_V"])
        np.testing.assert_array_equal(high_V[:rows], theirs["voltage_high_V"])
        assert np.isnan(low_V[rows:]).all() and np.isnan(high_V[rows:]).all()
    warm = cell.band(T, I, cells=50, seed=3, temperature_degC=frame["temperature_degC"])
    assert np.nanmax(np.abs(warm[0] - cell.band(T, I, cells=50, seed=3)[0])) > 0.01


# Before, it went on to minus 119 V.
def test_the_band_ends_where_the_cell_is_below_its_cutoff(
    result: lipoid.Identification, caplog: pytest.LogCaptureFixture
) -> None:
    t, i = np.arange(0.0, 10_000.0, 100.0), np.ones(100)
    made = result.cell.simulate(t, i)
    caplog.clear()
    low_V, high_V = result.cell.band(t, i, cells=20)
    assert 0 < made.rows < 100
    np.testing.assert_array_equal(np.isnan(low_V), np.isnan(made.voltage_V))
    np.testing.assert_array_equal(np.isnan(high_V), np.isnan(made.voltage_V))
    assert f"the {made.rows} of 100 rows above it" in caplog.text
    caplog.clear()
    every_V, _ = result.cell.band(t, i, cells=20, beyond_cutoff=True)
    assert np.isfinite(every_V).all() and "cut-off" not in caplog.text
    np.testing.assert_array_equal(every_V[: made.rows], low_V[: made.rows])


def test_what_cannot_be_drawn_is_said(result: lipoid.Identification) -> None:
    cell = result.cell
    for options, message in (
        ({"current_A": np.where(T == 4.0, np.nan, I)}, "band: expected finite times and currents"),
        ({"time_s": T[::-1]}, "band: expected times that increase"),
        ({"time_s": 0.0 * T}, "band: expected times that increase"),
        ({"time_s": T[1:]}, "band: times .* do not go with currents"),
        ({"current_A": np.stack([I, I])}, "current_A: expected one dimension, found 2"),
        ({"cells": 1}, "option cells: expected a whole number of at least 2, found 1"),
        ({"cells": 2.5}, "option cells: expected a whole number"),
        ({"seed": -1}, "option seed: expected a whole number of at least 0, found -1"),
        ({"seed": 2**64}, "option seed: expected a whole number of at most 18446744073709551615"),
    ):
        given: dict[str, Any] = {"time_s": T, "current_A": I, "cells": 3}
        with pytest.raises(lipoid.OptionError, match=message):
            cell.band(**(given | options))
    for count in (-1, 2.5, 100_001, 2**33):  # at 10^8 memory was out
        with pytest.raises(lipoid.OptionError, match="option count: expected a whole number"):
            cell.resample(count)  # type: ignore[arg-type]
    assert len(cell.resample(1, seed=2**64 - 1)) == 1


def test_a_cell_in_the_cold_is_that_of_the_program(program: Lipoid, tmp_path: Path) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1").with_typical_temperature()
    cell.save(tmp_path / "cell.json")
    t = np.arange(0.0, 400.0, 2.0)
    i = np.where(t > 10.0, 2.0, 0.0)
    pd.DataFrame({"time_s": t, "current_A": i}).to_csv(tmp_path / "load.csv", index=False)
    program(
        "simulate",
        "cell.json",
        "--current",
        "load.csv",
        "--current-sign",
        "discharge-positive",
        "--ambient-degC",
        -5,
        "-o",
        "out.csv",
        folder=tmp_path,
    )
    theirs = pd.read_csv(tmp_path / "out.csv", float_precision="round_trip")
    made = cell.simulate(t, i, ambient_degC=-5.0)
    assert made.temperature_degC is not None
    assert np.array_equal(made.voltage_V[: len(theirs)], theirs["voltage_V"])
    # It warms by its losses; as a measurement the same temperatures give the same voltages.
    assert made.temperature_degC[0] == pytest.approx(-5.0)
    assert made.temperature_degC[-1] > -4.0
    warm = cell.simulate(t, np.stack([i, i]), temperature_degC=made.temperature_degC)
    assert warm.voltage_V.shape == (2, len(t))
    assert np.allclose(warm.voltage_V[1], made.voltage_V, atol=2e-3)
    assert np.all(cell.simulate(t, i).voltage_V[10:] > made.voltage_V[10:])


def test_temperatures_that_do_not_go_with_the_currents() -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    t = np.arange(5.0)
    with pytest.raises(lipoid.OptionError, match="temperature for each row"):
        cell.simulate(t, t, temperature_degC=[1.0, 2.0])
    with pytest.raises(lipoid.OptionError, match="not both"):
        cell.simulate(t, t, temperature_degC=t, ambient_degC=3.0)


# Before, they were taken without a word, and those in kelvin gave a hot cell.
@pytest.mark.parametrize(
    ("temperature_degC", "message"),
    [
        (
            [298.15, 299.0],
            "298.15 degC at 0 s is not within -60 to 150, but the whole column would",
        ),
        ([20.0, -300.0], "-300 degC at 1 s is not within -60 to 150$"),
        ([[20.0, 21.0], [20.0, 1e9]], r"1e\+09 degC at 1 s is not within -60 to 150$"),
    ],
)
def test_temperatures_of_no_cell_are_refused(temperature_degC: Any, message: str) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1").with_typical_temperature()
    t = np.arange(2.0)
    with pytest.raises(lipoid.OptionError, match="simulate: temperature_degC: " + message):
        cell.simulate(t, np.ones((2, 2)), temperature_degC=temperature_degC)
    if np.ndim(temperature_degC) == 1:
        with pytest.raises(lipoid.OptionError, match="band: temperature_degC: " + message):
            cell.band(t, t, temperature_degC=temperature_degC)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"initial_soc": 5.0}, r"option initial_soc: expected -0.5 .. 1.5, found '5.0'"),
        ({"initial_soc": float("nan")}, "option initial_soc: expected -0.5 .. 1.5, found 'nan'"),
        ({"time_s": [], "current_A": []}, "simulate: expected at least one row"),
    ],
)
def test_what_cannot_be_simulated_is_said(options: dict[str, Any], message: str) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    given: dict[str, Any] = {"time_s": [0.0, 1.0], "current_A": [1.0, 1.0]}
    with pytest.raises(lipoid.OptionError, match=message):
        cell.simulate(**(given | options))
    with pytest.raises(lipoid.OptionError, match="expected at least one log"):
        lipoid.validate(cell, [])


def test_a_cell_that_knows_no_temperature_says_so(caplog: pytest.LogCaptureFixture) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    cell.simulate(T, I, ambient_degC=-10.0)
    assert "gifi-600mAh-1 knows no temperature: ambient_degC changes nothing" in caplog.text
    caplog.clear()
    cell.with_typical_temperature().simulate(T, I, ambient_degC=-10.0)
    assert caplog.text == ""


def test_what_a_log_measured_counts_and_is_said(caplog: pytest.LogCaptureFixture) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1").with_typical_temperature()
    log = lipoid.Log(pd.DataFrame({"time_s": T, "current_A": I, "temperature_degC": 25.0}))
    measured_V = cell.simulate(log).voltage_V
    assert caplog.text == ""
    for name, made in (
        ("ambient_degC", cell.simulate(log, ambient_degC=40.0)),
        ("initial_degC", cell.simulate(log, initial_degC=40.0)),
    ):
        said = f"the log has temperature_degC, which is used in place of {name}"
        assert said in caplog.text
        np.testing.assert_array_equal(made.voltage_V, measured_V)
    frame = pd.DataFrame({"time_s": T, "current_A": I, "voltage_V": measured_V})
    whole = lipoid.Log(frame[np.isfinite(measured_V)].assign(temperature_degC=25.0))
    caplog.clear()
    lipoid.validate(cell, whole, initial_degC=40.0)
    assert "which is used in place of initial_degC" in caplog.text
    caplog.clear()
    lipoid.validate(cell, whole, initial_degC=40.0, predict_temperature=True)
    assert "in place of" not in caplog.text


def test_temperatures_that_were_never_seen_are_said(caplog: pytest.LogCaptureFixture) -> None:
    given = lipoid.Cell.read("gifi-600mAh-1").with_typical_temperature().to_dict()
    given["temperature"]["seen_degC"] = [10.0, 40.0]
    cell = lipoid.Cell.from_dict(given)
    cell.simulate(T, I, ambient_degC=6.0)
    cell.simulate(T, I)
    assert caplog.text == ""
    cell.simulate(T, I, ambient_degC=-10.0)
    assert "was identified from logs between 10 and 40 degC: at -10 degC" in caplog.text
    caplog.clear()
    cell.simulate(T, I, temperature_degC=np.linspace(20.0, 60.0, len(T)))
    assert "at 60 degC its resistances" in caplog.text


def test_drawn_cells_that_were_moved_are_said(caplog: pytest.LogCaptureFixture) -> None:
    """Branches of no resistance with wide errors: nearly every draw has a negative one."""
    given = lipoid.Cell.read("gifi-600mAh-1").to_dict()
    branch = {"resistance_Ohm": 0.0, "time_constant_s": 30.0}
    given["branches"] = [branch] * 3
    names = ["r_s", "r_1", "r_2", "r_3"]
    wide = [[1e-4 if i == j else 0.0 for j in range(4)] for i in range(4)]
    given["uncertainty"] = {"parameters": names, "covariance": wide, "degrees_of_freedom": 50}
    cell = lipoid.Cell.from_dict(given)
    t, i = np.arange(0.0, 60.0), np.full(60, 0.6)
    for ask in (
        lambda: cell.resample(200),
        lambda: cell.band(t, i),
        lambda: lipoid.endurance(cell, vehicle="mambo-physical", reserve=0.7, ensemble=40),
    ):
        caplog.clear()
        ask()
        assert "moved to the nearest that one may have" in caplog.text
    given["branches"] = []
    given["uncertainty"] |= {"parameters": ["r_s"], "covariance": [[1e-6]]}
    caplog.clear()
    few = lipoid.Cell.from_dict(given)
    few.resample(200)
    assert not caplog.text
    few.band(t, i, cells=20)
    lipoid.endurance(few, vehicle="mambo-physical", reserve=0.7, ensemble=20)
    assert "of 20 cells the interval is that from the lowest to the highest" in caplog.text
    assert "of 20 flights the interval is that from the lowest to the highest" in caplog.text


def test_a_simulation_ends_at_the_cutoff_as_that_of_the_program(
    program: Lipoid, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    t, i = np.arange(0.0, 10_000.0, 100.0), np.ones(100)
    pd.DataFrame({"time_s": t, "current_A": i}).to_csv(tmp_path / "current.csv", index=False)
    files = ["--current", "current.csv", "-o", "v.csv"]
    told = program("simulate", "gifi-600mAh-1", *files, folder=tmp_path)["logs"][0]
    cell = lipoid.Cell.read("gifi-600mAh-1")
    made = cell.simulate(t, i)
    assert 0 < told["rows"] < 100
    assert np.isnan(made.voltage_V).sum() == np.isnan(made.soc).sum() == 100 - told["rows"]
    assert len(made.to_pandas()) == made.rows == told["rows"]
    np.testing.assert_allclose(
        made.to_pandas()["voltage_V"], pd.read_csv(tmp_path / "v.csv")["voltage_V"], atol=1e-9
    )
    (said,) = caplog.messages
    at_s = round(told["cutoff_s"], 2)
    assert f"cut-off of 3 V at {at_s:.10g} s under 1 A: the {told['rows']} of" in said
    assert f"{told['rows']} before the cut-off" in repr(made)
    every = cell.simulate(t, i, beyond_cutoff=True)
    assert np.isfinite(every.voltage_V).all() and every.rows == 100
    assert every.soc[-1] < 0.0
    assert "rows outside the soc" in caplog.messages[1] and len(caplog.messages) == 2
    both = cell.simulate(t, np.stack([0.0 * i, i]))
    np.testing.assert_array_equal(both.rows, [100, told["rows"]])
    assert "under 1 of 2 currents; current 1 at" in caplog.messages[-1]


def test_a_file_is_no_current() -> None:
    with pytest.raises(lipoid.OptionError, match=r"found 'file.csv'; a file is read by"):
        lipoid.Cell.read("gifi-600mAh-1").simulate("file.csv")


def test_packing_a_pack_says_how_many_there_are() -> None:
    pack = lipoid.Cell.read("gifi-600mAh-1").pack(3).pack(2)
    assert (pack.series, pack.parallel) == (2, 1)
    assert "is 2 in series" in (lipoid.Cell.pack.__doc__ or "")


def test_lines_of_resistances_can_be_told_apart(result: lipoid.Identification) -> None:
    for cell in (lipoid.Cell.read("gifi-600mAh-1"), result.cell):
        lines = cell.plot()[1].get_lines()
        assert len({line.get_color() for line in lines}) == len(lines) > 1


def test_what_no_cell_holds_is_told(
    program: Lipoid, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    t = np.arange(0.0, 2000.0, 10.0)
    cell = lipoid.Cell.read("gifi-600mAh-1")
    pd.DataFrame({"time_s": t, "current_A": np.full(200, -0.6)}).to_csv(
        tmp_path / "current.csv", index=False
    )
    files = ["--current", "current.csv", "-o", "v.csv", "--current-sign", "discharge-positive"]
    told = program("simulate", "gifi-600mAh-1", *files, folder=tmp_path)["logs"][0]
    made = cell.simulate(t, np.full(200, -0.6))
    outside, overfull = caplog.messages
    assert f"{told['rows_outside_curve']} rows outside the soc that v_oc(A) was made for" in outside
    assert f"to a soc of {made.soc.max():.3g}, which no cell holds" in overfull
    caplog.clear()
    cell.simulate(t, np.full((2, 200), 0.1))
    assert not caplog.messages


def test_a_curve_says_where_it_is_continued(caplog: pytest.LogCaptureFixture) -> None:
    cell = lipoid.Cell.read("gifi-600mAh-1")
    assert cell.open_circuit_voltage(0.5).shape == ()
    assert cell.open_circuit_voltage([[0.0, 0.5, 1.0]]).shape == (1, 3)
    assert not caplog.messages
    cell.open_circuit_voltage([-1, 2, 0.5])
    assert "2 rows outside the soc that v_oc(A) was made for" in caplog.text
    with pytest.raises(lipoid.OptionError, match="soc: expected numbers, found texts"):
        cell.open_circuit_voltage("a")
    with pytest.raises(TypeError, match="soc: expected states of charge, found None"):
        cell.open_circuit_voltage(None)  # type: ignore[arg-type]


def test_a_dictionary_is_a_cell_with_its_doubts(caplog: pytest.LogCaptureFixture) -> None:
    data = lipoid.Cell.read("gifi-600mAh-1").to_dict()
    data["capacity_Ah"] = np.float32(0.5)
    data["run"]["metrics"] = {"verdict": {"grade": "poor", "reasons": ["it is odd"]}}
    assert lipoid.Cell.from_dict(data).capacity_Ah == 0.5
    assert "judged its fit poor: do not rely on what it predicts (it is odd)" in caplog.text
    data["capacity_Ah"] = 0.5j
    with pytest.raises(
        TypeError, match="from_dict: expected numbers, texts and lists of them, found"
    ):
        lipoid.Cell.from_dict(data)
