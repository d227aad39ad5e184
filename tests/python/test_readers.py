"""Files that are no text, through the libraries of the field; the same numbers as their text."""

from __future__ import annotations

import zipfile
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
