"""Results of commands, and pages of them for a browser."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from typing import Any, ClassVar

from lipoid import _core
from lipoid._files import output
from lipoid.errors import OptionError

# Of a summary: what differs from run to run.
_OF_THE_RUN = {"run", "time_to_target_s", "wall_s"}


def without_run(value: Any) -> Any:
    """Return a summary, or a part of it, without what differs from run to run."""
    if isinstance(value, dict):
        return {key: without_run(of) for key, of in value.items() if key not in _OF_THE_RUN}
    return [without_run(one) for one in value] if isinstance(value, list) else value


class Reportable:
    """A result that has a page: what a command found, whose summary it holds."""

    summary: dict[str, Any]
    _command: ClassVar[str]
    _inputs: list[str]

    def report(self, file: str | os.PathLike[str]) -> None:
        """Write it as one page with plots, for any browser, as ``--report`` does."""
        report(self, file)

    def _shown(self) -> Any:
        return _core.shown_summary(self._summary_of_command())

    def _summary_of_command(self) -> str:
        return json.dumps({"command": self._command, **self.summary})

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and without_run(self.summary) == without_run(
            getattr(other, "summary", None)
        )

    __hash__ = None  # type: ignore[assignment]


def report(results: Reportable | Iterable[Reportable], file: str | os.PathLike[str]) -> None:
    """Write results as one page with plots: one file, which needs no network.

    Parameters
    ----------
    results : Identification, Comparison, Flight, Endurance or Health, or several
        Shown one under another; flights over one another.
    file : path
        The page to write, HTML. The command line has pages of other results, too (``--report``).

    Raises
    ------
    OptionError
        Where lipoid was built without npm, which fetches what pages are made of, or the page is one
        of the files that the results come from.
    """
    given: Any = results
    is_one = hasattr(given, "columns") or not isinstance(given, Iterable)
    several = [given] if is_one else list(given)
    if not several:
        raise OptionError("report: expected at least one result, found none")
    for one in several:
        if not isinstance(one, Reportable):
            raise TypeError(
                "report: expected an Identification, Comparison, Flight, Endurance or Health, or "
                f"several, found {type(one).__name__}; of study, validate and plan the command "
                "line writes the page: lipoid study --report page.html"
            )
    _core.write_report([one._shown() for one in several], output("file", file, several))
