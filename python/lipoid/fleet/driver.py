"""The run: campaigns go to the workers of dask in batches, rows come back and are written."""

from __future__ import annotations

import collections
import concurrent.futures
import contextlib
import hashlib
import json
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

import lipoid
from lipoid.fleet.errors import Stopped, say
from lipoid.fleet.options import files
from lipoid.fleet.results import Results, Row
from lipoid.fleet.sources import Source, metadata_text
from lipoid.fleet.worker import Settings, identify_batch

# A task of dask lasts about so long: its own cost of some milliseconds vanishes beside it, and what
# a dying worker takes along is little.
BATCH_S = 1.0
LARGEST_BATCH = 200
# Tasks for each thread of a worker: one at work, one that waits.
AHEAD = 2
LOOK_S = 0.2


@dataclass
class Counts:
    """What became of the campaigns of a run."""

    campaigns: int = 0
    kept: int = 0  # done before, with the same files and options
    kept_unusable: int = 0  # of them; done again they would not converge or be poor again
    done: int = 0
    failed: int = 0
    not_converged: int = 0
    poor: int = 0  # converged, and yet the cell does not describe its logs
    retries: int = 0
    unreadable_folders: int = 0  # below the sources; what campaigns they hold is not known
    failures: dict[str, int] = field(default_factory=dict)

    def add(self, row: Row) -> None:
        """Count one that came back."""
        self.retries += row["attempts"] - 1
        if row["status"] == "failed":
            self.failed += 1
            kind = row["failure"]
            self.failures[kind] = self.failures.get(kind, 0) + 1
            return
        self.done += 1
        self.not_converged += not row["converged"]
        self.poor += row["converged"] and not row["usable"]

    @property
    def written(self) -> int:
        """Campaigns that this run has written."""
        return self.done + self.failed


def sha256_of_file(file: str) -> str:
    """Return the SHA-256 of the bytes of a file."""
    digest = hashlib.sha256()
    with open(file, "rb") as bytes_of:
        while some := bytes_of.read(1 << 20):
            digest.update(some)
    return digest.hexdigest()


def still_the_same(inputs: list[dict[str, Any]]) -> list[dict[str, Any]] | None:
    """Return the inputs as they are now where no byte of them has changed, else None.

    A file of the same length and time of change is taken to be the same; where the time differs,
    the bytes decide.
    """
    now = []
    for one in inputs:
        try:
            status = os.stat(one["file"])
            if status.st_size != one["bytes"]:
                return None
            if status.st_mtime_ns != one["modified_ns"]:
                if sha256_of_file(one["file"]) != one["sha256"]:
                    return None
                one = {**one, "modified_ns": status.st_mtime_ns}
        except OSError:
            return None
        now.append(one)
    return now


class Signals:
    """Ctrl-C and SIGTERM become a flag while the run goes on; what was set before comes back."""

    def __init__(self) -> None:
        self.got = 0

    def _note(self, number: int, _: FrameType | None) -> None:
        self.got = number

    def __enter__(self) -> Signals:
        self._before = {}
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)


class Progress:
    """One line on a terminal: how far, how fast, how long still."""

    # The rate is that of the last minute: a fleet may begin with the small campaigns.
    WINDOW_S = 60.0

    def __init__(self, total: int, shown: bool) -> None:
        self.total = total
        self.shown = shown and sys.stderr.isatty()
        self.last_s = 0.0
        self.history: collections.deque[tuple[float, int]] = collections.deque()

    def tell(self, counts: Counts) -> None:
        """Draw, at most a few times a second."""
        now_s = time.monotonic()
        if not self.shown or now_s - self.last_s < LOOK_S:
            return
        self.last_s = now_s
        self.history.append((now_s, counts.written))
        while now_s - self.history[0][0] > self.WINDOW_S:
            self.history.popleft()
        began_s, had = self.history[0]
        per_s = (counts.written - had) / max(now_s - began_s, 1e-9)
        behind = counts.kept + counts.written
        text = f"{behind} of {self.total} campaigns"
        if counts.failed:
            text += f", {counts.failed} failed"
        if per_s > 0.0:
            text += f", {per_s:.3g} per second, {duration((self.total - behind) / per_s)} left"
        say(f"\r\x1b[K{text[:100]}", end="")

    def clear(self) -> None:
        """Leave nothing on the screen."""
        if self.shown:
            say("\r\x1b[K", end="")


def duration(time_s: float) -> str:
    """Return a time for a person: 12 s, 3 min, 2.5 h, 4.1 days."""
    for limit_s, unit_s, form in ((99.5, 1.0, "{:.0f} s"), (5970.0, 60.0, "{:.0f} min")):
        if time_s < limit_s:
            return form.format(time_s / unit_s)
    hours = time_s / 3600.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"


