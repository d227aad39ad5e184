"""Logs: time, current and voltage of a cell, and what reading them found."""

from __future__ import annotations

import datetime as dt
import logging
import os
from collections.abc import Iterable, Mapping, Set
from contextlib import suppress
from html import escape
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias, cast

import numpy as np
import numpy.typing as npt
import pandas as pd

from lipoid import _core, plots
from lipoid._keywords import takes, utf8
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from lipoid._core import Log as CoreLog
    from lipoid._reading_options import ColumnOptions, ReadingOptions

logger = logging.getLogger("lipoid")

FloatArray = npt.NDArray[np.float64]


class ArrowTable(Protocol):
    """A table of columns as polars, pyarrow and others hand it on."""

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any: ...


OneLog: TypeAlias = "Log | str | os.PathLike[str] | Mapping[str, Any] | pd.DataFrame | ArrowTable"
Logs: TypeAlias = "OneLog | Iterable[OneLog]"


_COLUMNS = ("time_s", "current_A", "voltage_V", "temperature_degC")


def _moments(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return dates and durations of Python as those of NumPy, and anything else as it is."""
    if array.dtype.kind != "O" or not array.size:
        return array
    if all(isinstance(one, dt.timedelta) for one in array):
        return pd.to_timedelta(array).to_numpy()
    if not all(isinstance(one, dt.datetime) for one in array):
        return array
    if len({one.tzinfo is None for one in array}) > 1:
        raise OptionError(
            "time_s: expected dates that all have a time zone or none, found some of both; nobody "
            "knows how far the ones are from the others"
        )
    return pd.to_datetime(array, utc=True).tz_localize(None).to_numpy()


def column(values: Any, name: str, dimensions: tuple[int, ...] = (1,)) -> FloatArray:
    """Contiguous float64 of anything that holds numbers; the same memory where it is that already.

    Parameters
    ----------
    values : array_like
        A NumPy array, a pandas or polars Series, a pyarrow array, a sequence.
    name : str
        For messages. Of ``time_s`` also dates and durations are taken, as seconds.
    dimensions : tuple of int
        How many it may have; dates and durations have one.
    """
    if getattr(values, "tz", None) or getattr(getattr(values, "dt", None), "tz", None):
        values = pd.DatetimeIndex(values).tz_convert(None)  # so that hours keep their length
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise OptionError(f"{name}: expected numbers, found masked ones; leave their rows out")
    if isinstance(values, np.ndarray) or hasattr(values, "__array__"):
        array = np.asarray(values)
    elif hasattr(values, "to_numpy"):
        array = values.to_numpy()
    elif isinstance(values, (str, bytes, Mapping, Set)) or not isinstance(values, Iterable):
        raise OptionError(f"{name}: expected a column of numbers, found {values!r:.200}")
    else:
        array = np.asarray(list(values))
    if array.ndim not in dimensions:
        wanted = "one dimension" if dimensions == (1,) else "one dimension or two"
        raise OptionError(f"{name}: expected {wanted}, found {array.ndim}")
    if name == "time_s" and array.ndim == 1:
        array = _moments(array)
        if array.dtype.kind == "M" and array.size:
            array = array - array[0]
        if array.dtype.kind == "m":
            if np.datetime_data(array.dtype)[0] in {"M", "Y"}:
                raise OptionError(f"{name}: expected times of a fixed length, found {array.dtype}")
            array = array / np.timedelta64(1, "s")
    if array.dtype.kind == "O" and not any(isinstance(one, (str, bool)) for one in array.flat):
        with suppress(TypeError, ValueError):
            array = array.astype(np.float64)  # of decimals; what is missing becomes NaN
    if array.dtype.kind not in "fiu":
        what = {"M": "dates", "m": "durations", "b": "truth values", "c": "complex numbers"}
        texts = array.dtype.kind in "USO"
        found = "texts or other objects" if texts else what.get(array.dtype.kind, str(array.dtype))
        raise OptionError(f"{name}: expected numbers, found {found}")
    return np.ascontiguousarray(array, dtype=np.float64)


def _columns(data: Any) -> dict[str, Any]:
    """Return the columns of a table by name; of pandas the index, too, where it holds times."""
    if hasattr(data, "collect"):  # of polars, lazy
        data = data.collect()
    names: Any = getattr(data, "column_names", None)  # of Arrow, whose columns are arrays
    if names is None:
        names = data.keys() if isinstance(data, Mapping) else getattr(data, "columns", None)
    if names is None:
        raise OptionError(
            "Log: expected a data frame or a dictionary with the columns time_s, current_A and "
            f"voltage_V, found {type(data).__name__}; arrays are given by name, as time_s=..., and "
            "files are read by lipoid.read_log"
        )
    known = [str(name) for name in names]
    twice = {name for name in known if known.count(name) > 1}
    if several := sorted(twice.intersection(_COLUMNS)):
        raise OptionError(f"Log: several columns are called {' and '.join(several)}; rename them")
    columns = {str(name): data[name] for name in names if str(name) not in twice}
    index = getattr(data, "index", None)
    if "time_s" not in columns and (
        isinstance(index, (pd.DatetimeIndex, pd.TimedeltaIndex))
        or (isinstance(index, pd.Index) and index.name == "time_s")
    ):
        columns["time_s"] = index
    return columns


def _likely(key: str, columns: Mapping[str, Any]) -> str:
    """Return which of the columns may be the one that is missing, as the end of a sentence."""
    others = [name for name in columns if name not in _COLUMNS]
    found = _core.likely_column(others, key)
    if found is None:
        return ""
    name, unit = found
    return f"; {key}=table[{name!r}] may be it{f', which is in {unit}' if unit else ''}"


@takes(lambda: _core.describe_reading(False))
class Log:
    """A log of one test: columns of equal length in SI units, discharge positive.

    Parameters
    ----------
    data : mapping or data frame, optional
        The columns by name, instead of one by one: a pandas, polars or pyarrow table. Of pandas
        an index of dates or durations, or one called ``time_s``, is taken as the time.
    time_s : array_like
        Times in s, increasing; or dates, or durations.
    current_A : array_like
        Currents in A, of either sign: which sign a discharge has is found from the voltage.
    voltage_V : array_like, optional
        Voltages in V. A log without is good for simulations alone.
    temperature_degC : array_like, optional
        Temperatures in degrees Celsius. Single ones that are missing are taken from the rows
        around; a column with more holes is left out, as ``warnings`` then say.
    name : str, optional
        What messages and reports call it.
    {options}

    Notes
    -----
    Contiguous arrays of float64 are not copied: do not change them while the log is in use. A
    current that counts discharge as negative is copied, because it is turned.

    Examples
    --------
    >>> import numpy as np, lipoid
    >>> t = np.arange(0.0, 600.0)
    >>> i = np.where(t < 300.0, 1.0, 0.0)
    >>> v = 4.1 - 0.05 * i - 1e-4 * np.minimum(t, 300.0)
    >>> log = lipoid.Log(time_s=t, current_A=i, voltage_V=v)
    >>> len(log), log.sign
    (600, 'discharge-positive')
    """

    _core: CoreLog

    def __init__(
        self,
        data: Any = None,
        *,
        time_s: Any = None,
        current_A: Any = None,
        voltage_V: Any = None,
        temperature_degC: Any = None,
        name: str = "log",
        **options: Unpack[ColumnOptions],
    ) -> None:
        given = {
            "time_s": time_s,
            "current_A": current_A,
            "voltage_V": voltage_V,
            "temperature_degC": temperature_degC,
        }
        columns = {} if data is None else _columns(data)
        for key in given:
            if given[key] is None:
                given[key] = columns.get(key)
        for key in ("time_s", "current_A"):
            if given[key] is None:
                found = f"; found {', '.join(columns)}" if columns else ""
                other = (
                    f"; unknown: {', '.join(unknown)}"
                    if (unknown := self._unknown(options))
                    else ""
                )
                raise OptionError(f"Log: {key} is missing{found}{other}{_likely(key, columns)}")
        if given["voltage_V"] is None and (likely := _likely("voltage_V", columns)):
            raise OptionError(f"Log: voltage_V is missing; found {', '.join(columns)}{likely}")
        if unknown := self._unknown(options):
            known = [*given, "name", *(one["name"] for one in _core.describe_reading(False))]
            raise OptionError(f"Log: {_core.unknown_name('option', unknown[0], known)}")
        arrays = {k: None if v is None else column(v, k) for k, v in given.items()}
        self._core = _core.take_log(
            cast(FloatArray, arrays["time_s"]),
            cast(FloatArray, arrays["current_A"]),
            arrays["voltage_V"],
            arrays["temperature_degC"],
            utf8("name", name),
            dict(options),
        )

    @staticmethod
    def _unknown(options: Mapping[str, Any]) -> list[str]:
        known = [option["name"] for option in _core.describe_reading(False)]
        return [name for name in options if name not in known]

    @classmethod
    def _of(cls, core: CoreLog) -> Log:
        log = cls.__new__(cls)
        log._core = core
        return log

    @property
    def time_s(self) -> FloatArray:
        """Times in s, shape (rows,); a view that cannot be written to."""
        return self._core.time_s

    @property
    def current_A(self) -> FloatArray:
        """Currents in A, discharge positive, shape (rows,)."""
        return self._core.current_A

    @property
    def voltage_V(self) -> FloatArray | None:
        """Voltages in V, shape (rows,); None where the log has none."""
        return self._core.voltage_V

    @property
    def temperature_degC(self) -> FloatArray | None:
        """Temperatures in degrees Celsius, shape (rows,); None where the log has none."""
        return self._core.temperature_degC

    @property
    def file(self) -> str:
        """Where it came from."""
        return self._core.file

    @property
    def _inputs(self) -> list[str]:
        return [self.file]

    @property
    def hold(self) -> Literal["backward", "forward"]:
        """Which rows a current holds between: "backward" (since the row before) or "forward"."""
        return self._core.hold

    @property
    def format(self) -> str:
        """The format that was recognised; "columns" of arrays, "parquet" and such of tables."""
        return self._core.format

    @property
    def sign(self) -> str:
        """How the source counts: "discharge-positive", "discharge-negative" or "unsigned"."""
        return self._core.sign

    @property
    def sign_reason(self) -> str:
        """What the sign was found from, one sentence."""
        return self._core.sign_reason

    @property
    def rows_of_source(self) -> int:
        """Rows of the file; more than the rows here where some were left out or joined."""
        return self._core.rows_of_source

    @property
    def warnings(self) -> list[str]:
        """What to look at before believing the log."""
        said = cast("list[str]", self._core.reading()["warnings"])
        return [_core.in_python(warning) for warning in said]

    @property
    def segments(self) -> pd.DataFrame:
        """Rests, pulses, constant currents and the rest, one row each."""
        rows = self.inspect()["segments"]
        names = ["kind", "first_row", "last_row", "start_s", "end_s", "current_A", "charge_C"]
        return pd.DataFrame(rows, columns=names)

    def inspect(self) -> dict[str, Any]:
        """Look what is in the log: what ``lipoid inspect --summary`` has."""
        return self._core.inspect()

    def to_pandas(self) -> pd.DataFrame:
        """Return the columns as a data frame."""
        columns = {"time_s": self.time_s, "current_A": self.current_A}
        if self.voltage_V is not None:
            columns["voltage_V"] = self.voltage_V
        if self.temperature_degC is not None:
            columns["temperature_degC"] = self.temperature_degC
        return pd.DataFrame(columns)

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw current and voltage over time; return the axes."""
        return plots.log(self.time_s, self.current_A, self.voltage_V, self.file, axes)

    def __len__(self) -> int:
        return len(self._core)

    def _rows(self) -> str:
        kept = self._core.rows_kept
        if kept != len(self):
            return f"{len(self)} rows that stand for {kept}"
        of = f" of {self.rows_of_source}" if self.rows_of_source != kept else ""
        return f"{kept}{of} rows"

    def __repr__(self) -> str:
        hours = float(self.time_s[-1] - self.time_s[0]) / 3600.0
        text = f"Log({self.file!r}: {self._rows()}, {hours:.4g} h"
        text += f", {self.current_A.min():.4g} to {self.current_A.max():.4g} A"
        if self.voltage_V is not None:
            text += f", {self.voltage_V.min():.4g} to {self.voltage_V.max():.4g} V"
        return text + f", {self.format}, {self.sign})"

    def _repr_html_(self) -> str:
        found = self.inspect()
        rows = [
            ("format", self.format),
            ("rows", self._rows().removesuffix(" rows")),
            ("duration", f"{found['duration_s'] / 3600.0:.4g} h"),
            ("sign", f"{self.sign}: {self.sign_reason}"),
            ("looks like", f"{found['suggested_kind']}: {found['suggested_kind_reason']}"),
            *(("look at", warning) for warning in self.warnings),
        ]
        body = "".join(f"<tr><th>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in rows)
        return f"<b>{escape(self.file)}</b><table>{body}</table>"


@takes(lambda: _core.describe_reading(True))
def read_log(file: str | os.PathLike[str], **options: Unpack[ReadingOptions]) -> Log:
    """Read a log of any known format; the format is recognised from the content.

    Text of cyclers and loggers is read by lipoid itself (``lipoid list formats``). Binary files are
    read by the libraries that the field keeps for them, ``pip install lipoid[readers]``: BioLogic
    .mpr, Neware .nda and .ndax, Excel, MATLAB, Parquet and Feather. Their columns then go through
    the same recognition of names, units and sign.

    Every row is kept unless ``most_rows`` says otherwise. Files that a :class:`Campaign` reads are
    read as on the command line: there ``most_rows`` has a default, and a longer log is thinned.

    Parameters
    ----------
    file : str or path
        The file.
    {options}

    Returns
    -------
    Log
        Its columns in SI units, discharge positive.

    Raises
    ------
    LoadError
        With file, line and column, where the file is not a log, or is not there.
    """
    from lipoid import readers

    path = os.fsdecode(file)  # a number would be an open file
    if (table := readers.table_of(path)) is not None:
        text, format_of_file = table
        return Log._of(_core.read_log_text(text, path, format_of_file, dict(options)))
    return Log._of(_core.read_log(path, dict(options)))


def listed(logs: Any) -> list[Any]:
    """Return what was given for logs, one or several of them, as a list."""
    is_one = isinstance(logs, (Log, str, os.PathLike, Mapping)) or not isinstance(logs, Iterable)
    # Of the type: a lazy frame of polars would look for its columns.
    is_table = hasattr(type(logs), "columns") or hasattr(type(logs), "column_names")
    return [logs] if is_one or is_table else list(logs)


def as_logs(logs: Any, wanted: str, reading: Mapping[str, Any] = {}) -> list[Log]:
    """Return one log or several, reading those that are paths; none is not what was `wanted`."""
    several = [] if logs is None else listed(logs)
    if not several:
        raise OptionError(f"{wanted}, found none")
    taken = [_log_of(one, reading) for one in several]
    for one, log in zip(several, taken, strict=True):
        for warning in log.warnings if log is not one else ():  # of one's own Log they can be read
            logger.warning("%s: %s", log.file, warning)
    return taken


def _log_of(one: Any, reading: Mapping[str, Any]) -> Log:
    if isinstance(one, (str, os.PathLike)):
        return read_log(one, **cast("ReadingOptions", reading))
    if callable(getattr(one, "log", None)):  # of lipoid.fly
        raise OptionError(f"expected logs, found a {type(one).__name__}; its log() is one")
    if not isinstance(one, Log):
        return Log(one, **cast(Any, of_table(reading, one)))
    if reading:
        option = next(iter(reading))
        raise OptionError(
            f"option {option}: it is for what is read here, found a Log, which is read already; "
            f"say it where that is made: lipoid.Log(..., {option}=...) or lipoid.read_log(...)"
        )
    return one


def of_table(reading: Mapping[str, Any], table: Any) -> Mapping[str, Any]:
    """Return the options of reading, which a table of a log takes, too; else refuse."""
    if files_only := Log._unknown(reading):
        raise OptionError(
            f"option {files_only[0]}: it is for files, found a {type(table).__name__}, whose "
            "columns have the names and units of a log; change it before"
        )
    return reading


def mission_of(mission: Log | str | os.PathLike[str] | None) -> Any:
    """Return what C++ takes for a mission: a log, or the path of a file."""
    return mission if isinstance(mission, (str, os.PathLike)) else core_of("mission", mission)


def core_of(option: str, log: Log | None) -> CoreLog | None:
    """Return what C++ takes for a log that may be given as this option."""
    if log is None:
        return None
    if not isinstance(log, Log):
        raise OptionError(
            f"option {option}: expected a Log, as lipoid.read_log makes one of a file, found "
            f"{type(log).__name__}"
        )
    return log._core
