"""Comparisons, studies, plans, synthetic logs, flights, exports and fleets."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pandas as pd

from lipoid import _core
from lipoid._campaign import KINDS, Campaign
from lipoid._cell import Cell
from lipoid._identify import Identification, Progress, Reporter, as_campaign, identify
from lipoid._keywords import takes, whole
from lipoid._log import Log
from lipoid._report import report

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from lipoid._options import (
        CompareOptions,
        ExportOptions,
        FlyOptions,
        IdentifyOptions,
        PlanOptions,
        StudyOptions,
        SynthesizeOptions,
    )


def as_cell(cell: Cell | str | os.PathLike[str]) -> Cell:
    """Return a cell, or read the one of that name or file."""
    return cell if isinstance(cell, Cell) else Cell.read(cell)


@dataclass(repr=False)
class Comparison:
    """Optimizers on the same problem.

    Attributes
    ----------
    summary : dict
        What ``lipoid compare --summary`` writes (docs/formats.md).
    """

    summary: dict[str, Any]

    @property
    def results(self) -> pd.DataFrame:
        """One row per optimizer: errors, time, evaluations, successes, why it ended."""
        rows = [
            {key: value for key, value in one.items() if not isinstance(value, (dict, list))}
            for one in self.summary["results"]
        ]
        return pd.DataFrame(rows).set_index("optimizer")

    @property
    def parameters(self) -> pd.DataFrame:
        """What each optimizer found, one row each."""
        rows = {}
        for one in self.summary["results"]:
            flat: dict[str, float] = {}
            for key, value in one["parameters"].items():
                if isinstance(value, list):
                    for k, branch in enumerate(value, 1):
                        flat |= {f"{name}_{k}": number for name, number in branch.items()}
                else:
                    flat[key] = value
            rows[one["optimizer"]] = flat
        return pd.DataFrame.from_dict(rows, orient="index")

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw error over time, one point per optimizer; return the axes."""
        from lipoid import plots

        return plots.comparison(self, axes)

    def report(self, file: str | os.PathLike[str]) -> None:
        """Write it as one page with plots, for any browser, as ``--report`` does."""
        report(self, file)

    def _shown(self) -> Any:
        return _core.shown_summary(json.dumps({"command": "compare", **self.summary}))

    def __repr__(self) -> str:
        best = self.summary["best"]["optimizer"]
        return f"Comparison({len(self.results)} optimizers, best {best!r})"

    def _repr_html_(self) -> str:
        html: str = self.results.to_html(float_format=lambda x: f"{x:.5g}")
        return html


@takes(_core.describe_compare)
def compare(
    campaign: Campaign | str | os.PathLike[str],
    *,
    seed: int = 0,
    threads: int = 0,
    progress: Progress = False,
    **options: Unpack[CompareOptions],
) -> Comparison:
    """Run optimizers on the same logs, from the same start, with the same objective.

    Parameters
    ----------
    campaign : Campaign or path
        The logs.
    seed : int
        Of random starts and of optimizers that draw.
    threads : int
        Cores to use; 0: all.
    progress : bool or callable
        As in :func:`identify`.
    {options}

    Returns
    -------
    Comparison
        With the table ``results``.
    """
    made = as_campaign(campaign)
    with Reporter(progress, "compare") as tell:
        return Comparison(
            _core.compare(
                made._core, dict(options), whole("seed", seed), whole("threads", threads), tell
            )
        )


@takes(_core.describe_study)
def study(
    what: str,
    campaign: Campaign | str | os.PathLike[str],
    *,
    threads: int = 0,
    progress: Progress = False,
    **options: Unpack[StudyOptions],
) -> pd.DataFrame:
    """Do one stage of the identification in several ways.

    Parameters
    ----------
    what : {"branches", "ocv", "terms"}
        What is varied.
    campaign : Campaign or path
        The logs.
    threads : int
        Cores to use; 0: all.
    progress : bool or callable
        As in :func:`identify`.
    {options}

    Returns
    -------
    pandas.DataFrame
        One row per way; ``attrs`` has what holds for all rows.
    """
    made = as_campaign(campaign)
    with Reporter(progress, f"study {what}") as tell:
        summary = _core.study(what, made._core, dict(options), whole("threads", threads), tell)
    table = pd.DataFrame(summary.pop("rows"))
    table.attrs.update(summary)
    return table


