"""The command ``lipoid-fleet``: parses, calls, prints."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sqlite3
import sys
import time
from typing import Any, NoReturn

import lipoid
from lipoid.errors import LoadError, OptionError
from lipoid.fleet import cluster, options
from lipoid.fleet.driver import Counts, Progress, Run, Signals, duration, options_text
from lipoid.fleet.errors import BAD_INPUT, DONE, INCOMPLETE, USAGE, Stopped, UsageError, say
from lipoid.fleet.files import STANDARD_OUTPUT, check_writable, write_text
from lipoid.fleet.results import Results
from lipoid.fleet.sources import find, paths
from lipoid.fleet.worker import Settings

PROG = "lipoid-fleet"
# Python with NumPy and pandas alone needs most of it.
LEAST_MEMORY_BYTES = 300_000_000
MOST_SHOWN = 10

WHAT = """Identifies every cell of a fleet: all campaigns of a folder, a pattern or a table go to
the cores of this machine or to a cluster, and each gets its row in one SQLite file, also one that
fails. Done again, it goes on: what is there with the same files and options is kept.
"lipoid-fleet report" shows the spread of the parameters, outliers and drift."""
EXAMPLE = """example: lipoid-fleet campaigns/ -o results.sqlite --method staged;
then: lipoid-fleet report results.sqlite -o report.html"""


def _parser() -> argparse.ArgumentParser:
    made = options.parser(PROG, WHAT, EXAMPLE)
    made.add_argument(
        "sources",
        metavar="SOURCE",
        nargs="+",
        help="a folder, whose campaign.toml files count, also those further below; a pattern of "
        "campaigns, folders or tables, as 'cells/*/campaign.toml'; a campaign file; a table (.csv, "
        ".tsv, .parquet) with a column campaign, whose other columns (batch, age, ...) are kept; a "
        "database, with --query",
    )
    made.add_argument("--version", action="version", version=f"{PROG} {lipoid.__version__}")
    made.add_argument(
        "-o",
        "--output",
        metavar="SQLITE",
        required=True,
        help="the file of results; it is made "
        "where it is missing, and gone on with where it is there",
    )
    made.add_argument(
        "--query",
        metavar="SQL",
        default="",
        help="the SELECT that gives the table, where SOURCE "
        "is a database: a file (.db, .sqlite) or an SQLAlchemy URL as postgresql://server/lab",
    )
    made.add_argument(
        "--parquet",
        metavar="FILE",
        default="",
        help="write all results also as Parquet, one row per campaign with a column per parameter",
    )
    made.add_argument(
        "--summary", metavar="FILE", default="", help="write what became of the run as JSON"
    )
    who = made.add_mutually_exclusive_group()
    who.add_argument(
        "--workers",
        metavar="VALUE",
        type=int,
        default=0,
        help="campaigns that are identified at "
        "a time on this machine; 0: as many as it has cores (default 0)",
    )
    who.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        default="",
        help="the scheduler of a dask cluster that "
        "runs, as tcp://host:8786; it sees files under the same paths",
    )
    who.add_argument(
        "--slurm",
        metavar="FILE",
        default="",
        help="have Slurm start the workers: a TOML file "
        "with jobs, their number, and the arguments of dask_jobqueue.SLURMCluster",
    )
    made.add_argument(
        "--time-limit-s",
        metavar="VALUE",
        type=float,
        default=0.0,
        help="wall time allowed to a campaign, s; 0: no limit (default 0)",
    )
    made.add_argument(
        "--memory-limit",
        metavar="SIZE",
        default="",
        help="memory allowed to the process that "
        "identifies, as 2GB or 500MB; at least 300MB (default no limit)",
    )
    made.add_argument(
        "--retries",
        metavar="VALUE",
        type=int,
        default=1,
        help="how often a campaign is tried "
        "again that crashed or passed a limit, before its row says so; 0 .. 1000 (default 1)",
    )
    made.add_argument(
        "--replace",
        action="store_true",
        default=False,
        help="do every campaign again where the results that are there are of other options",
    )
    made.add_argument(
        "--quiet",
        action="store_true",
        default=False,
        help="no messages and no progress, only errors",
    )
    options.add(made)
    return made


def _memory_bytes(text: str) -> int:
    if not text:
        return 0
    from dask.utils import parse_bytes

    try:
        size = parse_bytes(text)
    except ValueError:
        raise UsageError(f"--memory-limit: expected a size as 2GB, found {text!r}") from None
    if size < LEAST_MEMORY_BYTES:
        raise UsageError(f"--memory-limit: expected at least 300MB, found {text!r}")
    return int(size)


def _settings(given: argparse.Namespace) -> Settings:
    if not 0.0 <= given.time_limit_s < 1e9:
        raise UsageError(f"--time-limit-s: expected 0 .. 1e9, found {given.time_limit_s:g}")
    if not 0 <= given.retries <= 1000:
        raise UsageError(f"--retries: expected 0 .. 1000, found {given.retries}")
    if given.scheduler:
        cluster.check(given.scheduler)
    if not 0 <= given.workers <= 4096:
        raise UsageError(f"--workers: expected 0 .. 4096, found {given.workers}")
    return Settings(
        options.keywords(given),
        given.time_limit_s,
        _memory_bytes(given.memory_limit),
        given.retries,
    )


def _check_outputs(given: argparse.Namespace) -> None:
    """No output may be one of the inputs, or another output."""
    inputs = [one for source in given.sources for one in paths(source)]
    inputs += [given.slurm, *options.files(vars(given)).values()]
    seen = {os.path.realpath(one): one for one in inputs if one and os.path.isfile(one)}
    for output in (given.output, given.parquet, given.summary):
        if not output or output in STANDARD_OUTPUT:
            continue
        if other := seen.get(os.path.realpath(output)):
            raise UsageError(f"{output} would overwrite {other}")
        seen[os.path.realpath(output)] = output
    if not given.output or given.output == ":memory:":
        raise UsageError(f"-o: expected a file for the results, found {given.output!r}")
    # Logs and campaigns are inputs, too: only what this command itself wrote is replaced.
    if given.summary and given.summary not in STANDARD_OUTPUT:
        check_writable(given.summary, _is_summary)
    if given.parquet:
        check_writable(given.parquet, lambda begin: begin.startswith(b"PAR1"))


def _is_summary(begin: bytes) -> bool:
    try:
        told = json.loads(begin)
    except ValueError:
        return False
    return isinstance(told, dict) and told.get("command") == PROG


def _sentence(counts: Counts, output: str) -> str:
    text = f"{counts.campaigns} campaigns: {counts.done} done"
    if counts.not_converged:
        text += f" ({counts.not_converged} did not converge)"
    if counts.poor:
        text += f" ({counts.poor} describe their logs poorly)"
    if counts.kept:
        text += f", {counts.kept} kept from before"
        if counts.kept_unusable:
            text += f" ({counts.kept_unusable} not usable)"
    if counts.failed:
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(counts.failures.items()))
        text += f", {counts.failed} failed ({kinds})"
    if left := counts.campaigns - counts.kept - counts.written:
        text += f", {left} left"
    return f"{text}. Results: {output}"


def _write_summary(given: argparse.Namespace, code: int, **said: Any) -> None:
    """Say what became of the run, also where it ended early: a file of an earlier one would lie."""
    if given.summary:
        told = {"command": PROG, "exit_code": code, **said}
        write_text(given.summary, json.dumps(told, indent=2) + "\n")


def _of(counts: Counts, began_s: float) -> dict[str, Any]:
    wall_s = time.monotonic() - began_s
    return {**vars(counts), "written": counts.written, "wall_s": wall_s}


def _pace(counts: Counts, wall_s: float) -> str:
    if not counts.written and counts.kept == counts.campaigns:
        return f"{duration(wall_s)}; nothing was left to do"
    rate = counts.written / wall_s if wall_s > 0.0 else 0.0
    return f"{duration(wall_s)}, {rate:.3g} campaigns per second"


def _tell_unreadable(folders: list[str]) -> None:
    """Say which folders may hold campaigns that this run does not see."""
    if not folders:
        return
    counted = "1 folder" if len(folders) == 1 else f"{len(folders)} folders"
    say(f"{PROG}: {counted} cannot be read; campaigns in there are left out:")
    for one in folders[:MOST_SHOWN]:
        say(f"  {one}")
    if len(folders) > MOST_SHOWN:
        say(f"  and {len(folders) - MOST_SHOWN} more")


def _run(given: argparse.Namespace) -> int:
    _check_outputs(given)
    try:
        return _identify(given, _settings(given))
    except (LoadError, UsageError, OptionError) as error:
        bad_input = isinstance(error, LoadError)
        kind = "bad-input" if bad_input else "usage"
        told = {"kind": kind, "message": str(error)}
        _write_summary(given, BAD_INPUT if bad_input else USAGE, error=told)
        raise


def _identify(given: argparse.Namespace, settings: Settings) -> int:
    if given.parquet:
        from lipoid.fleet import parquet

        parquet.check()
    unreadable: list[str] = []
    sources = find(given.sources, given.query, unreadable)
    if not given.quiet:
        _tell_unreadable(unreadable)
    progress = Progress(len(sources), not given.quiet)
    began_s = time.monotonic()
    ended = ""
    try:
        with (
            Results(given.output, options_text(settings.options), replace=given.replace) as results,
            Signals() as signals,
        ):
            if given.scheduler:
                made = cluster.at(given.scheduler)
            elif given.slurm:
                made = cluster.slurm(given.slurm)
            else:
                made = cluster.here(given.workers or cluster.cores())
            with made as client:
                run = Run(client, results, sources, settings, progress)
                run.counts.unreadable_folders = len(unreadable)
                try:
                    run.go(signals)
                except Stopped as why:
                    ended = str(why)
                finally:
                    progress.clear()
                    run.cancel()
    except sqlite3.Error as error:
        raise UsageError(f"{given.output}: cannot be written: {error}") from None
    except KeyboardInterrupt:
        if not given.quiet:
            say(f"{_sentence(run.counts, given.output)}")
            say("Stopped; the same command goes on from here.")
        _write_summary(given, 128 + signals.got, **_of(run.counts, began_s))
        _end_by(signals.got)
    counts = run.counts
    unusable = counts.failed + counts.not_converged + counts.poor + counts.kept_unusable
    code = INCOMPLETE if ended or unusable else DONE
    said = _of(counts, began_s)
    _write_summary(given, code, **said)
    if given.parquet:
        parquet.write(given.output, given.parquet)
    if ended:
        say(f"{PROG}: error: {ended}; the same command goes on")
    if not given.quiet:
        say(_sentence(counts, given.output))
        say(_pace(counts, said["wall_s"]))
    return code


def _end_by(number: int) -> NoReturn:
    """End by the signal that stopped the run, so that whoever started it sees that."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
    raise SystemExit(128 + number)


def _report(words: list[str]) -> int:
    from lipoid.fleet import report

    return report.command(words)


def _open_standard_streams() -> None:
    """Lead to nowhere what a daemon has closed: the next file that is opened would be it."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
    sys.stdout = sys.stdout or open(1, "w", closefd=False)  # noqa: SIM115 (as long as the program)
    sys.stderr = sys.stderr or open(2, "w", closefd=False)  # noqa: SIM115


def main(words: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    given = sys.argv[1:] if words is None else words
    _open_standard_streams()
    # The processes of the cluster take no modules from the folder in which one happens to be.
    os.environ.setdefault("PYTHONSAFEPATH", "1")
    try:
        if given[:1] == ["report"]:
            return _report(given[1:])
        return _run(_parser().parse_args(given))
    except LoadError as error:
        say(str(error))
        return BAD_INPUT
    except (UsageError, OptionError) as error:
        say(f"{PROG}: error: {error}")
        return USAGE


if __name__ == "__main__":
    sys.exit(main())
