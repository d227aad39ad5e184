"""Experiments before the lab: what they would tell, and what their logs would look like."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pandas as pd

from lipoid import _core
from lipoid._campaign import Campaign
from lipoid._cell import OneCell, as_cell
from lipoid._files import inputs_of
from lipoid._keywords import takes, whole_seed
from lipoid._log import Log, read_log
from lipoid._progress import Progress, Reporter

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._options import PlanOptions, SynthesizeOptions


@takes(_core.describe_plan)
def plan(
    cell: OneCell,
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
        rows.append({**row, "sentence": _core.in_python(one["sentence"])})
    table = pd.DataFrame(rows)
    summary["left_out"] = [_core.in_python(one) for one in summary.get("left_out", [])]
    table.attrs.update(summary)
    return table


@takes(_core.describe_synthesize)
def synthesize(
    cell: OneCell,
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
    one = as_cell(cell)
    truth = _core.with_parameters(one._core, {"parameters": parameters})
    one._tell_what_is_assumed(options)
    with Reporter(progress, "synthesize") as tell:
        if folder is not None:
            read = inputs_of(one)
            _core.synthesize(truth, folder, dict(options), whole_seed(seed), tell, read)
            return Campaign.read(Path(folder) / "campaign.toml")
        with tempfile.TemporaryDirectory() as own:
            _core.synthesize(truth, own, dict(options), whole_seed(seed), tell, [])
            written = Campaign.read(Path(own) / "campaign.toml")
            logs: dict[str, list[Log]] = {}
            for kind, file in written.entries[["kind", "file"]].itertuples(index=False):
                log = read_log(
                    Path(own) / file,
                    current_sign="discharge-positive",
                    hold=options.get("hold") or "backward",
                )
                logs.setdefault(kind.replace("-", "_"), []).append(log)
    return Campaign(
        name=written.name or truth.name,
        capacity_Ah=written.capacity_Ah,
        cutoff_V=written.cutoff_V,
        series=written.series,
        parallel=written.parallel,
        **cast(Any, logs),
    )