@takes(_core.describe_plan)
def plan(
    cell: Cell | str | os.PathLike[str],
    *,
    progress: Progress = False,
    **options: Unpack[PlanOptions],
) -> pd.DataFrame:
    """Predict the standard errors that a pulse experiment would give, before the lab is booked.

    Lists are combined with one another, one row each. Of a cell that knows temperature, or with
    ``ambient_degC``, the whole protocol is planned, with activation energies and heat balance, and
    two more rows say what a second temperature would add: the same pulses there, or one.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        A cell like the one to be identified.
    progress : bool or callable
        As in :func:`identify`.
    {options}

    Returns
    -------
    pandas.DataFrame
        One row per experiment; columns ``NAME_standard_error`` in the units of the parameters, and
        ``sentence``. ``attrs`` has what the plan leaves out.
    """
    with Reporter(progress, "plan") as tell:
        summary = _core.plan(as_cell(cell)._core, dict(options), tell)
    rows = []
    for one in summary.pop("rows"):
        parameters = one.pop("parameters")
        row = {key: value for key, value in one.items() if key != "sentence"}
        for parameter in parameters:
            row[f"{parameter['name']}_standard_error"] = parameter["standard_error"]
        rows.append({**row, "sentence": one["sentence"]})
    table = pd.DataFrame(rows)
    table.attrs.update(summary)
    return table


@takes(_core.describe_synthesize)
def synthesize(
    cell: Cell | str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    parameters: Mapping[str, float] | None = None,
    seed: int = 0,
    progress: Progress = False,
    **options: Unpack[SynthesizeOptions],
) -> Campaign:
    """Make the lab's logs of a cell that is known, by the protocol of the thesis.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        The truth.
    folder : path, optional
        Where to write logs, campaign and truth; not given: the logs are kept in memory.
    parameters : dict, optional
        Parameters of the truth that are changed first: ``{"r_1": 0.03, "c_1": 1500.0}``.
    seed : int
        Of the noise.
    progress : bool or callable
        As in :func:`identify`.
    {options}

    Returns
    -------
    Campaign
        Its logs, to be identified.
    """
    truth = _core.with_parameters(as_cell(cell)._core, dict(parameters or {}))
    with Reporter(progress, "synthesize") as tell:
        if folder is not None:
            _core.synthesize(truth, folder, dict(options), whole("seed", seed), tell)
            return Campaign.read(Path(folder) / "campaign.toml")
        with tempfile.TemporaryDirectory() as own:
            _core.synthesize(truth, own, dict(options), whole("seed", seed), tell)
            written = Campaign.read(Path(own) / "campaign.toml")
            logs = {kind: written.logs(kind.replace("_", "-")) for kind in KINDS}
    given = {kind: some for kind, some in logs.items() if some}
    return Campaign(
        name=written.name or truth.name,
        capacity_Ah=written.capacity_Ah,
        cutoff_V=written.cutoff_V,
        **cast(Any, given),
    )


