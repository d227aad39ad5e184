"""Logs: from arrays without a copy, from tables of other libraries, from files."""

from __future__ import annotations

import pickle
import resource
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import lipoid

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


def test_errors_of_files_have_a_place(tmp_path: Path) -> None:
    file = tmp_path / "bad.csv"
    file.write_text("time_s,current_A,voltage_V\n0,0,4.1\n1,x,4.1\n")
    with pytest.raises(lipoid.LoadError, match=r"bad\.csv:3:3: error: expected a number") as error:
        lipoid.read_log(file)
    assert (error.value.file, error.value.line, error.value.column) == (str(file), 3, 3)
    assert isinstance(error.value, ValueError)
    again = pickle.loads(pickle.dumps(error.value))
    assert (str(again), again.line) == (str(error.value), 3)


def test_a_missing_file_is_a_load_error() -> None:
    with pytest.raises(lipoid.LoadError, match="found no file of this name") as error:
        lipoid.read_log("nowhere.csv")
    assert error.value.file == "nowhere.csv"
