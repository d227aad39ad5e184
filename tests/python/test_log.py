"""Logs: from arrays without a copy, from tables of other libraries, from files."""

from __future__ import annotations

import copy
import os
import pickle
import resource
import struct
import warnings
from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import lipoid
from conftest import ROOT

N = 600
T = np.arange(0.0, N)
I = np.where((T > 10) & (T < 300), 1.0, 0.0)  # noqa: E741
V = 4.1 - 0.05 * I - 1e-4 * np.clip(T - 10, 0, 290)


def same_memory(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(a.__array_interface__["data"][0] == b.__array_interface__["data"][0])


def test_contiguous_columns_are_not_copied() -> None:
    log = lipoid.Log(time_s=T, current_A=I, voltage_V=V)
    assert same_memory(log.time_s, T)
    assert same_memory(log.current_A, I)
    assert log.voltage_V is not None and same_memory(log.voltage_V, V)


def test_a_million_rows_take_no_further_memory() -> None:
    rows = 1_000_000
    t = np.arange(0.0, rows)
    i = np.where(t % 600 < 100, 1.0, 0.0)
    v = 4.1 - 0.05 * i - 1e-7 * t
    lipoid.Log(time_s=T, current_A=I, voltage_V=V)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    logs = [lipoid.Log(time_s=t, current_A=i, voltage_V=v) for _ in range(20)]
    campaigns = [lipoid.Campaign(cutoff_V=3.0, pulses=[log]) for log in logs]
    held = [campaign.logs() for campaign in campaigns]
    grown_kB = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    # One copy of the three columns is 24,000 kB, those of twenty logs 480,000 kB. What is left is
    # the scratch of one look at the sign.
    assert grown_kB < 40_000
    assert same_memory(held[0][0].time_s, t)


def test_an_array_outlives_its_names() -> None:
    def made() -> lipoid.Log:
        t = np.arange(0.0, N)
        return lipoid.Log(time_s=t, current_A=I.copy(), voltage_V=V.copy())

    log = made()
    view = log.current_A
    del log
    _ = [np.full(N, 7.0) for _ in range(100)]
    np.testing.assert_array_equal(view, I)


def test_views_cannot_be_written_to() -> None:
    log = lipoid.Log(time_s=T, current_A=I, voltage_V=V)
    with pytest.raises(ValueError, match="read-only"):
        log.time_s[0] = 5.0


def test_a_current_of_the_other_sign_is_turned_and_left_alone() -> None:
    negative = -I
    log = lipoid.Log(time_s=T, current_A=negative, voltage_V=V)
    assert log.sign == "discharge-negative"
    np.testing.assert_array_equal(log.current_A, I)
    np.testing.assert_array_equal(negative, -I)


@pytest.mark.parametrize("library", ["dict", "pandas", "polars", "pyarrow"])
def test_tables_of_other_libraries(library: str) -> None:
    columns = {"time_s": T, "current_A": I, "voltage_V": V, "temperature_degC": np.full(N, 25.0)}
    if library == "dict":
        log = lipoid.Log(columns)
    elif library == "pandas":
        log = lipoid.Log(pd.DataFrame(columns))
    elif library == "polars":
        log = lipoid.Log(pytest.importorskip("polars").DataFrame(columns))
    else:
        log = lipoid.Log(pytest.importorskip("pyarrow").table(columns))
    np.testing.assert_array_equal(log.voltage_V, V)
    assert log.temperature_degC is not None
    pd.testing.assert_frame_equal(log.to_pandas(), pd.DataFrame(columns))


def test_other_types_of_numbers_and_strides() -> None:
    log = lipoid.Log(time_s=range(N), current_A=np.stack([I, I]).T[:, 0], voltage_V=V.astype("f4"))
    np.testing.assert_array_equal(log.current_A, I)
    assert log.time_s.dtype == np.float64


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"time_s": T, "current_A": I[:-1], "voltage_V": V}, "equal lengths"),
        ({"time_s": T[::-1].copy(), "current_A": I, "voltage_V": V}, "expected time to increase"),
        ({"time_s": T, "current_A": np.where(T == 41, np.nan, I), "voltage_V": V}, "finite number"),
        ({"time_s": T[:0], "current_A": I[:0], "voltage_V": V[:0]}, "found empty columns"),
    ],
)
def test_what_cannot_be_is_refused(columns: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(lipoid.LoadError, match=message) as error:
        lipoid.Log(columns, name="mine")
    assert error.value.file == "mine"


def test_the_row_of_an_error_counts_from_one() -> None:
    with pytest.raises(lipoid.LoadError) as error:
        lipoid.Log(time_s=T, current_A=np.where(T == 41, np.nan, I), voltage_V=V)
    assert error.value.line == 42


def test_a_wrong_option_names_the_right_one() -> None:
    with pytest.raises(lipoid.OptionError, match="Did you mean 'current_sign'"):
        lipoid.Log(time_s=T, current_A=I, voltage_V=V, curent_sign="auto")  # type: ignore[call-arg]


def test_repeated_times_are_dropped_and_counted() -> None:
    t = T.copy()
    t[100] = t[99]
    log = lipoid.Log(time_s=t, current_A=I, voltage_V=V)
    assert len(log) == N - 1
    assert log.inspect()["dropped_repeated_times"] == 1


def test_segments_and_picture(lab: Path) -> None:
    log = lipoid.read_log(lab / "pulses.csv")
    kinds = set(log.segments["kind"])
    assert {"rest", "pulse"} <= kinds
    assert "rows" in repr(log)
    assert "looks like" in log._repr_html_()
    assert len(log.plot()) == 2


def test_a_log_survives_pickling(lab: Path) -> None:
    log = lipoid.read_log(lab / "pulses.csv")
    again = pickle.loads(pickle.dumps(log))
    pd.testing.assert_frame_equal(again.to_pandas(), log.to_pandas())
    assert (again.sign, again.file) == (log.sign, log.file)


def test_a_pickled_log_of_another_version_is_refused(lab: Path) -> None:
    core: Any = lipoid.read_log(lab / "pulses.csv")._core
    state = core.__getstate__()
    kind: Any = type(core)
    for other, says in [
        (state[:-1], "another version"),
        ((*state[:-1], state[-1][:-1]), "another version"),
        ((*state[:1], state[1][:-1], *state[2:]), "equally long"),
    ]:
        with pytest.raises(ValueError, match=says):
            kind.__new__(kind).__setstate__(other)


FLIGHTS = ROOT / "fixtures" / "flights"


@pytest.mark.parametrize("way", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
@pytest.mark.parametrize("name", ["log171.bin", "esc_status_log.ulg", "gaps.csv", "thinned"])
def test_a_copy_of_a_log_knows_what_reading_found(
    name: str, way: Callable[[lipoid.Log], lipoid.Log], lab: Path, tmp_path: Path
) -> None:
    options: dict[str, Any] = {}
    file = FLIGHTS / name
    if name == "gaps.csv":
        t = np.concatenate([T, T + 5000.0])
        table = np.column_stack([t, np.tile(I, 2), np.tile(V, 2)])
        file = tmp_path / "gaps\udcfc.csv"
        text = "\n".join(",".join(map(repr, map(float, row))) for row in table)
        cut = "\n6000.0,0.0,4.0\n6000.0,0.0,4.0\n6001"
        file.write_text("time_s,current_A,voltage_V\n" + text + cut)
    elif name == "thinned":
        file, options = lab / "low_rate.csv", {"most_rows": 1024}
    log = lipoid.read_log(file, **options)
    again = way(log)
    pd.testing.assert_frame_equal(again.to_pandas(), log.to_pandas(), check_exact=True)
    assert (again.file, again.hold) == (log.file, log.hold)
    assert again._core.reading() == log._core.reading()
    assert again.inspect() == log.inspect()


def test_the_health_of_a_copied_flight_is_the_same() -> None:
    log = lipoid.read_log(FLIGHTS / "log171.bin")
    found = lipoid.health("grepow-32Ah-1", log, series=4)
    again = lipoid.health("grepow-32Ah-1", pickle.loads(pickle.dumps(log)), series=4)
    assert again.summary == found.summary


def test_errors_of_files_have_a_place(tmp_path: Path) -> None:
    file = tmp_path / "bad.csv"
    file.write_text("time_s,current_A,voltage_V\n0,0,4.1\n1,x,4.1\n")
    with pytest.raises(lipoid.LoadError, match=r"bad\.csv:3:3: error: expected a number") as error:
        lipoid.read_log(file)
    assert (error.value.file, error.value.line, error.value.column) == (str(file), 3, 3)
    assert isinstance(error.value, ValueError)
    again = pickle.loads(pickle.dumps(error.value))
    assert (str(again), again.line) == (str(error.value), 3)


@pytest.mark.parametrize("number", [1, True])
def test_a_number_is_no_file(number: Any) -> None:
    before = os.fstat(1)
    with pytest.raises(TypeError, match="expected str, bytes or"):
        lipoid.read_log(number)
    assert os.fstat(1) == before  # standard output is open still


def test_columns_of_one_name_are_several() -> None:
    pyarrow = pytest.importorskip("pyarrow")
    names = ["time_s", "current_A", "current_A", "voltage_V"]
    with pytest.raises(lipoid.OptionError, match="several columns are called current_A"):
        lipoid.Log(pyarrow.table([T, I, I, V], names=names))
    with pytest.raises(lipoid.OptionError, match="several columns are called current_A"):
        lipoid.Log(pd.DataFrame(np.column_stack([T, I, I, V]), columns=names))
    # Others may be there as often as they like.
    spare = pyarrow.table([T, I, V, V, V], names=["time_s", "current_A", "voltage_V", "x", "x"])
    assert len(lipoid.Log(spare)) == N


def test_a_missing_file_is_a_load_error() -> None:
    with pytest.raises(lipoid.LoadError, match="found no file of this name") as error:
        lipoid.read_log("nowhere.csv")
    assert error.value.file == "nowhere.csv"


def test_times_may_be_dates_or_durations() -> None:
    dates = pd.date_range(
        "2026-03-29 00:59", periods=N, freq="s", tz="Europe/Berlin"
    )  # summer time
    table = pd.DataFrame({"current_A": I, "voltage_V": V}, index=dates)
    for log in (
        lipoid.Log(table),
        lipoid.Log(table.set_index(pd.to_timedelta(T, unit="s"))),
        lipoid.Log(table.set_index(pd.Index(T, name="time_s"))),
        lipoid.Log(time_s=table.index, current_A=I, voltage_V=V),
        lipoid.Log(time_s=pd.Series(dates), current_A=I, voltage_V=V),
        lipoid.Log(time_s=dates.tz_localize(None).to_numpy(), current_A=I, voltage_V=V),
    ):
        np.testing.assert_allclose(log.time_s, T, rtol=0, atol=1e-9)


def test_warnings_name_options_as_python_has_them() -> None:
    (warning,) = lipoid.Log(time_s=T, current_A=np.full(N, -1.0)).warnings
    assert warning.endswith('say `current_sign` (current_sign="discharge-negative")')


def test_a_lazy_frame_is_collected() -> None:
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame({"time_s": T, "current_A": I, "voltage_V": V})
    np.testing.assert_array_equal(lipoid.Log(frame.lazy()).current_A, I)
    with warnings.catch_warnings():  # of polars, that its columns are looked for
        warnings.simplefilter("error")
        lipoid.validate("gifi-600mAh-1", frame.lazy())


COLUMNS: dict[str, Any] = {"time_s": T, "current_A": I, "voltage_V": V}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"time_s": 1.0}, "time_s: expected a column of numbers, found 1.0"),
        (
            {"voltage_V": dict(enumerate(V))},
            "voltage_V: expected a column of numbers, found {0",
        ),
        ({"time_s": "abc"}, "time_s: expected a column of numbers, found 'abc'"),
        ({"current_A": ["1"] * N}, "current_A: expected numbers, found texts or other objects"),
        ({"current_A": I > 0}, "current_A: expected numbers, found truth values"),
        ({"current_A": np.array(T, dtype="M8[s]")}, "current_A: expected numbers, found dates"),
        ({"time_s": T.reshape(2, -1)}, "time_s: expected one dimension, found 2"),
        ({"time_s": None}, "Log: time_s is missing$"),
        ({"time_s": None, "time": T}, "Log: time_s is missing; unknown: time"),
        ({"data": np.c_[T, I, V], "time_s": None}, "found ndarray; arrays are given by name"),
        ({"data": "pulses.csv", "time_s": None}, "files are read by lipoid.read_log"),
        (
            {"data": pd.DataFrame({"t": T, "i": I}), "time_s": None},
            "Log: time_s is missing; found t, i",
        ),
    ],
)
def test_what_is_no_log_is_said(given: dict[str, Any], message: str) -> None:
    with pytest.raises(lipoid.OptionError, match=message):
        lipoid.Log(**(COLUMNS | given))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"time_s": [], "current_A": [], "voltage_V": []}, "expected rows, found empty columns"),
        ({"time_s": T[::-1]}, "log:2:1: error: expected time to increase, found 598 s after 599 s"),
        ({"voltage_V": np.where(T == 5, np.nan, V)}, "log:6:1: error: expected a finite number"),
        ({"current_A": [None, *I[1:]]}, "log:1:1: error: expected a finite number in current_A"),
        ({"time_s": T[1:]}, "expected columns of equal lengths, found 599 rows of time_s and 600"),
    ],
)
def test_rows_that_are_wrong_are_named(given: dict[str, Any], message: str) -> None:
    with pytest.raises(lipoid.LoadError, match=message):
        lipoid.Log(**(COLUMNS | given))


