"""What goes wrong with files and options, with its place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Diagnostic(NamedTuple):
    """One thing that is wrong with an input: where, and what was expected and found."""

    file: str
    line: int
    column: int
    message: str


class LoadError(ValueError):
    """An input is not what it should be; a file that is not there is one too.

    Attributes
    ----------
    file : str
        The file, or the name of the log where it has none.
    line, column : int
        The place, counted from 1; 0 of a file that is not there.
    diagnostics : list of Diagnostic
        Everything that is wrong, the first one first.
    """

    def __init__(self, message: str, diagnostics: Sequence[tuple[str, int, int, str]] = ()) -> None:
        super().__init__(message)
        self.diagnostics = [Diagnostic(*one) for one in diagnostics]
        first = self.diagnostics[0] if self.diagnostics else Diagnostic("", 0, 0, message)
        self.file = first.file
        self.line = first.line
        self.column = first.column

    def __reduce__(self) -> tuple[type[LoadError], tuple[str, list[tuple[str, int, int, str]]]]:
        return type(self), (str(self), [(*one,) for one in self.diagnostics])


class OptionError(ValueError):
    """An argument is not what it should be; the message says what to give instead."""


class PreconditionError(RuntimeError):
    """A rule that a function states was broken: a mistake of lipoid, please report it."""
