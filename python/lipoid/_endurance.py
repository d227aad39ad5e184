"""How long a vehicle flies on a pack."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from lipoid import _core
from lipoid._cell import OneCell, as_cell
from lipoid._files import inputs_of
from lipoid._keywords import takes, whole, whole_seed
from lipoid._progress import Progress, Reporter
from lipoid._report import Reportable
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._options import EnduranceOptions


@dataclass(eq=False, repr=False)
class Endurance(Reportable):
    """How long a vehicle flies, and how far that is known.

    Attributes
    ----------
    summary : dict
        What ``lipoid endurance --summary`` writes (docs/formats.md), without the table of
        ``--over``.
    """

    _command = "endurance"
    summary: dict[str, Any]
    _inputs: list[str] = field(default_factory=list, repr=False)

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
    cell: OneCell,
    *,
    seed: int = 0,
    threads: int = 0,
    progress: Progress = False,
    **options: Unpack[EnduranceOptions],
) -> Endurance:
    """Say how long a vehicle flies on a pack, with an interval.

    The vehicle is in equilibrium all the time; :func:`fly` flies it with a controller. An option
    that is a pair has a standard error, which widens the intervals, as the uncertainty of the
    cell does. The table that ``--over`` makes of a quantity is a loop over calls:
    ``{m: lipoid.endurance(cell, vehicle="f450", payload_g=m).minutes for m in (0, 250, 500)}``.

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
    if "=" in (mission := str(options.get("mission"))):
        raise OptionError(
            f"option mission: expected hover or cruise, found {mission!r}; a file of waypoints is "
            "given as waypoints=FILE, and powers are given as power=(times_s, powers_W)"
        )
    one = as_cell(cell)
    with Reporter(progress, "endurance") as tell:
        summary = _core.endurance(
            one._core, dict(options), whole_seed(seed), whole("threads", threads), tell
        )
    one._tell_what_is_assumed(options, summary["capacity_Ah"] / one.capacity_Ah)
    one._tell(*summary["messages"])
    return Endurance(summary, inputs_of(one, options))
