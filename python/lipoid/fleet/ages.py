"""Ages of cells: numbers, or dates, which count in days since the first one."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence

import numpy as np

from lipoid.fleet.sources import as_number

EIGHT_DIGITS = re.compile(r"([0-9]{4})([0-9]{2})([0-9]{2})")
FIRST = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
LONGEST_SHOWN = 40


def _number(value: object) -> float:
    number = as_number(value.strip()) if isinstance(value, str) else value
    return float(number) if isinstance(number, (int, float)) and np.isfinite(number) else np.nan


def _days(value: object) -> float:
    """Return the days since 1970 of a date; one without a zone is of UTC on every machine."""
    text = str(value).strip()
    if digits := EIGHT_DIGITS.fullmatch(text):
        text = "-".join(digits.groups())
    elif np.isfinite(_number(value)):
        return np.nan
    try:
        date = datetime.datetime.fromisoformat(re.sub("[zZ]$", "+00:00", text))
    except ValueError:
        return np.nan
    if date.tzinfo is None:
        date = date.replace(tzinfo=datetime.timezone.utc)
    return (date - FIRST) / datetime.timedelta(days=1)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" + ("" if count == 1 else "s")


def read(column: str, values: Sequence[object]) -> tuple[np.ndarray, str]:
    """Return ages as numbers, NaN where there is none, and a sentence on those left out.

    Numbers and dates cannot be compared: the kind that more cells have is used. Eight digits are
    dates, as 20240131, where half of the numbers or more can be such dates.
    """
    numbers = np.array([_number(value) for value in values], dtype=float)
    days = np.array([_days(value) for value in values], dtype=float)
    is_number, is_date = np.isfinite(numbers), np.isfinite(days)
    digits = is_number & is_date
    if 2 * digits.sum() >= is_number.sum():
        is_number &= ~digits
    else:
        is_date &= ~digits
    given = np.array([value is not None and str(value).strip() != "" for value in values], bool)
    by_date = bool(is_date.any() and is_date.sum() >= is_number.sum())
    used = is_date if by_date else is_number
    ages = np.where(used, days if by_date else numbers, np.nan)
    if by_date:
        ages -= np.nanmin(ages)
    left_out = []
    for noun, of in (("number", is_number), ("date", is_date)):
        if (of & ~used).any():
            left_out.append(_counted(int(of.sum()), noun) + _example(values, of))
    if (of := given & ~is_number & ~is_date).any():
        noun = _counted(int(of.sum()), "value") + (" that is" if of.sum() == 1 else " that are")
        left_out.append(f"{noun} neither a number nor a date{_example(values, of)}")
    if not left_out:
        return ages, ""
    kind = _counted(int(used.sum()), "date" if by_date else "number")
    return ages, (
        f"The slopes use {f'the {kind}' if used.any() else 'nothing'} of the column {column} and "
        f"leave out {' and '.join(left_out)}. Write every age as a number, or every one as a date "
        "such as 2024-01-31."
    )


def _example(values: Sequence[object], of: np.ndarray) -> str:
    return f" (as {repr(values[int(np.argmax(of))])[:LONGEST_SHOWN]})"
