"""Results as one page for a browser."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, Protocol

from lipoid import _core
from lipoid._keywords import present
from lipoid.errors import OptionError


class Reportable(Protocol):
    """A result that a page can show: an identification, a comparison, a flight."""

    def _shown(self) -> Any: ...


def report(results: Reportable | Iterable[Reportable], file: str | os.PathLike[str]) -> None:
    """Write results as one page with plots: one file, which needs no network.

    Parameters
    ----------
    results : Identification, Comparison or Flight, or several
        Shown one under another; flights over one another.
    file : path
        The page to write, HTML.

    Raises
    ------
    OptionError
        Where lipoid was built without npm, which fetches what pages are made of.
    """
    several = list(results) if isinstance(results, Iterable) else [results]
    if not several:
        raise OptionError("report: expected at least one result, found none")
    for one in several:
        if not hasattr(one, "_shown"):
            raise TypeError(f"report: expected results, found {type(one).__name__}")
    _core.write_report([one._shown() for one in several], present("file", file))
