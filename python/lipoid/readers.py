"""Logs that are no text, read by the libraries that the field keeps for them.

Each reader makes a table with the columns of its file; the table then goes through the recognition
of names, units and sign that every log goes through. The file is known by its content.
"""

from __future__ import annotations

import io
import os
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from lipoid._log import column
from lipoid.errors import LoadError


class Format(NamedTuple):
    """A kind of binary file: how it begins, what reads it."""

    name: str
    begins: bytes
    library: str
    read: Callable[[str, Any], pd.DataFrame]


# BioLogic's own names, as its text files have them; charge is positive.
_BIOLOGIC = {
    "time/s": "time/s",
    "Ewe/V": "Ewe/V",
    "Ecell/V": "Ecell/V",
    "I/mA": "I/mA",
    "<I>/mA": "<I>/mA",
    "control/mA": "control/mA",
    "control/V/mA": "control/V/mA",
    "Ns": "Ns",
    "cycle number": "cycle number",
    "mode": "mode",
}


def _biologic(file: str, library: Any) -> pd.DataFrame:
    data = library.MPRfile(file).data
    table = pd.DataFrame({name: data[name] for name in data.dtype.names})
    table = table[[name for name in table if name in _BIOLOGIC]]
    if not {"I/mA", "<I>/mA"} & set(table) and "control/mA" in table:
        table = table.rename(columns={"control/mA": "I/mA"})
    return table


def _neware(file: str, library: Any, suffix: str) -> pd.DataFrame:
    # NewareNDA goes by the name of a file, not by its content.
    with tempfile.TemporaryDirectory() as folder:
        named = os.path.join(folder, "log" + suffix)
        os.symlink(os.path.abspath(file), named)
        data = library.read(named)
    step_s = data["Time"].to_numpy(float)
    current_mA = data["Current(mA)"].to_numpy(float)
    stamp_s = (data["Timestamp"] - data["Timestamp"].iloc[0]).dt.total_seconds().to_numpy()
    return pd.DataFrame(
        {
            "time_s": _joined_steps_s(data["Step"].to_numpy(), step_s, stamp_s),
            "current_mA": current_mA,
            "voltage_V": data["Voltage"],
        }
    )


def _joined_steps_s(step: Any, step_s: Any, stamp_s: Any) -> Any:
    """Return the time of rows whose clock starts anew with each step.

    A step follows the one before at once, unless the time stamps, which are whole seconds in many
    files, say that something lay between: a pause, or rows that were not kept.
    """
    begins = np.flatnonzero(np.append(True, step[1:] != step[:-1]))
    ends = np.append(begins[1:], len(step))
    joined = np.empty(len(step))
    now_s = 0.0
    for begin, end in zip(begins, ends, strict=True):
        by_stamp_s = stamp_s[begin] - step_s[begin]
        if begin == 0 or by_stamp_s > now_s + 2.0:
            now_s = by_stamp_s
        joined[begin:end] = now_s + step_s[begin:end]
        now_s = joined[end - 1]
    return joined - joined[0]


def _excel(file: str, _: Any) -> pd.DataFrame:
    sheets = pd.read_excel(file, sheet_name=None, engine="openpyxl")
    return max(sheets.values(), key=len)  # the sheet of the rows, not that of the settings


def _matlab(file: str, library: Any) -> pd.DataFrame:
    content = library.loadmat(file, squeeze_me=True, simplify_cells=True)
    columns: dict[str, Any] = {}

    def collect(values: Any) -> None:
        for name, value in values.items():
            if isinstance(value, dict):
                collect(value)
            elif not name.startswith("__") and getattr(value, "ndim", 0) == 1 and value.size > 1:
                columns.setdefault(name, value)

    collect(content)
    if not columns:
        raise LoadError(f"{file}: error: expected columns of numbers, found none")
    rows = max(len(v) for v in columns.values())
    return pd.DataFrame({k: v for k, v in columns.items() if len(v) == rows})


def _parquet(file: str, library: Any) -> pd.DataFrame:
    with open(file, "rb") as opened:  # of any name: that of a path has to be UTF-8
        table: pd.DataFrame = library.read_table(opened).to_pandas()
    if isinstance(table.index, (pd.DatetimeIndex, pd.TimedeltaIndex)):
        table.insert(0, "time_s", column(table.index, "time_s"), allow_duplicates=True)
    elif table.index.name is not None:
        table = table.reset_index()
    return table


FORMATS = (
    Format("BioLogic .mpr", b"BIO-LOGIC MODULAR FILE", "galvani.BioLogic", _biologic),
    Format("Neware .nda", b"NEWARE", "NewareNDA", partial(_neware, suffix=".nda")),
    Format("Neware .ndax", b"PK\x03\x04 ndax", "NewareNDA", partial(_neware, suffix=".ndax")),
    Format("Excel", b"PK\x03\x04 xlsx", "openpyxl", _excel),
    Format("MATLAB", b"MATLAB 5.0 MAT-file", "scipy.io", _matlab),
    Format("Parquet", b"PAR1", "pyarrow.parquet", _parquet),
    Format("Feather", b"ARROW1", "pyarrow.feather", _parquet),
)
_PACKAGES = {"galvani.BioLogic": "galvani", "scipy.io": "scipy"}


def _head(file: str | os.PathLike[str]) -> bytes:
    try:
        with open(file, "rb") as stream:
            head = stream.read(64)
    except OSError:
        return b""  # the reader of text says what is wrong
    if not head.startswith(b"PK\x03\x04"):
        return head
    try:
        with zipfile.ZipFile(file) as archive:
            names = archive.namelist()
    except zipfile.BadZipFile:
        return head
    if any(name.startswith("xl/") for name in names):
        return b"PK\x03\x04 xlsx"
    if any(name.endswith(".ndc") for name in names):
        return b"PK\x03\x04 ndax"
    return head


def _format_of(file: str | os.PathLike[str]) -> Format | None:
    head = _head(file)
    return next((one for one in FORMATS if head.startswith(one.begins)), None)


def is_table(file: str | os.PathLike[str]) -> bool:
    """Whether one of the readers here is for this file."""
    return _format_of(file) is not None


def table_of(file: str | os.PathLike[str]) -> tuple[bytes, str] | None:
    """Return the table of a binary file as text, and its format; None for a file of text."""
    found = _format_of(file)
    if found is None:
        return None
    path = os.fspath(file)
    try:
        library = import_module(found.library)
    except ImportError as error:
        package = _PACKAGES.get(found.library, found.library.split(".")[0])
        message = (
            f"{path} is a file of {found.name}: it is read by {package}, which is not installed; "
        )
        message += "pip install lipoid[readers]"
        raise LoadError(message, [(path, 1, 1, message)]) from error
    try:
        table = found.read(path, library)
    except LoadError:
        raise
    except Exception as error:
        message = f"expected a file of {found.name}, found one that cannot be read: {error}"
        raise LoadError(f"{path}:1:1: error: {message}", [(path, 1, 1, message)]) from error
    for name in table.select_dtypes("timedelta").columns:
        seconds = table[name].dt.total_seconds()
        table = table.drop(columns=name)
        table.insert(0, name if name == "time_s" else f"{name} (s)", seconds)
    stream = io.StringIO()
    table.to_csv(stream, index=False)
    return stream.getvalue().encode(), found.name.lower()
