"""How long a vehicle flies on a pack, and how old a pack is by flights on it."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from lipoid import _core
from lipoid._cell import Cell
from lipoid._identify import Progress, Reporter
from lipoid._keywords import takes, whole
from lipoid._log import Log, read_log
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._options import EnduranceOptions, HealthOptions


@dataclass(repr=False)
class Endurance:
    """How long a vehicle flies, and how far that is known.

    Attributes
    ----------
    summary : dict
        What ``lipoid endurance --summary`` writes (docs/formats.md).
    """

    summary: dict[str, Any]

    @property
    def minutes(self) -> float:
        """Until landing."""
        return float(self.summary["minutes"])

    @property
    def minutes_interval_95(self) -> tuple[float, float] | None:
        """Where 95 % of the flights drawn lie; None where nothing is uncertain."""
        found = self.summary["minutes_interval_95"]
        return None if found is None else (float(found[0]), float(found[1]))

    @property
    def ended_by(self) -> str:
        """What ended the flight: "reserve", "cut-off", "empty", "motor-voltage", ..."""
        return str(self.summary["ended_by"])

    @property
    def table(self) -> pd.DataFrame:
        """Every number with its interval, by name."""
        rows = {}
        for key, interval in self.summary.items():
            if not key.endswith("_interval_95"):
                continue
            name = key.removesuffix("_interval_95")
            low, high = interval or (np.nan, np.nan)
            rows[name] = {"estimate": self.summary[name], "low_95": low, "high_95": high}
        return pd.DataFrame.from_dict(rows, orient="index")

    def __repr__(self) -> str:
        known = self.minutes_interval_95
        interval = "" if known is None else f", 95 % from {known[0]:.4g} to {known[1]:.4g}"
        return f"Endurance({self.minutes:.4g} minutes{interval}, ended by {self.ended_by!r})"

    def _repr_html_(self) -> str:
        html: str = self.table.to_html(float_format=lambda x: f"{x:.5g}")
        return f"<p>{escape(repr(self))}</p>{html}"


@takes(_core.describe_endurance)
def endurance(
    cell: Cell | str | os.PathLike[str],
    *,
    seed: int = 0,
    threads: int = 0,
    progress: Progress = False,
    **options: Unpack[EnduranceOptions],
) -> Endurance:
    """Say how long a vehicle flies on a pack, with an interval.

    The vehicle is in equilibrium all the time; :func:`fly` flies it with a controller. An option
    that is a pair has a standard error, which widens the intervals, as the uncertainty of the
    cell does.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        The cell; ``series`` and ``parallel`` make the pack.
    seed : int
        Of what is drawn.
    threads : int
        Cores to use; 0: all. The answer does not depend on it.
    progress : bool or callable
        As in :func:`identify`.
    {options}

    Returns
    -------
    Endurance
        With ``minutes`` and their interval.

    Examples
    --------
    >>> import lipoid
    >>> lipoid.endurance("gifi-600mAh-1", vehicle="mambo-physical", reserve=0.4).ended_by
    'reserve'
    """
    one = cell if isinstance(cell, Cell) else Cell.read(cell)
    with Reporter(progress, "endurance") as tell:
        return Endurance(
            _core.endurance(
                one._core, dict(options), whole("seed", seed), whole("threads", threads), tell
            )
        )


@dataclass(repr=False)
class Health:
    """How old a pack is.

    Attributes
    ----------
    sentence : str
        The trend over the flights, else what the last one says.
    summary : dict
        What ``lipoid health --summary`` writes (docs/flight-logs.md).
    """

    sentence: str
    summary: dict[str, Any]

    @property
    def flights(self) -> pd.DataFrame:
        """One row per flight; intervals in columns that end with low_95 and high_95."""
        rows = []
        for one in self.summary["flights"]:
            row: dict[str, Any] = {}
            for key, value in one.items():
                if key.endswith("interval_95"):
                    name = key.removesuffix("interval_95")
                    low, high = value if value is not None else (np.nan, np.nan)
                    row |= {f"{name}low_95": low, f"{name}high_95": high}
                elif not isinstance(value, (dict, list)):
                    row[key] = np.nan if value is None else value
            rows.append(row)
        return pd.DataFrame(rows)

    def __repr__(self) -> str:
        return f"Health({len(self.summary['flights'])} flights: {self.sentence})"

    def _repr_html_(self) -> str:
        html: str = self.flights.to_html(float_format=lambda x: f"{x:.5g}")
        return f"<p>{escape(self.sentence)}</p>{html}"


@takes(_core.describe_health)
def health(
    cell: Cell | str | os.PathLike[str],
    flights: Log | str | os.PathLike[str] | Iterable[Log | str | os.PathLike[str]],
    **options: Unpack[HealthOptions],
) -> Health:
    """Say how old a pack is from logs of flights on it.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        The cell when it was new.
    flights : Log or path, or several
        Logs of flights on one pack, the oldest first.
    {options}

    Returns
    -------
    Health
        With a table ``flights``.

    Raises
    ------
    LoadError
        Where no flight is long and busy enough to tell anything.
    """
    one = cell if isinstance(cell, Cell) else Cell.read(cell)
    several = [flights] if isinstance(flights, (Log, str, os.PathLike)) else list(flights)
    if not several:
        raise OptionError("health: expected at least one flight, found none")
    logs = [log if isinstance(log, Log) else read_log(log) for log in several]
    summary, sentence = _core.health(one._core, [log._core for log in logs], dict(options))
    return Health(sentence, summary)
