"""The files that stand behind arguments and results, so that nothing is written over them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TypeVar

from lipoid import _core
from lipoid._keywords import present

_Path = TypeVar("_Path", bound="str | os.PathLike[str]")


def inputs_of(*given: Any) -> list[str]:
    """Return the paths among arguments, and the files that logs, cells and results come from."""
    files: list[str] = []
    for one in given:
        if isinstance(one, (str, bytes, os.PathLike)):
            files.append(os.path.abspath(os.fsdecode(one)))
        elif isinstance(one, Mapping):
            files += inputs_of(*one.values())
        elif isinstance(one, (list, tuple)):
            files += inputs_of(*one)
        else:
            files += getattr(one, "_inputs", [])
    return files


def output(name: str, file: _Path, *given: Any) -> _Path:
    """Return the path of a file to write, or say that it is missing or stands behind these."""
    _core.refuse_inputs(name, present(name, file), inputs_of(*given))
    return file