# Before, a current_a was said to be missing, and a Voltage(V) was left out without a word.
@pytest.mark.parametrize(
    ("names", "message"),
    [
        (
            ("time_s", "current_a", "voltage_V"),
            r"current_A is missing; .*; current_A=table\['current_a'\] may be it$",
        ),
        (
            ("time_s", "current_A", "Voltage(V)"),
            r"voltage_V is missing; .*table\['Voltage\(V\)'\] may be it$",
        ),
        (
            ("Test_Time(s)", "current_A", "voltage_V"),
            r"time_s=table\['Test_Time\(s\)'\] may be it$",
        ),
        (("time_s", "I [mA]", "U"), r"current_A=table\['I \[mA\]'\] may be it, which is in mA$"),
    ],
)
def test_the_likely_column_of_a_table_is_named(names: tuple[str, ...], message: str) -> None:
    table = pd.DataFrame(np.column_stack([T, I, V]), columns=list(names))
    with pytest.raises(lipoid.OptionError, match=message):
        lipoid.Log(table)
    assert len(lipoid.Log(time_s=table[names[0]], current_A=table[names[1]])) == N


# Before, Python ended by a segmentation fault.
@pytest.mark.parametrize("current_A", [I, np.ones(N)], ids=["pulse", "discharge"])
def test_a_log_without_voltage_is_inspected(current_A: np.ndarray) -> None:
    log = lipoid.Log(time_s=T, current_A=current_A)
    assert log.inspect()["voltage_V"] is None
    assert log.segments["charge_C"].sum() == pytest.approx(current_A[1:].sum())
    assert "looks like" in log._repr_html_()


