"""The file of results: SQLite, one row for each campaign (docs/fleet.md says what every column is).

A row is committed as soon as it is there, and the disk has it then. Others may read while it grows.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import sqlite3
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any

import lipoid
from lipoid.fleet.errors import UsageError
from lipoid.fleet.sources import Source, metadata_text

# How long a person who looks, or changes, may hold the file.
LOCKED_S = 60.0

APPLICATION = 0x6C69706F  # "lipo", in the header of the file
SCHEMA = 1
SCHEMA_NAME = "lipoid.fleet/1"

TABLES = """
CREATE TABLE fleet (
  name TEXT PRIMARY KEY,
  value TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE campaigns (
  id INTEGER PRIMARY KEY,
  campaign TEXT NOT NULL UNIQUE,
  status TEXT NOT NULL CHECK (status IN ('done', 'failed')),
  failure TEXT,
  reason TEXT,
  converged INTEGER,
  usable INTEGER,
  grade TEXT,
  mean_error_percent REAL,
  rmse_V REAL,
  cell TEXT,
  summary TEXT,
  options TEXT NOT NULL,
  inputs TEXT,
  version TEXT NOT NULL,
  "commit" TEXT NOT NULL,
  result_sha256 TEXT,
  attempts INTEGER NOT NULL,
  wall_s REAL,
  cpu_s REAL,
  peak_memory_bytes INTEGER,
  worker TEXT,
  finished TEXT NOT NULL,
  metadata TEXT NOT NULL
);
CREATE TABLE parameters (
  id INTEGER NOT NULL REFERENCES campaigns (id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  unit TEXT NOT NULL,
  estimate REAL,
  standard_error REAL,
  low_95 REAL,
  high_95 REAL,
  verdict TEXT,
  PRIMARY KEY (id, name)
) WITHOUT ROWID;
"""

# fmt: off
COLUMNS = (
    "campaign", "status", "failure", "reason", "converged", "usable", "grade",
    "mean_error_percent", "rmse_V", "cell", "summary", "options", "inputs", "version", "commit",
    "result_sha256", "attempts", "wall_s", "cpu_s", "peak_memory_bytes", "worker", "finished",
    "metadata",
)
# fmt: on
NAMES = ", ".join(f'"{name}"' for name in COLUMNS)
CHANGES = ", ".join(f'"{name}" = excluded."{name}"' for name in COLUMNS[1:-1])
# A folder says nothing of a campaign; what a table once said stays.
CHANGES += (
    ", metadata = CASE WHEN excluded.metadata = '{}' THEN campaigns.metadata"
    " ELSE excluded.metadata END"
)
PUT_CAMPAIGN = (
    f"INSERT INTO campaigns ({NAMES}) VALUES ({', '.join('?' * len(COLUMNS))}) "
    f"ON CONFLICT (campaign) DO UPDATE SET {CHANGES} RETURNING id"
)
PUT_PARAMETER = "INSERT INTO parameters VALUES (?, ?, ?, ?, ?, ?, ?, ?)"

Row = dict[str, Any]


class Results:
    """The results of one set of options; no other run may write to the file meanwhile.

    Parameters
    ----------
    file : path
        Made where it is missing; where it is there, this goes on with it.
    options : str
        The options of the identification, as JSON.
    replace : bool
        Go on with other options than those of the results that are there: every campaign is done
        again.
    """

    def __init__(
        self, file: str | os.PathLike[str], options: str = "{}", *, replace: bool = False
    ) -> None:
        self.file = os.fspath(file)
        self._lock = self._take_lock()
        try:
            self._open(options, replace)
        except sqlite3.Error as error:
            self._unlock()
            raise UsageError(f"{self.file}: cannot be used for results: {error}") from None
        except BaseException:
            self._unlock()
            raise

    def _take_lock(self) -> int:
        name = f"{os.path.realpath(self.file)}.lock"  # one, whatever leads to the file
        try:
            lock = os.open(name, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o600)
        except OSError as error:
            raise UsageError(f"{self.file}: cannot be written: {error.strerror}") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # One that was removed between opening and locking keeps nobody out.
            if os.fstat(lock).st_ino != os.stat(name).st_ino:
                raise FileNotFoundError(name)
            if os.fstat(lock).st_size:
                raise FileExistsError(name)
        except FileExistsError:
            os.close(lock)
            raise UsageError(
                f"{self.file}: {name} is not the lock of lipoid-fleet, which is empty; give "
                "another -o, or move that file"
            ) from None
        except OSError:
            os.close(lock)
            raise UsageError(f"{self.file}: another lipoid-fleet is writing to it") from None
        return lock

    def _unlock(self) -> None:
        Path(f"{os.path.realpath(self.file)}.lock").unlink(missing_ok=True)
        os.close(self._lock)

    def _open(self, options: str, replace: bool) -> None:
        if os.path.isdir(self.file):
            raise UsageError(f"{self.file}: expected a file for the results, found a folder")
        made = not os.path.exists(self.file) or os.path.getsize(self.file) == 0
        self.database = sqlite3.connect(self.file, timeout=LOCKED_S, isolation_level=None)
        try:
            self._prepare(made, options, replace)
        except BaseException:
            self.database.close()
            raise

    def _prepare(self, made: bool, options: str, replace: bool) -> None:
        application = self.database.execute("PRAGMA application_id").fetchone()[0]
        if not made and application != APPLICATION:
            raise UsageError(f"{self.file}: there is a database that lipoid-fleet did not make")
        self.database.execute("PRAGMA journal_mode = WAL")
        self.database.execute("PRAGMA synchronous = FULL")
        self.database.execute("PRAGMA foreign_keys = ON")
        if made:
            self.database.executescript(
                f"BEGIN; {TABLES} PRAGMA application_id = {APPLICATION}; "
                f"PRAGMA user_version = {SCHEMA}; COMMIT;"
            )
            self._set({"schema": SCHEMA_NAME, "options": options, "version": lipoid.__version__})
        schema = self.database.execute("PRAGMA user_version").fetchone()[0]
        if schema != SCHEMA:
            raise UsageError(
                f"{self.file}: expected results of the schema {SCHEMA}, found {schema}: "
                "another lipoid made them"
            )
        before = self._get("options")
        if before != options:
            if not replace:
                raise UsageError(
                    f"{self.file} holds results of the options {before}, not of {options}: give "
                    "another -o, or --replace to do every campaign again"
                )
            self._set({"options": options})
        self.options = options
        self.replace = replace

    def _set(self, values: dict[str, str]) -> None:
        self.database.executemany("INSERT OR REPLACE INTO fleet VALUES (?, ?)", values.items())

    def _get(self, name: str) -> str:
        row = self.database.execute("SELECT value FROM fleet WHERE name = ?", (name,)).fetchone()
        return str(row[0]) if row else ""

    def __enter__(self) -> Results:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # The last one to close folds the write-ahead log into the file; a reader cannot.
        with contextlib.suppress(sqlite3.Error):
            self.database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        self.database.close()
        self._unlock()

    def done(self, campaign: str) -> tuple[list[dict[str, Any]], bool] | None:
        """Return the inputs of a campaign that is done with these options, and if it is usable.

        Raises
        ------
        UsageError
            Where it is done with other options, as a stopped run with ``--replace`` leaves it, and
            may not be replaced.
        """
        row = self.database.execute(
            "SELECT inputs, usable, options FROM campaigns WHERE campaign = ? AND status = 'done'",
            (campaign,),
        ).fetchone()
        if not row:
            return None
        if row[2] == self.options:
            return json.loads(row[0]), bool(row[1])
        if not self.replace:
            raise UsageError(
                f"{self.file} holds results of the options {row[2]}, too, which a run with "
                f"--replace has left ({campaign}): give another -o, or --replace to go on with "
                "that run"
            )
        return None

    def renew(self, source: Source, inputs: list[dict[str, Any]]) -> None:
        """Keep a result whose files have the same bytes as before, and what its table says now."""
        self.database.execute(
            "UPDATE campaigns SET inputs = ? WHERE campaign = ? AND inputs <> ?",
            (text := json.dumps(inputs), source.campaign, text),
        )
        if source.metadata:
            self.database.execute(
                "UPDATE campaigns SET metadata = ? WHERE campaign = ? AND metadata <> ?",
                (text := metadata_text(source.metadata), source.campaign, text),
            )

    def _is_out_of_reach(self, campaign: str) -> bool:
        """Return whether a campaign is done, and a file that it was done from is not there now."""
        row = self.database.execute(
            "SELECT inputs FROM campaigns WHERE campaign = ? AND status = 'done'", (campaign,)
        ).fetchone()
        return bool(row) and not all(os.path.exists(one["file"]) for one in json.loads(row[0]))

    def put(self, rows: Iterable[Row]) -> None:
        """Write rows, all of them at once; a row of the same campaign is replaced.

        But for one that is done and fails now because its files are out of reach: that says
        nothing against what they held.
        """
        self.database.execute("BEGIN IMMEDIATE")
        try:
            for row in rows:
                if row["status"] == "failed" and self._is_out_of_reach(row["campaign"]):
                    continue
                values = [row.get(name) for name in COLUMNS]
                (number,) = self.database.execute(PUT_CAMPAIGN, values).fetchone()
                self.database.execute("DELETE FROM parameters WHERE id = ?", (number,))
                self.database.executemany(
                    PUT_PARAMETER, [(number, *one) for one in row.get("parameters", [])]
                )
            self.database.execute("COMMIT")
        except BaseException:
            if self.database.in_transaction:
                self.database.execute("ROLLBACK")
            raise


def open_for_reading(file: str | os.PathLike[str]) -> sqlite3.Connection:
    """Open results that are there, also while a run writes to them.

    Raises
    ------
    UsageError
        Where the file is not one of lipoid-fleet.
    """
    path = Path(file)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: error: expected results of lipoid-fleet, found no file")
    # Where nobody may write beside the file, SQLite cannot read it as one that others write to.
    # A write-ahead log beside it holds rows that are not in the file yet.
    ways = ("mode=ro",) if Path(f"{path}-wal").exists() else ("mode=ro", "immutable=1")
    for way in ways:
        database = sqlite3.connect(f"{path.absolute().as_uri()}?{way}", uri=True)
        with contextlib.suppress(sqlite3.DatabaseError):
            if database.execute("PRAGMA application_id").fetchone()[0] == APPLICATION:
                return database
        database.close()
    raise ValueError(f"{path}: error: expected results of lipoid-fleet, found another file")
