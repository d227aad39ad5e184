"""Many campaigns, one after the other or side by side."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from lipoid import _core
from lipoid._campaign import Campaign
from lipoid._identification import Identification, check_options, identify
from lipoid._progress import Progress, Reporter

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._options import IdentifyOptions


@dataclass(eq=False, repr=False)
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


def _name_of(campaign: Any) -> str:
    if isinstance(campaign, Campaign):
        return campaign.name or campaign.file
    return os.fsdecode(campaign) if isinstance(campaign, (str, os.PathLike)) else repr(campaign)


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
    seed: int = 0,
    threads: int = 0,
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
    seed, threads : int
        As in :func:`identify`.
    progress : bool or callable
        As in :func:`identify`; the share of campaigns that are done.
    **options
        Of :func:`identify`.

    Returns
    -------
    Fleet
        In the order of the campaigns.

    Raises
    ------
    OptionError
        For options that do not exist, are out of range or contradict each other, before a campaign
        is read.
    """
    given: dict[str, Any] = {"seed": seed, "threads": threads, **options}
    if isinstance(campaigns, (str, os.PathLike, Campaign)):
        raise TypeError("identify_many: expected several campaigns; one goes into a list")
    several = list(campaigns)
    check_options(**given)
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
        name = _name_of(one)
        row: dict[str, Any] = {"campaign": name, "status": "done", "error": ""}
        if isinstance(result, Identification):
            row |= {"converged": result.converged, "usable": result.usable}
            row |= {str(k): v for k, v in result.parameters["estimate"].items()}
        else:
            row |= {"status": "failed", "error": f"{type(result).__name__}: {result}"}
        rows.append(row)
    columns = ["campaign", "status", "error"]
    return Fleet(pd.DataFrame(rows, columns=None if rows else columns), results)