class Run:
    """Every campaign of the sources gets its row.

    Parameters
    ----------
    client : dask.distributed.Client
        Whose workers identify.
    results : Results
        Where rows go.
    sources : list of Source
        What is to be done.
    settings : Settings
        How.
    progress : Progress
        Who is told.
    """

    def __init__(
        self,
        client: Any,
        results: Results,
        sources: list[Source],
        settings: Settings,
        progress: Progress,
    ) -> None:
        self.client = client
        self.results = results
        self.settings = settings
        self.progress = progress
        self.counts = Counts(campaigns=len(sources))
        self.metadata = {one.campaign: one.metadata for one in sources}
        self.left = self._not_done(sources)
        self.again: collections.deque[list[str]] = collections.deque()
        self.deaths: collections.Counter[str] = collections.Counter()
        self.running: dict[str, tuple[Any, list[str]]] = {}
        self.finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self.one_s = 0.0  # wall time of a campaign, of late
        self.threads = 0
        self.threads_at_s = -1e9

    def _not_done(self, sources: list[Source]) -> Iterator[str]:
        for source in sources:
            inputs, usable = self.results.done(source.campaign) or (None, False)
            same = None if inputs is None else still_the_same(inputs)
            if same is None:
                yield source.campaign
                continue
            self.results.renew(source, same)
            self.counts.kept += 1
            self.counts.kept_unusable += not usable
            self.progress.tell(self.counts)

    def _next_batch(self) -> list[str]:
        if self.again:
            return self.again.popleft()
        size = 1
        if self.one_s > 0.0:
            size = min(max(round(BATCH_S / self.one_s), 1), LARGEST_BATCH)
        batch = []
        for campaign in self.left:
            batch.append(campaign)
            if len(batch) == size:
                break
        return batch

    def _places(self) -> int:
        """How many tasks may be out; workers come and go."""
        now_s = time.monotonic()
        if now_s - self.threads_at_s > 2.0:
            with contextlib.suppress(OSError):  # the scheduler is gone: _look_after() says so
                self.threads = sum(self.client.nthreads().values())
            self.threads_at_s = now_s
        return AHEAD * max(self.threads, 1)

    def _submit(self, batch: list[str]) -> None:
        future = self.client.submit(identify_batch, batch, self.settings, pure=False)
        self.running[future.key] = (future, batch)
        future.add_done_callback(self.finished.put)

    def _write(self, rows: list[Row]) -> None:
        for row in rows:
            campaign = row["campaign"]
            row["attempts"] += self.deaths.pop(campaign, 0)
            row["options"] = self.results.options
            row["metadata"] = metadata_text(self.metadata[campaign])
            wall_s = row.get("wall_s") or BATCH_S
            self.one_s = wall_s if self.one_s == 0.0 else 0.9 * self.one_s + 0.1 * wall_s
        self.results.put(rows)
        for row in rows:
            self.counts.add(row)

    def _take(self, future: Any) -> None:
        _, batch = self.running.pop(future.key)
        status = future.status
        try:
            rows = future.result() if status == "finished" else None
            error = future.exception() if status == "error" else None
        except (OSError, concurrent.futures.CancelledError):  # asked when the scheduler died
            rows = error = None
        if rows is not None:
            self._write(rows)
        elif error is not None:
            self._take_death(batch, error)
        else:  # lost with the scheduler, or cancelled by it
            self.again.append(batch)
        future.release()

    def _take_death(self, batch: list[str], error: BaseException) -> None:
        """Try each campaign of a batch whose workers died alone; then it fails with the reason."""
        for campaign in batch:
            self.deaths[campaign] += 1
            if len(batch) > 1 or self.deaths[campaign] <= self.settings.retries:
                self.again.append([campaign])
                continue
            row: Row = {"campaign": campaign, "status": "failed", "failure": "worker-died"}
            row |= {"reason": f"the workers of dask that identified it died: {error}"}
            row |= {"version": lipoid.__version__, "commit": lipoid._core.commit, "attempts": 0}
            row["finished"] = time.strftime("%Y-%m-%dT%H:%M:%S+00:00", time.gmtime())
            self._write([row])

    def _look_after(self, signals: Signals) -> None:
        self.progress.tell(self.counts)
        if signals.got:
            raise KeyboardInterrupt
        if self.client.status != "running":
            raise Stopped(f"the scheduler at {self.client.scheduler.address} is gone")

    def go(self, signals: Signals) -> Counts:
        """Do it.

        Raises
        ------
        Stopped
            Where the scheduler is gone.
        KeyboardInterrupt
            At a signal; what was written stays.
        """
        more = True
        while True:
            while more and len(self.running) < self._places():
                self._look_after(signals)
                if batch := self._next_batch():
                    self._submit(batch)
                else:
                    more = False
            if not self.running and not self.again:
                return self.counts
            try:
                future = self.finished.get(timeout=LOOK_S)
            except queue.Empty:
                self._look_after(signals)
                continue
            self._look_after(signals)
            self._take(future)
            more = more or bool(self.again)

    def cancel(self) -> None:
        """Take back what is out."""
        futures = [future for future, _ in self.running.values()]
        if futures and self.client.status == "running":
            with contextlib.suppress(OSError):  # the scheduler is gone, and what was out with it
                self.client.cancel(futures, force=True)
        self.running.clear()


def options_text(options: dict[str, Any]) -> str:
    """Return options as the text that tells results of other options apart.

    A file among them counts by its bytes, too.
    """
    digests = {f"{name}_sha256": sha256_of_file(file) for name, file in files(options).items()}
    return json.dumps(options | digests, sort_keys=True, allow_nan=False)