@pytest.mark.parametrize("kind", ["pulses", "low_rate", "constant_current", "validation", "flight"])
def test_a_log_without_voltage_is_for_no_fit(lab: Path, tmp_path: Path, kind: str) -> None:
    message = "error: expected a log with voltages, found none"
    kinds: dict[str, Any] = {"low_rate": lab / "low_rate.csv", "pulses": lab / "pulses.csv"}
    kinds[kind] = lipoid.Log(time_s=T, current_A=I)
    with pytest.raises(lipoid.LoadError, match=message):
        lipoid.identify(lipoid.Campaign(cutoff_V=3.0, capacity_Ah=0.6, **kinds))
    file = tmp_path / "current.csv"
    pd.DataFrame({"time_s": T, "current_A": I}).to_csv(file, index=False)
    kinds[kind] = lipoid.read_log(file, voltage_optional=True)
    with pytest.raises(lipoid.LoadError, match=message):
        lipoid.compare(lipoid.Campaign(cutoff_V=3.0, capacity_Ah=0.6, **kinds), optimizers="sqp")
    with pytest.raises(lipoid.LoadError, match="error: expected a voltage to compare with"):
        lipoid.validate("gifi-600mAh-1", kinds[kind])


def test_numbers_of_other_types_are_numbers() -> None:
    whole = lipoid.Log(time_s=list(range(N)), current_A=I.astype(int), voltage_V=V.astype("f4"))
    np.testing.assert_array_equal(whole.time_s, T)
    decimals = [Decimal(str(one)) for one in V]
    log = lipoid.Log(time_s=T, current_A=I, voltage_V=decimals)
    np.testing.assert_array_equal(log.voltage_V, [float(one) for one in decimals])


