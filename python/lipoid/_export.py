"""A cell as the battery of another program."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from lipoid import _core
from lipoid._cell import OneCell, as_cell
from lipoid._files import inputs_of
from lipoid._keywords import present, takes, utf8
from lipoid._log import mission_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._options import ExportOptions


@takes(_core.describe_export)
def export(
    cell: OneCell,
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
    one = as_cell(cell)
    read = inputs_of(one, given.get("mission"))
    if "mission" in given:
        given["mission"] = mission_of(given["mission"])
    summary, warnings = _core.export(
        one._core, utf8("target", target), present("output", output), given, read
    )
    one._tell(*warnings)
    return summary


def targets() -> list[str]:
    """Names of the programs that :func:`export` writes for."""
    return _core.target_names()
