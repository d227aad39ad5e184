"""How old a pack is, by flights on it."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from lipoid import _core
from lipoid._cell import OneCell, as_cell
from lipoid._files import inputs_of
from lipoid._keywords import takes
from lipoid._log import Logs, as_logs
from lipoid._report import Reportable

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._options import HealthOptions


@dataclass(eq=False, repr=False)
class Health(Reportable):
    """How old a pack is.

    Attributes
    ----------
    sentence : str
        The trend over the flights, else what the last one says.
    summary : dict
        What ``lipoid health --summary`` writes (docs/flight-logs.md).
    """

    _command = "health"
    sentence: str
    summary: dict[str, Any]
    _inputs: list[str] = field(default_factory=list, repr=False)

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
        count = len(self.summary["flights"])
        return f"Health({count} flight{'' if count == 1 else 's'}: {self.sentence})"

    def _repr_html_(self) -> str:
        html: str = self.flights.to_html(float_format=lambda x: f"{x:.5g}")
        return f"<p>{escape(self.sentence)}</p>{html}"


def describe_health() -> list[dict[str, Any]]:
    """Options of the health of a pack, and those of reading its flights."""
    own: list[dict[str, Any]] = _core.describe_health()
    return [*own, *_core.describe_reading(True)]


@takes(describe_health)
def health(
    cell: OneCell,
    flights: Logs,
    **options: Unpack[HealthOptions],
) -> Health:
    """Say how old a pack is from logs of flights on it.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        The cell when it was new.
    flights : Log, path or data frame, or several
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
    given: dict[str, Any] = dict(options)
    reading = {
        one["name"]: given.pop(one["name"])
        for one in _core.describe_reading(True)
        if one["name"] in given
    }
    logs = as_logs(flights, "health: expected at least one flight", reading)
    one = as_cell(cell)
    summary, sentence = _core.health(one._core, [log._core for log in logs], given)
    return Health(_core.in_python(sentence), summary, inputs_of(one, logs))
