"""What a worker of dask does: a process of its own identifies, and the worker watches it."""

from __future__ import annotations

import atexit
import contextlib
import datetime
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any

import lipoid
from lipoid.fleet.results import Row

# A process that answers nothing for so long cannot be started here.
START_S = 120.0


@dataclass(frozen=True)
class Settings:
    """How campaigns are identified, the same for all of a run.

    Attributes
    ----------
    options : dict
        Keywords of :func:`lipoid.identify`.
    time_limit_s : float
        Wall time of one campaign; 0: none.
    memory_bytes : int
        Memory of the process that identifies; 0: no limit.
    retries : int
        How often a campaign is tried again that died, or passed a limit.
    """

    options: dict[str, Any]
    time_limit_s: float = 0.0
    memory_bytes: int = 0
    retries: int = 1


# Modules are not taken from the folder in which one happens to be: its files may be from elsewhere.
RUN = (
    "import sys; sys.path[:] = [place for place in sys.path if place]; "
    "from lipoid.fleet.runner import main; main()"
)


class Died(Exception):  # noqa: N818
    """The process ended before it answered."""


class Late(Exception):  # noqa: N818
    """The process did not answer in time."""


class Runner:
    """A process of lipoid.fleet.runner."""

    def __init__(self, memory_bytes: int) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", RUN, str(memory_bytes)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for whoever asked
        )
        self.memory_bytes = memory_bytes
        self._read = b""
        try:
            self.version: Row = json.loads(self._line(START_S))
        except (Died, Late) as error:
            self.kill()
            raise Died(f"could not be started: {error}") from None

    def ask(self, campaign: str, options: dict[str, Any], time_limit_s: float) -> Row:
        """Return the row of a campaign.

        Raises
        ------
        Died, Late
            The process is gone then.
        """
        question = json.dumps({"campaign": campaign, "options": options}).encode() + b"\n"
        assert self.process.stdin is not None
        try:
            try:
                self.process.stdin.write(question)
                self.process.stdin.flush()
            except OSError:
                pass  # it died; reading says how
            row: Row = json.loads(self._line(time_limit_s))
            return row
        except BaseException:
            self.kill()
            raise

    def _line(self, limit_s: float) -> bytes:
        assert self.process.stdout is not None
        descriptor = self.process.stdout.fileno()
        ready = select.poll()  # select() knows no descriptor beyond 1023
        ready.register(descriptor, select.POLLIN)
        end = time.monotonic() + limit_s
        while b"\n" not in self._read[-1:]:
            left_s = end - time.monotonic() if limit_s > 0.0 else None
            if left_s is not None and left_s <= 0.0:
                raise Late
            if not ready.poll(None if left_s is None else 1000.0 * left_s):
                continue
            if not (more := os.read(descriptor, 1 << 20)):
                raise Died(self._how_it_ended())
            self._read += more
        line, self._read = self._read, b""
        return line

    def _how_it_ended(self) -> str:
        code = self.process.wait()
        if code >= 0:
            return f"the process that identified it ended with exit code {code}"
        name = signal.Signals(-code).name
        text = f"the process that identified it was killed by {name}"
        return text + (", as the kernel does where memory runs out" if code == -9 else "")

    def is_alive(self) -> bool:
        """Whether it can be asked."""
        return self.process.poll() is None

    def kill(self) -> None:
        """End it at once."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()


_own = threading.local()  # a thread of dask has a process
_all: list[Runner] = []
_stopping = threading.Event()


def _runner(memory_bytes: int) -> Runner:
    runner: Runner | None = getattr(_own, "runner", None)
    if runner is None or not runner.is_alive() or runner.memory_bytes != memory_bytes:
        if runner is not None:
            runner.kill()
            _all.remove(runner)
            _own.runner = None
        _own.runner = runner = Runner(memory_bytes)
        _all.append(runner)
    return runner


def stop() -> None:
    """End what this process of Python has running; what it is asked for later ends at once."""
    _stopping.set()
    for runner in list(_all):
        runner.process.kill()


atexit.register(stop)


def start() -> None:
    """Allow work again after :func:`stop`."""
    _stopping.clear()


def _one(campaign: str, settings: Settings) -> Row:
    name = "lipoid"
    attempts = 0
    while True:
        attempts += 1
        try:
            runner = _runner(settings.memory_bytes)
            name = f"{socket.gethostname()}:{runner.process.pid}"
            row = runner.ask(campaign, settings.options, settings.time_limit_s)
            if row.get("failure") in ("memory-limit", "internal-error"):
                runner.kill()  # what follows gets a process that nothing has happened to
        except Late:
            reason = f"took longer than the limit of {settings.time_limit_s:g} s"
            row = {"status": "failed", "failure": "time-limit", "reason": reason}
        except Died as death:
            row = {"status": "failed", "failure": "died", "reason": str(death)}
        row = {"version": lipoid.__version__, "commit": lipoid._core.commit, **row}
        row["attempts"] = attempts
        row["worker"] = name
        again = row.get("failure") in ("time-limit", "memory-limit", "died")
        if not again or attempts > settings.retries or _stopping.is_set():
            return row


def identify_batch(campaigns: list[str], settings: Settings) -> list[Row]:
    """Return one row for each campaign, in their order; none of those that a stop left out."""
    rows = []
    for campaign in campaigns:
        row = _one(campaign, settings)
        if _stopping.is_set():
            break
        row["campaign"] = campaign
        now = datetime.datetime.now(datetime.timezone.utc)
        row["finished"] = now.isoformat(timespec="milliseconds")
        rows.append(row)
    return rows
