"""Files that are no text, through the libraries of the field; the same numbers as their text."""

from __future__ import annotations

import struct
import zipfile
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import lipoid

N = 900
T = np.arange(0.0, N)
I = np.where((T > 60) & (T < 360), 1.5, 0.0)  # noqa: E741
V = 4.1 - 0.04 * I - 2e-4 * np.clip(T - 60, 0, 300)


def table() -> pd.DataFrame:
    """A table as a laboratory would name it: minutes, mA, charge positive."""
    return pd.DataFrame({"Test time / min": T / 60.0, "Current / mA": -1e3 * I, "Voltage / V": V})


def same(log: lipoid.Log) -> None:
    np.testing.assert_allclose(log.time_s, T, atol=1e-9)
    np.testing.assert_allclose(log.current_A, I, atol=1e-12)
    assert log.voltage_V is not None
    np.testing.assert_allclose(log.voltage_V, V, rtol=1e-15)  # Excel writes 16 digits
    assert log.sign == "discharge-negative"


def test_parquet(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    table().to_parquet(tmp_path / "log.bin")
    same(lipoid.read_log(tmp_path / "log.bin"))


def test_feather(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    table().to_feather(tmp_path / "log.bin")
    same(lipoid.read_log(tmp_path / "log.bin"))


def test_excel_takes_the_sheet_of_the_rows(tmp_path: Path) -> None:
    pytest.importorskip("openpyxl")
    with pd.ExcelWriter(tmp_path / "log.xlsx") as writer:
        pd.DataFrame({"setting": ["operator"], "value": ["somebody"]}).to_excel(
            writer, sheet_name="settings", index=False
        )
        table().to_excel(writer, sheet_name="rows", index=False)
    log = lipoid.read_log(tmp_path / "log.xlsx")
    same(log)


def test_matlab(tmp_path: Path) -> None:
    io = pytest.importorskip("scipy.io")
    io.savemat(tmp_path / "log.mat", {"meas": {"Time": T, "Current": -I, "Voltage": V}, "note": 1})
    log = lipoid.read_log(tmp_path / "log.mat", units=["s", "A", "V"])
    np.testing.assert_array_equal(log.current_A, I)


def mpr_module(name: bytes, version: int, data: bytes) -> bytes:
    head = name.ljust(10) + b"".ljust(25) + struct.pack("<II", len(data), version) + b"03/14/24"
    return b"MODULE" + head + data


def test_mpr(tmp_path: Path) -> None:
    """A file as EC-Lab writes it: modules, of which one has the rows, charge positive, in mA."""
    pytest.importorskip("galvani", reason="tools/setup --extra installs galvani")
    columns = (4, 6, 11)  # time/s, Ewe/V, <I>/mA
    rows = np.empty(N, np.dtype([("t", "<f8"), ("v", "<f4"), ("i", "<f8")]))
    rows["t"], rows["v"], rows["i"] = T, V, -1e3 * I
    head = struct.pack("<IB", N, len(columns)) + struct.pack("<3H", *columns)
    (tmp_path / "log.bin").write_bytes(
        b"BIO-LOGIC MODULAR FILE\x1a".ljust(48)
        + bytes(4)
        + mpr_module(b"VMP Set", 0, bytes(16))
        + mpr_module(b"VMP data", 2, head.ljust(405, b"\0") + rows.tobytes())
    )
    log = lipoid.read_log(tmp_path / "log.bin")
    np.testing.assert_array_equal(log.time_s, T)
    np.testing.assert_allclose(log.current_A, I, rtol=1e-15)
    assert log.voltage_V is not None
    np.testing.assert_allclose(log.voltage_V, V, rtol=1e-7)  # single precision in the file
    assert log.sign == "discharge-negative"


# Neware's records have 86 bytes; steps are numbered, and their clock starts anew. Two states:
REST, DISCHARGE = 4, 2


def nda_record(index: int, step: int, step_s: float, row: int, begins_s: float) -> bytes:
    second = datetime(2024, 3, 14, 9) + timedelta(seconds=int(begins_s + step_s))  # whole seconds
    state = DISCHARGE if step == 2 else REST
    return (
        struct.pack("<HIIHB", 0x55, index, 0, step, state)
        + bytes(1)
        + struct.pack("<Qii", round(1e3 * step_s), round(1e4 * V[row]), round(-1e5 * I[row]))
        + bytes(8 + 32)
        + struct.pack("<HBBBBB", *second.timetuple()[:6])
        + bytes(1)
        + struct.pack("<i", 100)  # the range of the channel: a unit of the current is 10 uA
        + bytes(4)
    )


@pytest.mark.parametrize("name", ["log.nda", "log.bin"])
@pytest.mark.parametrize("pause_s", [0.0, 600.0])
def test_nda(tmp_path: Path, name: str, pause_s: float) -> None:
    """Steps whose clocks start anew are joined; whole seconds of the stamps do not jitter them."""
    pytest.importorskip("NewareNDA", reason="tools/setup --extra installs NewareNDA")
    steps = ((1, 0.0), (2, 60.4), (3, 360.9))  # rest, discharge, rest
    times, records, rows = [], [b"NEWARE".ljust(14, b"\0") + b"\x1d" + bytes(1024)], []
    for step, begins_s in steps:
        ends_s = {1: 60.4, 2: 360.9, 3: 899.0}[step]
        for step_s in np.append(np.arange(1.0, ends_s - begins_s, 1.0), ends_s - begins_s):
            row = int(
                np.clip(begins_s + step_s, *{1: (0, 60), 2: (61, 359), 3: (360, N - 1)}[step])
            )
            waited_s = pause_s if step == 3 else 0.0
            times.append(begins_s + step_s + waited_s)
            rows.append(row)
            records.append(nda_record(len(times), step, step_s, row, begins_s + waited_s + 0.3))
    (tmp_path / name).write_bytes(b"".join(records))
    log = lipoid.read_log(tmp_path / name)
    expected = np.array(times) - times[0]
    # Exact within steps; across a pause as good as stamps of whole seconds can be.
    np.testing.assert_allclose(log.time_s, expected, atol=1e-4 if pause_s == 0.0 else 1.0)
    np.testing.assert_allclose(log.current_A, I[rows], rtol=1e-6)
    assert log.voltage_V is not None
    np.testing.assert_allclose(log.voltage_V, V[rows], atol=0.51e-4)  # a unit is 0.1 mV


def test_bdf_is_read_by_content(tmp_path: Path) -> None:
    pd.DataFrame({"Test Time / s": T, "Current / A": -I, "Voltage / V": V}).to_csv(
        tmp_path / "log.bdf", index=False
    )
    assert lipoid.read_log(tmp_path / "log.bdf").format == "bdf"


def test_a_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from lipoid import readers

    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(readers, "import_module", missing)
    for begin, package in ((b"BIO-LOGIC MODULAR FILE\x1a", "galvani"), (b"NEWARE", "NewareNDA")):
        (tmp_path / "log.bin").write_bytes(begin + bytes(100))
        with pytest.raises(lipoid.LoadError, match=package) as error:
            lipoid.read_log(tmp_path / "log.bin")
        assert "pip install lipoid[readers]" in str(error.value)


def test_a_damaged_file_is_a_load_error(tmp_path: Path) -> None:
    pytest.importorskip("openpyxl")
    with zipfile.ZipFile(tmp_path / "log.xlsx", "w") as archive:
        archive.writestr("xl/workbook.xml", "<no")
    with pytest.raises(lipoid.LoadError, match="expected a file of Excel") as error:
        lipoid.read_log(tmp_path / "log.xlsx")
    assert error.value.file == str(tmp_path / "log.xlsx")


def test_columns_of_tables_are_checked_like_text(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    pd.DataFrame({"Test time / min": T, "Mood / 1": I, "Voltage / V": V}).to_parquet(
        tmp_path / "log.parquet"
    )
    with pytest.raises(lipoid.LoadError, match="current"):
        lipoid.read_log(tmp_path / "log.parquet")


def test_a_campaign_takes_them_too(tmp_path: Path, lab: Path) -> None:
    pytest.importorskip("pyarrow")
    pulses = lipoid.read_log(lab / "pulses.csv")
    pulses.to_pandas().to_parquet(tmp_path / "pulses.parquet")
    campaign = lipoid.Campaign(
        cutoff_V=3.0, low_rate=lab / "low_rate.csv", pulses=tmp_path / "pulses.parquet"
    )
    log = campaign.logs("pulses")[0]
    np.testing.assert_array_equal(log.voltage_V, pulses.voltage_V)


@pytest.mark.parametrize("index", ["dates", "durations", "named numbers", "named dates"])
def test_the_index_of_a_pandas_table_is_its_time(tmp_path: Path, index: str) -> None:
    frame = table().drop(columns="Test time / min")
    frame.index = {
        "dates": pd.Timestamp("2024-01-01", tz="Europe/Berlin") + pd.to_timedelta(T, unit="s"),
        "durations": pd.to_timedelta(T, unit="s"),
        "named numbers": pd.Index(T, name="time_s"),
        "named dates": pd.DatetimeIndex(
            pd.Timestamp("2024") + pd.to_timedelta(T, unit="s"), name="time"
        ),
    }[index]
    frame.to_parquet(tmp_path / "log.parquet")
    log = lipoid.read_log(tmp_path / "log.parquet")
    np.testing.assert_allclose(log.time_s, T, atol=1e-9)
    assert log.format == "parquet"


@pytest.mark.parametrize("name", ["time_s", "time", "Test Time"])
@pytest.mark.parametrize("write", ["to_parquet", "to_feather"])
def test_a_column_of_durations_is_a_time(tmp_path: Path, name: str, write: str) -> None:
    frame = table().rename(columns={"Test time / min": name})
    frame[name] = pd.to_timedelta(T, unit="s")
    getattr(frame, write)(tmp_path / "log.bin")
    np.testing.assert_allclose(lipoid.read_log(tmp_path / "log.bin").time_s, T, atol=1e-9)