def test_a_long_log_is_thinned_where_that_is_asked_for(lab: Path) -> None:
    file = lab / "low_rate.csv"
    every = lipoid.read_log(file)
    thin = lipoid.read_log(file, most_rows=1024)
    assert len(every) == every.rows_of_source > 20_000
    assert thin.rows_of_source == len(every)
    assert len(thin) <= 1024
    assert f"{len(thin)} rows that stand for {len(every)}" in repr(thin)
    assert f"{len(thin)} rows that stand for {len(every)}" in thin._repr_html_()
    assert "stand for" not in repr(every)

    # No charge is lost: the sum of what each row stands for.
    def charge_C(log: lipoid.Log) -> float:
        assert log.hold == "backward"
        return float(np.sum(log.current_A[1:] * np.diff(log.time_s)))

    assert charge_C(thin) == pytest.approx(charge_C(every), rel=1e-9)
    again = pickle.loads(pickle.dumps(thin))
    assert (len(again), again.rows_of_source) == (len(thin), len(every))
    with pytest.raises(lipoid.OptionError, match="most_rows: expected a whole number, 1024"):
        lipoid.read_log(file, most_rows=10)


def test_files_of_a_campaign_are_bounded_as_on_the_command_line(lab: Path) -> None:
    file = lab / "low_rate.csv"
    short = lipoid.Campaign(cutoff_V=3.0, low_rate=file, reading={"most_rows": 1024})
    assert len(short.logs()[0]) <= 1024
    # The default, of which no test can have that many rows.
    assert lipoid._core.most_rows_kept == 1 << 24
    described = {one["name"]: one for one in lipoid._core.describe_reading(True)}
    assert described["most_rows"]["default"] == "None"


