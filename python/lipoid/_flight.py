"""A vehicle that flies a maneuver on a cell."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import pandas as pd

from lipoid import _core, plots
from lipoid._cell import OneCell, as_cell
from lipoid._files import inputs_of
from lipoid._keywords import takes, utf8, whole, whole_seed
from lipoid._log import Log
from lipoid._progress import Progress, Reporter
from lipoid._report import Reportable
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from lipoid._options import FlyOptions

logger = logging.getLogger("lipoid")


@dataclass(eq=False, repr=False)
class Flight(Reportable):
    """A flight of a vehicle on a cell.

    Attributes
    ----------
    data : pandas.DataFrame
        State, references, motors and battery over time, as ``lipoid fly -o`` writes them.
    summary : dict
        What ``lipoid fly --summary`` writes (docs/formats.md).
    """

    _command = "fly"
    data: pd.DataFrame
    summary: dict[str, Any]
    _inputs: list[str] = field(default_factory=list, repr=False)

    # Tables of pandas are not compared: each flight is itself alone.
    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]

    @property
    def outcome(self) -> str:
        """How it ended: "completed", "crashed", "battery-empty" or "off-course"."""
        return str(self.summary["outcome"])

    def log(self) -> Log:
        """Return current, voltage and, where the cell knows it, temperature of the battery."""
        warm = self.data.get("temperature_degC")
        return Log(
            time_s=self.data["time_s"].to_numpy(),
            current_A=self.data["battery_A"].to_numpy(),
            voltage_V=self.data["battery_V"].to_numpy(),
            temperature_degC=None if warm is None else warm.to_numpy(),
            name=str(self.summary["maneuver"]),
            current_sign="discharge-positive",
            hold="forward",
        )

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw altitude, angles and battery over time; return the axes."""
        return plots.flight(self.data, repr(self)[7:-1], axes)

    def _shown(self) -> Any:
        columns = {str(name): self.data[name].to_numpy(dtype=float) for name in self.data}
        return _core.shown_flight(self._summary_of_command(), columns)

    def __repr__(self) -> str:
        s = self.summary
        text = f"Flight({s['maneuver']!r} of {s['vehicle']!r} on {s['battery']!r}: {s['outcome']}"
        text += f" after {s['simulated_s']:.4g} s, {s['minimum_voltage_V']:.4g} V at the lowest)"
        return text

    def _repr_html_(self) -> str:
        rows = [
            (key, f"{value:.5g}" if isinstance(value, float) else str(value))
            for key, value in self.summary.items()
            if isinstance(value, (str, int, float)) and key != "wall_s"
        ]
        body = "".join(f"<tr><th>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in rows)
        return f"<table>{body}</table>"


@takes(_core.describe_fly)
def fly(
    maneuver: str,
    *,
    cell: OneCell | None = "gifi-600mAh-1",
    seed: int = 0,
    threads: int = 0,
    progress: Progress = False,
    **options: Unpack[FlyOptions],
) -> Flight:
    """Fly a maneuver: rigid body, motors, battery and flight controller, coupled.

    Parameters
    ----------
    maneuver : {"hover", "altitude-steps", "attitude-doublets", "square", "endurance", "waypoints"}
        What to fly.
    cell : Cell, path, name of a shipped cell, or None
        The battery; None: an ideal source of ``xi`` times the nominal voltage.
    seed : int
        Of gusts and of the noise of sensors.
    threads : int
        Cores to use; 0: all.
    progress : bool or callable
        As in :func:`identify`.
    {options}

    Returns
    -------
    Flight
        Also where the vehicle crashed or the battery ran empty: see ``outcome``.

    Examples
    --------
    >>> import lipoid
    >>> flight = lipoid.fly("hover", cell="gifi-600mAh-1", duration=2.0)
    >>> flight.outcome
    'completed'
    """
    if "ensemble" in options:
        raise OptionError(
            "unknown option 'ensemble'; a flight here is on one cell: fly on each of "
            "cell.resample(20), which are drawn as the command line draws them"
        )
    one = None if cell is None else as_cell(cell)
    with Reporter(progress, f"fly {maneuver}") as tell:
        summary, data = _core.fly(
            utf8("maneuver", maneuver),
            None if one is None else one._core,
            dict(options),
            whole_seed(seed),
            whole("threads", threads),
            tell,
        )
    if one is not None:
        one._tell_what_is_assumed(options)
    for doubt in [*summary["messages"], *summary["doubts"]]:
        logger.warning("%s: %s", summary["battery"], _core.in_python(doubt))
    return Flight(pd.DataFrame(data), summary, inputs_of(cell, options))


def maneuvers() -> list[str]:
    """Names of the maneuvers that :func:`fly` knows."""
    return _core.maneuver_names()


def vehicles() -> list[str]:
    """Names of the vehicles that are shipped."""
    return _core.vehicle_names()
