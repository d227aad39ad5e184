"""From logs to a cell, and how well it predicts others."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from lipoid import _core, plots
from lipoid._campaign import Campaign, as_campaign
from lipoid._cell import Cell, OneCell, as_cell
from lipoid._keywords import takes, whole, whole_seed
from lipoid._log import Logs, as_logs
from lipoid._progress import Progress, Reporter
from lipoid._report import Reportable
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from lipoid._options import IdentifyOptions
    from lipoid._reading_options import ReadingOptions

logger = logging.getLogger("lipoid")


@dataclass(eq=False, repr=False)
class Identification(Reportable):
    """What identification found.

    Attributes
    ----------
    cell : Cell
        With the uncertainty of its parameters, and how it was made.
    summary : dict
        What ``lipoid identify --summary`` writes (docs/formats.md).
    converged : bool
        Whether the search converged. A result that did not is a result.
    usable : bool
        Whether the cell describes its own logs, too.
    sentence : str
        How well it predicts the logs it was made from.
    campaign : Campaign
        What it was made from.
    """

    _command = "identify"
    cell: Cell
    summary: dict[str, Any]
    converged: bool
    usable: bool
    sentence: str
    campaign: Campaign = field(repr=False)
    _staged: Cell | None = field(default=None, repr=False)

    @property
    def parameters(self) -> pd.DataFrame:
        """Estimate, standard error, 95 % interval and verdict of each parameter, by name."""
        rows = []
        for one in self.summary["parameters"]:
            low, high = one.get("interval_95") or (np.nan, np.nan)
            rows.append(
                {
                    "name": one["name"],
                    "unit": one["unit"],
                    "estimate": one["estimate"],
                    "standard_error": one["standard_error"],
                    "low_95": low,
                    "high_95": high,
                    "verdict": one["verdict"],
                    "with": ", ".join(one["with"]),
                }
            )
        return pd.DataFrame(rows).set_index("name")

    @property
    def logs(self) -> pd.DataFrame:
        """Errors of the prediction of each log that took part, over all of its rows."""
        return pd.DataFrame(_core.errors_of_logs(self.cell._core, self.campaign._core))

    def plot(self, what: str = "fit", axes: Any = None) -> list[Axes]:
        """Draw the result; return the axes.

        Parameters
        ----------
        what : {"fit", "open_circuit_voltage", "resistances", "correlation", "profile"}
            Fit and residuals over time; v_oc(A) with rows of the low-rate log; resistances over the
            state of charge with intervals; correlation of the estimates; profiles, of a result that
            was asked for some (``profile=``).
        axes : matplotlib axes, optional
            Where to draw.
        """
        drawings = {
            "fit": lambda: plots.fit(self._predicted(), self.sentence, axes),
            "open_circuit_voltage": lambda: self._plot_open_circuit_voltage(axes),
            "resistances": lambda: plots.resistances(
                self.cell._resistances(), self.parameters, self.cell.name, axes
            ),
            "correlation": lambda: plots.correlation(self.cell.to_dict().get("uncertainty"), axes),
            "profile": lambda: plots.profiles(self.summary.get("profiles"), axes),
        }
        if what not in drawings:
            raise OptionError(f"plot: expected one of {', '.join(drawings)}, found '{what}'")
        return drawings[what]()

    def _plot_open_circuit_voltage(self, axes: Any) -> list[Axes]:
        soc = np.linspace(0.0, 1.0, 501)
        curve_V = self.cell.pack(1, 1).open_circuit_voltage(soc)
        slow = self._predicted("low-rate")
        return plots.open_circuit_voltage(slow, soc, curve_V, self.cell.name, axes)

    def _predicted(self, only: str | None = None) -> Iterator[plots.Predicted]:
        """Of each log with voltages that took part: what was measured, what the cell predicts."""
        logs = _core.predict_logs(self.cell._core, self.campaign._core, only)
        for kind, log, voltage_V, soc in logs:
            if log.voltage_V is not None:
                yield plots.Predicted(kind, log.time_s, log.voltage_V, voltage_V, soc)

    @property
    def _inputs(self) -> list[str]:  # type: ignore[override]
        return self.campaign._inputs

    def _shown(self) -> Any:
        return _core.shown_identification(
            self._summary_of_command(),
            self.campaign._core,
            self.cell._core,
            None if self._staged is None else self._staged._core,
        )

    def __repr__(self) -> str:
        state = "" if self.converged else ", not converged"
        return f"Identification({self.cell.name!r}{state}: {self.sentence})"

    def _repr_html_(self) -> str:
        table = self.parameters.to_html(float_format=lambda x: f"{x:.5g}")
        note = "" if self.converged else "<p><b>not converged</b></p>"
        return f"<b>{escape(self.cell.name)}</b><p>{escape(self.sentence)}</p>{note}{table}"


@takes(_core.describe_identify)
def identify(
    campaign: Campaign | str | os.PathLike[str],
    *,
    seed: int = 0,
    threads: int = 0,
    progress: Progress = False,
    **options: Unpack[IdentifyOptions],
) -> Identification:
    """Find the parameters of a cell from its logs.

    The joint method, the default, is one fit of all logs, with resistances over the state of charge
    where these predict held-out rows better. The staged method is that of the thesis.

    Parameters
    ----------
    campaign : Campaign or path
        The logs.
    seed : int
        Of what is random.
    threads : int
        Cores to use; 0: all.
    progress : bool or callable
        True draws a bar by tqdm, or logs where tqdm is not installed; a function gets the share
        done and what is being done.
    {options}

    Returns
    -------
    Identification
        Also where the search did not converge: see ``converged`` and ``usable``.

    Raises
    ------
    LoadError
        For logs that are not what the campaign says they are.
    OptionError
        For options that do not exist, are out of range, or do not fit the logs.
    KeyboardInterrupt
        Ctrl-C ends the search; nothing is changed by it.

    Examples
    --------
    >>> import lipoid
    >>> campaign = lipoid.synthesize("gifi-600mAh-1", sampling_s=1.0)
    >>> result = lipoid.identify(campaign, method="staged")
    >>> result.converged
    True
    """
    made = as_campaign(campaign)
    with Reporter(progress, f"identify {made.name}".strip()) as tell:
        core, staged, summary, converged, usable, sentence = _core.identify(
            made._core, dict(options), whole_seed(seed), whole("threads", threads), tell
        )
    _tell_what_changes_nothing(dict(options))
    for note in summary.get("log_notes", []):
        logger.warning("%s", _core.in_python(note))
    if not converged:
        logger.warning("%s: not converged", made.name)
    beside = None if staged is None else Cell._of(staged)
    said = _core.in_python(sentence)
    return Identification(Cell._of(core), summary, converged, usable, said, made, beside)


def _tell_what_changes_nothing(options: Mapping[str, Any]) -> None:
    """Log which groups of options are of the other method, or of the staged run alone."""
    if options.get("method") == "staged":
        if options.get("joint"):
            logger.warning('option joint changes nothing with method="staged"')
        return
    pulses = options.get("pulses") or {}
    said = [f"pulses[{name!r}]" for name in ("branches", "starts") if name in pulses]
    if options.get("open_circuit_voltage_fit"):
        said.append("open_circuit_voltage_fit")
    if said:
        logger.warning(
            "options %s are of the staged run alone, from which the joint fit starts: "
            "branches and joint are of the cell",
            " and ".join(said),
        )


def check_options(*, seed: int = 0, threads: int = 0, **options: Any) -> None:
    """Raise what :func:`identify` says of such options, whatever the campaign."""
    whole_seed(seed)
    whole("threads", threads)
    _core.check_identify(options)


@takes(lambda: _core.describe_reading(True))
def validate(
    cell: OneCell,
    logs: Logs,
    *,
    initial_soc: float | None = None,
    initial_voltage_V: float | None = None,
    ambient_degC: float | None = None,
    initial_degC: float | None = None,
    predict_temperature: bool = False,
    **reading: Unpack[ReadingOptions],
) -> pd.DataFrame:
    """Compare the voltage that a cell predicts with that of logs, as of one cell.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        The cell, or the pack that the logs are of (:meth:`Cell.pack`).
    logs : Log, path or data frame, or several
        With voltages. A cell that knows temperature is as warm as the log says.
    initial_soc : float
        State of charge of the first row; 1 where nothing is said.
    initial_voltage_V : float, optional
        Instead: the voltage at which the pack rested before the first row, in V.
    ambient_degC : float, optional
        Temperature of the surroundings of logs that have none; not given: the reference of the
        cell.
    initial_degC : float, optional
        Temperature of the cell at the first row, where its temperature is predicted; not given:
        that of the log's first row, else of the surroundings.
    predict_temperature : bool
        Predict the temperature also of logs that have it, with surroundings as warm as their first
        row where ``ambient_degC`` is not given; ``temperature_rmse_K`` is how far it is off.
    {options}

    Returns
    -------
    pandas.DataFrame
        One row per log: file, mean_error_percent, max_error_percent, rmse_V, and the same of rows
        above 10 % state of charge. Its ``attrs`` have what ``lipoid validate --summary`` says of
        all logs together: ``fit`` with the verdict ("good", "fair" or "poor") and the reason why
        it is no better, and ``edges``.
    """
    one = as_cell(cell)
    one._tell_what_says_nothing(ambient_degC, initial_degC)
    if predict_temperature and not one._core.knows_temperature:
        logger.warning("predict_temperature changes nothing: the cell knows no temperature")
    options = {
        "initial_soc": initial_soc,
        "initial_voltage_V": initial_voltage_V,
        "ambient_degC": ambient_degC,
        "initial_degC": initial_degC,
        "predict_temperature": predict_temperature,
    }
    several = as_logs(logs, "validate: expected at least one log", reading)
    replaced = "" if predict_temperature else one._in_place_of(ambient_degC, initial_degC)
    for log in several:
        if replaced and log.temperature_degC is not None:
            logger.warning("%s: %s", log.file, replaced)
        if log._core.rows_kept != len(log):
            logger.warning(
                "%s: %s; the errors are of those, and read without most_rows they are of all",
                log.file,
                log._rows(),
            )
    rows, verdict = _core.validate(one._core, [log._core for log in several], options)
    for log, row in zip(several, rows, strict=True):
        if doubt := row.pop("doubt", ""):
            logger.warning("%s %s", log.file, doubt)
    table = pd.DataFrame(rows)
    table.attrs.update(verdict)
    return table