def test_a_battery_of_a_flight_can_be_named() -> None:
    file = ROOT / "fixtures/flights/sample_log_small.ulg"
    assert len(lipoid.read_log(file, battery=2)) > 0
    with pytest.raises(lipoid.LoadError, match="batter"):
        lipoid.read_log(file, battery=7)


def test_masked_numbers_are_refused() -> None:
    """What lies below a mask is no measurement."""
    current: Any = np.ma.array(I.copy(), mask=np.zeros(N, dtype=bool))  # type: ignore[no-untyped-call]
    assert lipoid.Log(time_s=T, current_A=current, voltage_V=V).time_s.shape == (N,)
    current[20:30] = np.ma.masked
    with pytest.raises(lipoid.OptionError, match="found masked ones"):
        lipoid.Log(time_s=T, current_A=current, voltage_V=V)
    with pytest.raises(lipoid.OptionError, match="found masked ones"):
        lipoid.Cell.read("gifi-600mAh-1").simulate(T, current)


def test_texts_that_are_no_utf8_are_refused(campaign: lipoid.Campaign, tmp_path: Path) -> None:
    """What os.fsdecode() makes of the byte 0x80, which a name of a file may hold."""
    t = np.arange(0.0, 60.0)
    bad = "a\udc80"
    group: Any = {bad: 1}
    asked: list[Callable[[], object]] = [
        lambda: lipoid.Log(time_s=t, current_A=np.ones_like(t), name=bad),
        lambda: lipoid.Campaign(name=bad, cutoff_V=3.0),
        lambda: lipoid.identify(campaign, fix={bad: 1.0}),
        lambda: lipoid.identify(campaign, pulses=group),
        lambda: lipoid.identify(campaign, profile=bad),
        lambda: lipoid.identify(campaign, **group),
        lambda: lipoid.study(bad, campaign),
        lambda: lipoid.export("gifi-600mAh-1", bad, tmp_path / "out"),
        lambda: lipoid.fly(bad),
    ]
    for ask in asked:
        with pytest.raises(lipoid.OptionError, match=r"expected text of UTF-8, found 'a\\udc80'"):
            ask()


def test_tables_may_stand_in_files_of_any_name(tmp_path: Path) -> None:
    t = np.arange(0.0, 600.0)
    i = np.where(t < 300.0, 1.0, 0.0)
    frame = pd.DataFrame({"time_s": t, "current_A": i, "voltage_V": 4.1 - 0.05 * i - 1e-4 * t})
    file = tmp_path / "log\udc80.parquet"
    with open(file, "wb") as opened:
        frame.to_parquet(opened)
    log = lipoid.read_log(file)
    assert len(log) == 600
    assert log.file == str(file)


