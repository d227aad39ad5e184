"""What ends the command ``lipoid-fleet`` with a message and an exit code, as ``lipoid`` does."""

from __future__ import annotations

import contextlib
import sys

DONE = 0
INCOMPLETE = 1  # a campaign failed or did not converge, or the run ended early
USAGE = 2
BAD_INPUT = 3
INTERNAL = 4  # a mistake of lipoid


def say(text: str, end: str = "\n") -> None:
    """Print to the standard error. Where that is full or nobody reads it, the work goes on."""
    with contextlib.suppress(OSError):
        print(text, end=end, file=sys.stderr, flush=True)


class UsageError(Exception):
    """What was asked for cannot be: options, outputs, a scheduler that does not answer."""


class Stopped(Exception):  # noqa: N818 (no error: what was written stays)
    """The run ended before every campaign had its row; the message says why."""
