"""The options of reading logs, as types.

Made by ``python -m lipoid._write_options`` from the one declaration that the command line and the
docstrings are made from, too: do not edit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict


class ReadingOptions(TypedDict, total=False):
    """Keyword arguments."""

    columns: Mapping[str, str | int] | None
    units: str | Sequence[str] | None
    current_sign: str
    hold: Literal["backward", "forward"]
    battery: int | None
    most_rows: int | None
    start_s: float
    end_s: float
    lead_resistance_Ohm: float
    steps: int | Sequence[int] | None
    cycles: int | Sequence[int] | None
    voltage_optional: bool


class ColumnOptions(TypedDict, total=False):
    """Keyword arguments."""

    current_sign: str
    hold: Literal["backward", "forward"]
    start_s: float
    end_s: float
    lead_resistance_Ohm: float