def test_a_flight_loses_the_row_of_a_damaged_message_alone(tmp_path: Path) -> None:
    """A DataFlash log written by hand, of which bits of one current or one voltage are turned."""

    def message(kind: int, *content: bytes) -> bytes:
        return b"\xa3\x95" + bytes([kind]) + b"".join(content)

    def form(of: int, size: int, name: bytes, letters: bytes, fields: bytes) -> bytes:
        sized = bytes([of, size]) + name.ljust(4, b"\0") + letters.ljust(16, b"\0")
        return message(0x80, sized, fields.ljust(64, b"\0"))

    def flight(current_A: np.ndarray, voltage_V: np.ndarray) -> lipoid.Log:
        head = form(0x80, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
        head += form(1, 19, b"BAT", b"Qff", b"TimeUS,Volt,Curr")
        rows = [
            message(1, struct.pack("<Qff", 100_000 * k, v, i))
            for k, (i, v) in enumerate(zip(current_A, voltage_V, strict=True))
        ]
        file = tmp_path / "flight.bin"
        file.write_bytes(head + b"".join(rows))
        return lipoid.read_log(file)

    current_A = 20.0 + 5.0 * np.sin(np.arange(200))
    voltage_V = 15.5 - 0.02 * current_A - 1e-3 * np.arange(200)
    whole = flight(current_A, voltage_V)
    assert len(whole) == 200 and not whole.warnings
    for column, value, said in (
        (current_A, -322.0, "1 row dropped: a current of -322 A at 9 s"),
        (voltage_V, 7e8, "1 row dropped: a voltage of 7e+08 V at 9 s"),
    ):
        kept = column[90]
        column[90] = value
        log = flight(current_A, voltage_V)
        column[90] = kept
        assert len(log) == 199
        assert log.warnings[0].startswith(said)
        np.testing.assert_array_equal(log.current_A, np.delete(whole.current_A, 90))


def test_rows_that_repeat_their_time_are_said_and_counted(tmp_path: Path) -> None:
    coarse = pd.DataFrame({"time_s": np.floor(np.arange(0.0, 600.0, 0.1))})
    second = coarse["time_s"].to_numpy().astype(int)
    coarse["current_A"], coarse["voltage_V"] = I[second], V[second]
    coarse.to_csv(tmp_path / "floor.csv", index=False)
    for log in (lipoid.Log(coarse), lipoid.read_log(tmp_path / "floor.csv")):
        assert (len(log), log.rows_of_source) == (600, 6000)
        assert "600 of 6000 rows" in repr(log)
        (warning,) = log.warnings
        assert warning.startswith("5400 of 6000 rows have the time of the row before")
    one_twice = lipoid.Log(pd.concat([coarse.iloc[::10], coarse.iloc[-1:]]))
    assert (one_twice.rows_of_source, one_twice.warnings) == (601, [])


@pytest.mark.parametrize("holes", [slice(None), slice(0, 500), slice(20, 22)])
def test_a_column_of_temperatures_may_have_holes_as_in_a_file(tmp_path: Path, holes: slice) -> None:
    frame = pd.DataFrame({"time_s": T, "current_A": I, "voltage_V": V, "temperature_degC": 20.0})
    frame.loc[frame.index[holes], "temperature_degC"] = np.nan
    frame.to_csv(tmp_path / "log.csv", index=False)
    of_file, of_frame = lipoid.read_log(tmp_path / "log.csv"), lipoid.Log(frame)
    assert of_frame.warnings == of_file.warnings != []
    pd.testing.assert_frame_equal(of_frame.to_pandas(), of_file.to_pandas())
    assert (of_frame.temperature_degC is None) == (holes != slice(20, 22))
    with pytest.raises(lipoid.LoadError, match="finite number in temperature_degC, found inf"):
        lipoid.Log(frame.assign(temperature_degC=np.inf))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"voltage_v": V}, "unknown option 'voltage_v'. Did you mean 'voltage_V'"),
        ({"voltage_V": V, "temperature_degc": V}, "Did you mean 'temperature_degC'"),
        ({"voltage_V": V, "units": "s,A,mV"}, "unknown option 'units'"),
    ],
)
def test_a_wrong_name_of_a_column_gets_the_right_one(options: dict[str, Any], message: str) -> None:
    with pytest.raises(lipoid.OptionError, match=message):
        lipoid.Log(time_s=T, current_A=I, **options)


def test_columns_in_other_units_are_told_what_to_do() -> None:
    with pytest.raises(lipoid.LoadError, match=r"are these mV\? Columns of a program are in V, A"):
        lipoid.Log(time_s=T, current_A=I, voltage_V=1000.0 * V)


def test_dates_with_and_without_a_zone_are_no_times() -> None:
    naive = [datetime(2024, 1, 1) + timedelta(seconds=k) for k in range(N)]
    mixed = [naive[0].replace(tzinfo=timezone.utc), *naive[1:]]
    with pytest.raises(lipoid.OptionError, match="all have a time zone or none"):
        lipoid.Log(time_s=mixed, current_A=I, voltage_V=V)


def test_a_part_that_is_none_says_when_the_log_is() -> None:
    with pytest.raises(lipoid.LoadError, match=r"found none \(times of the log: 0 to 59 s\)"):
        lipoid.Log(time_s=range(60), current_A=[1.0] * 60, start_s=100.0)
