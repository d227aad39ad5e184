"""Who does the work: this machine, a scheduler that runs somewhere, or the jobs of Slurm."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lipoid.errors import LoadError
from lipoid.fleet import worker
from lipoid.fleet.errors import UsageError

# A scheduler that is there answers at once; one behind a slow network within this.
ANSWER_S = 20.0


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        message = f"lipoid-fleet needs dask.distributed: pip install 'lipoid[fleet]' ({error})"
        raise UsageError(message) from None
    # What matters of its messages is in the rows; the rest tells of workers that come and go.
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("distributed", "tornado"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    return distributed


# What dask does for its own pages, which nobody sees here, would take 4 % of a core as long as the
# cluster is up.
PLAIN: dict[str, Any] = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.scheduler.work-stealing": False,
}


@contextlib.contextmanager
def here(workers: int) -> Iterator[Any]:
    """Start a cluster within this process, and yield its client.

    Its workers are threads, each with a process of lipoid.fleet.runner that identifies. Nothing
    listens on any port: on a machine of many, nobody else can hand in work.
    """
    distributed = _distributed()
    import dask

    worker.start()
    loopback = "127.0.0.1:0"
    with dask.config.set(PLAIN):
        cluster = distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=workers,
            processes=False,
            protocol="inproc://",
            dashboard_address=loopback,
            worker_dashboard_address=loopback,
            memory_limit=0,
        )

        async def listen_no_more() -> None:
            for one in (cluster.scheduler, *cluster.workers.values()):
                one.http_server.stop()

        try:
            cluster.sync(listen_no_more)  # dask's pages about itself cannot be left out otherwise
            with distributed.Client(cluster) as client:
                try:
                    yield client
                finally:
                    worker.stop()
        finally:
            cluster.close()


def check(address: str) -> None:
    """Refuse what is no address before anything is waited for: dask itself waits half a minute."""
    _distributed()
    from distributed.comm.addressing import parse_address, parse_host_port

    try:
        scheme, place = parse_address(address)
        if scheme in ("tcp", "tls"):
            parse_host_port(place)
    except ValueError as error:
        raise UsageError(f"--scheduler: expected an address as tcp://HOST:8786 ({error})") from None


@contextlib.contextmanager
def at(address: str) -> Iterator[Any]:
    """Yield the client of a scheduler that runs."""
    distributed = _distributed()
    try:
        client = distributed.Client(address, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(f"--scheduler {address}: no scheduler answers ({error})") from None
    with client:
        yield client


def _read_toml(file: str) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(Path(file).read_text(encoding="utf-8"))
    except OSError as error:
        message = f"expected a readable file, found none ({error.strerror})"
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        message = f"not TOML: {error}"
    raise LoadError(f"{file}: error: {message}", [(file, 0, 0, message)])


@contextlib.contextmanager
def slurm(file: str) -> Iterator[Any]:
    """Have Slurm start the workers that a file describes, and yield their client."""
    described = _read_toml(file)
    distributed = _distributed()
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError as error:
        message = f"--slurm needs dask-jobqueue: pip install 'lipoid[fleet]' ({error})"
        raise UsageError(message) from None
    jobs = described.pop("jobs", None)
    if not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1:
        raise UsageError(f"{file}: expected jobs, a whole number from 1 on, found {jobs!r}")
    described.setdefault("python", sys.executable)
    described.setdefault("scheduler_options", {"dashboard": False})
    try:
        cluster = SLURMCluster(**described)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{file}: not what dask_jobqueue.SLURMCluster takes: {error}") from None
    try:
        try:
            cluster.scale(jobs=jobs)
        except (OSError, RuntimeError) as error:
            raise UsageError(f"{file}: Slurm did not take the jobs: {error}") from None
        with distributed.Client(cluster) as client:
            yield client
    finally:
        cluster.close()


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0))