@dataclass(repr=False)
class Flight:
    """A flight of a vehicle on a cell.

    Attributes
    ----------
    data : pandas.DataFrame
        State, references, motors and battery over time, as ``lipoid fly -o`` writes them.
    summary : dict
        What ``lipoid fly --summary`` writes (docs/formats.md).
    """

    data: pd.DataFrame
    summary: dict[str, Any]

    @property
    def outcome(self) -> str:
        """How it ended: "completed", "crashed" or "battery-empty"."""
        return str(self.summary["outcome"])

    def log(self) -> Log:
        """Return current and voltage of the battery as a log."""
        return Log(
            time_s=self.data["time_s"].to_numpy(),
            current_A=self.data["battery_A"].to_numpy(),
            voltage_V=self.data["battery_V"].to_numpy(),
            name=str(self.summary["maneuver"]),
            current_sign="discharge-positive",
            hold="forward",
        )

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw altitude, angles and battery over time; return the axes."""
        from lipoid import plots

        return plots.flight(self, axes)

    def report(self, file: str | os.PathLike[str]) -> None:
        """Write it as one page with plots, for any browser, as ``--report`` does."""
        report(self, file)

    def _shown(self) -> Any:
        columns = {str(name): self.data[name].to_numpy(dtype=float) for name in self.data}
        return _core.shown_flight(json.dumps({"command": "fly", **self.summary}), columns)

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
    cell: Cell | str | os.PathLike[str] | None = "gifi-600mAh-1",
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
    core = None if cell is None else as_cell(cell)._core
    with Reporter(progress, f"fly {maneuver}") as tell:
        summary, data = _core.fly(
            maneuver, core, dict(options), whole("seed", seed), whole("threads", threads), tell
        )
    return Flight(pd.DataFrame(data), summary)


@takes(_core.describe_export)
def export(
    cell: Cell | str | os.PathLike[str],
    target: str,
    output: str | os.PathLike[str],
    **options: Unpack[ExportOptions],
) -> dict[str, Any]:
    """Write a cell as the battery of another program, and say how far that is from the cell.

    Parameters
    ----------
    cell : Cell, path or name of a shipped cell
        The cell, or the pack (:meth:`Cell.pack`).
    target : str
        The program; :func:`targets` has their names.
    output : path
        The first file; others stand beside it with its stem.
    {options}

    Returns
    -------
    dict
        What ``lipoid export --summary`` writes (docs/formats.md).
    """
    given: dict[str, Any] = dict(options)
    if isinstance(given.get("mission"), Log):
        given["mission"] = given["mission"]._core
    return _core.export(as_cell(cell)._core, target, output, given)


def targets() -> list[str]:
    """Names of the programs that :func:`export` writes for."""
    return _core.target_names()


def optimizers() -> list[str]:
    """Names of the optimizers that :func:`compare` knows."""
    return _core.optimizer_names()


def maneuvers() -> list[str]:
    """Names of the maneuvers that :func:`fly` knows."""
    return _core.maneuver_names()


def vehicles() -> list[str]:
    """Names of the vehicles that are shipped."""
    return _core.vehicle_names()


@dataclass(repr=False)
class Fleet:
    """What became of many campaigns, in their order.

    Attributes
    ----------
    table : pandas.DataFrame
        One row each: campaign, status ("done" or "failed"), error, converged, usable and the
        estimates by name.
    results : list
        The :class:`Identification` of each, or its exception.
    """

    table: pd.DataFrame
    results: list[Identification | BaseException] = field(repr=False)

    def __len__(self) -> int:
        return len(self.results)

    def __iter__(self) -> Iterator[Identification | BaseException]:
        return iter(self.results)

    def __repr__(self) -> str:
        failed = int((self.table["status"] == "failed").sum())
        return f"Fleet({len(self)} campaigns, {failed} failed)"

    def _repr_html_(self) -> str:
        html: str = self.table.to_html(float_format=lambda x: f"{x:.5g}")
        return html


def identify_or_error(campaign: Any, options: dict[str, Any]) -> Identification | Exception:
    """Identify one of many: what is wrong with it is its result."""
    try:
        return identify(campaign, **options)
    except Exception as error:
        return error


def identify_many(
    campaigns: Iterable[Campaign | str | os.PathLike[str]],
    *,
    executor: Any = None,
    progress: Progress = False,
    **options: Unpack[IdentifyOptions],
) -> Fleet:
    """Identify many cells; a campaign that fails is a row with its error, never a lost run.

    Parameters
    ----------
    campaigns : iterable of Campaign or path
        One per cell.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Who does the work: a pool of threads or of processes of this machine, or a cluster. Not
        given: one after the other, each on all cores. Processes must be started by "spawn" or
        "forkserver": threads do not survive a fork.
    progress : bool or callable
        As in :func:`identify`; the share of campaigns that are done.
    **options
        Of :func:`identify`, and seed and threads.

    Returns
    -------
    Fleet
        In the order of the campaigns.
    """
    given: dict[str, Any] = dict(options)
    if isinstance(campaigns, (str, os.PathLike)):
        raise TypeError("identify_many: expected several campaigns; one goes into a list")
    several = list(campaigns)
    results: list[Identification | BaseException] = []
    with Reporter(progress, "identify_many") as tell:
        futures: list[Any] = []
        try:
            if executor is not None:
                extra = {} if isinstance(executor, Executor) else {"pure": False}
                futures = [
                    executor.submit(identify_or_error, one, given, **extra) for one in several
                ]
            for k, one in enumerate(several):
                try:
                    results.append(
                        futures[k].result() if futures else identify_or_error(one, given)
                    )
                except Exception as error:  # of the executor: a worker that died
                    results.append(error)
                if tell is not None:
                    tell((k + 1) / len(several), f"{k + 1} of {len(several)}")
        except KeyboardInterrupt:
            for future in futures:
                future.cancel()
            _core.stop_all_work()
            raise
    rows = []
    for one, result in zip(several, results, strict=True):
        name = (one.name or one.file) if isinstance(one, Campaign) else os.fspath(one)
        row: dict[str, Any] = {"campaign": name, "status": "done", "error": ""}
        if isinstance(result, Identification):
            row |= {"converged": result.converged, "usable": result.usable}
            row |= {str(k): v for k, v in result.parameters["estimate"].items()}
        else:
            row |= {"status": "failed", "error": f"{type(result).__name__}: {result}"}
        rows.append(row)
    columns = ["campaign", "status", "error"]
    return Fleet(pd.DataFrame(rows, columns=None if rows else columns), results)
