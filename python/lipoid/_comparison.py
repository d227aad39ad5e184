"""Optimizers on the same problem, and a stage of the identification done in several ways."""

from __future__ import annotations

import html
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from lipoid import _core, plots
from lipoid._campaign import Campaign, as_campaign
from lipoid._keywords import takes, utf8, whole, whole_seed
from lipoid._progress import Progress, Reporter
from lipoid._report import Reportable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from lipoid._options import CompareOptions, StudyOptions


@dataclass(eq=False, repr=False)
class Comparison(Reportable):
    """Optimizers on the same problem.

    Attributes
    ----------
    summary : dict
        What ``lipoid compare --summary`` writes (docs/formats.md).
    """

    _command = "compare"
    summary: dict[str, Any]
    _inputs: list[str] = field(default_factory=list, repr=False)

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

    @property
    def cautions(self) -> list[str]:
        """Why the best is no answer, where it is none, and which numbers are no findings."""
        because = self.summary["no_answer_because"]
        said = [*([because] if because else []), *self.summary["cautions"]]
        return [_core.in_python(one) for one in said]

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw how far errors are above the least over time; return the axes."""
        return plots.comparison(self.results, axes)

    def __repr__(self) -> str:
        best = self.summary["best"]["optimizer"]
        but = ", which is no answer" if self.summary["no_answer_because"] else ""
        return f"Comparison({len(self.results)} optimizers, best {best!r}{but})"

    def _repr_html_(self) -> str:
        table: str = self.results.to_html(float_format=lambda x: f"{x:.5g}")
        return table + "".join(f"<p>{html.escape(caution)}</p>" for caution in self.cautions)


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
                made._core, dict(options), whole_seed(seed), whole("threads", threads), tell
            ),
            made._inputs,
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
        summary = _core.study(
            utf8("what", what), made._core, dict(options), whole("threads", threads), tell
        )
    table = pd.DataFrame(summary.pop("rows"))
    table.attrs.update(summary)
    return table


def optimizers() -> list[str]:
    """Names of the optimizers that :func:`compare` knows."""
    return _core.optimizer_names()
