"""Campaigns of a folder, a glob, or a table (CSV, Parquet, the rows of an SQL query)."""

from __future__ import annotations

import collections
import csv
import datetime
import decimal
import glob
import json
import math
import os
import re
import sqlite3
from collections.abc import Hashable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from lipoid.errors import LoadError
from lipoid.fleet.errors import UsageError

CAMPAIGN_FILE = "campaign.toml"
DATABASES = (".db", ".sqlite", ".sqlite3")
TABLES = (".csv", ".tsv", ".parquet")
COLUMN = "campaign"
NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][+-]?[0-9]+)?")

Value = str | float | int | bool | None


class Source(NamedTuple):
    """One campaign: its file, and what its row of the table says beside (batch, age, ...)."""

    campaign: str
    metadata: dict[str, Value]


def find(
    given: Iterable[str], query: str = "", unreadable: list[str] | None = None
) -> list[Source]:
    """Return the campaigns of all sources, each once, in their order.

    Folders below a source that cannot be read are appended to `unreadable`, with the reason.

    Raises
    ------
    LoadError
        For a source that is missing or is not what it should be, with its place.
    UsageError
        For a query without a database, and the other way round.
    """
    several = list(given)
    if query and (len(several) != 1 or not is_database(several[0])):
        raise UsageError("--query needs one SOURCE that is a database: a file or an SQLAlchemy URL")
    found: dict[Hashable, Source] = {}
    for source in several:
        for one in _of_source(source, query, [] if unreadable is None else unreadable):
            if one.campaign != one.campaign.encode(errors="replace").decode():
                _fail(source, 0, f"expected paths in UTF-8, found {one.campaign!r}; rename it")
            before = found.setdefault(_identity_of_campaign(one.campaign), one)
            if before.metadata != one.metadata:
                _fail(source, 0, f"{one.campaign} was named before with other columns")
    return list(found.values())


def is_database(source: str) -> bool:
    """Whether a query, and no path, says where the campaigns are."""
    return "://" in source or source.lower().endswith(DATABASES)


def _fail(file: str, line: int, message: str) -> None:
    place = f"{file}:{line}:1" if line else file
    raise LoadError(f"{place}: error: {message}", [(file, line, 1 if line else 0, message)])


def paths(source: str) -> list[str]:
    """Return the files and folders that a source names: itself, or the matches of a pattern.

    Those that no link leads to come first.
    """
    if is_database(source) or os.path.lexists(source) or not glob.has_magic(source):
        return [source]
    matches = sorted(glob.glob(source, recursive=True))
    return sorted(matches, key=lambda one: os.path.realpath(one) != os.path.abspath(one))


def _of_source(source: str, query: str, unreadable: list[str]) -> Iterator[Source]:
    if is_database(source):
        folder = "." if "://" in source else os.path.dirname(source)
        yield from _of_table(source, _read_query(source, query), folder)
        return
    matches = paths(source)
    if not matches:
        _fail(source, 0, "expected campaigns, found no file or folder of this pattern")
    if matches == [source] and not os.path.exists(source):
        _fail(source, 0, "expected a folder, a campaign, a table or a pattern, found none")
    folders, tables, campaigns = [], [], []
    for one in matches:
        if os.path.isdir(one):
            folders.append(one)
        elif one.lower().endswith(TABLES):
            tables.append(one)
        else:
            campaigns.append(os.path.abspath(one))
    for campaign in [*campaigns, *_of_folders(folders, unreadable)]:
        yield Source(campaign, {})
    for table in tables:
        reads = _read_parquet if table.lower().endswith(".parquet") else _read_csv
        yield from _of_table(table, reads(table), os.path.dirname(table) or ".")


def _identity(folder: str) -> tuple[int, int]:
    status = os.stat(folder)
    return status.st_dev, status.st_ino


def _identity_of_campaign(campaign: str) -> Hashable:
    """Return what a campaign has in common with itself by another name of its folder."""
    folder, name = os.path.split(campaign)
    return (_identity(folder), name) if os.path.isdir(folder) else campaign


def _of_folders(tops: list[str], unreadable: list[str]) -> list[str]:
    """Return the campaigns of these folders and of all below, each folder once.

    Linked folders come last, so that a campaign has the name without a link where there is one.
    """

    def note(error: OSError) -> None:
        if error.filename in tops:
            _fail(error.filename, 0, f"expected a readable folder, found none ({error.strerror})")
        unreadable.append(f"{error.filename}: {error.strerror}")

    campaigns = []
    seen: set[tuple[int, int]] = set()  # a link may lead back to a folder that it is in
    lacking = set(tops)
    waiting = collections.deque((top, top) for top in tops)
    while waiting:
        top, begin = waiting.popleft()
        for path, folders, files in os.walk(begin, onerror=note):
            identity = _identity(path)
            if identity in seen:
                folders.clear()
                lacking.discard(top)
                continue
            seen.add(identity)
            folders.sort()
            below = [os.path.join(path, folder) for folder in folders]
            waiting.extend((top, one) for one in below if os.path.islink(one))
            if CAMPAIGN_FILE in files:
                lacking.discard(top)
                campaigns.append(os.path.abspath(os.path.join(path, CAMPAIGN_FILE)))
    for top in tops:
        if top in lacking or not campaigns:
            but = f"; {unreadable[0]}" if unreadable else ""
            found = f"found no {CAMPAIGN_FILE} in this folder or below{but}"
            _fail(top, 0, f"expected campaigns, {found}")
    return campaigns


Row = tuple[int, dict[str, Any]]  # line (0: the table has none) and values by column


def _of_table(source: str, rows: Iterable[Row], folder: str) -> Iterator[Source]:
    lines: dict[Hashable, int] = {}
    for line, row in _without_decimals(list(rows)):
        campaign = row.get(COLUMN)
        if not isinstance(campaign, str) or not campaign.strip():
            _fail(source, line, f"expected a path in the column {COLUMN}, found {campaign!r}")
        assert isinstance(campaign, str)
        if not campaign.isprintable():
            _fail(source, line, f"expected a path, found {campaign!r} with control characters")
        path = os.path.abspath(os.path.join(folder, campaign))
        if os.path.isdir(path):
            path = os.path.join(path, CAMPAIGN_FILE)
        identity = _identity_of_campaign(path)
        if identity in lines:
            _fail(source, line, f"{campaign} was named before, in row {lines[identity]}")
        lines[identity] = line or len(lines) + 1
        metadata = {key: _plain(value) for key, value in row.items() if key != COLUMN}
        yield Source(path, metadata)
    if not lines:
        _fail(source, 0, "expected campaigns, found a table without rows")


def _without_decimals(rows: list[Row]) -> list[Row]:
    """Make exact decimals of a database or of Parquet what they are as the fields of a CSV file."""
    columns = {
        key for _, row in rows for key, value in row.items() if isinstance(value, decimal.Decimal)
    }
    for key in columns:
        exact = [row.get(key) for _, row in rows]
        texts = [
            f"{one:f}" if isinstance(one, decimal.Decimal) and one.is_finite() else ""
            for one in exact
        ]
        for (_, row), one, value in zip(rows, exact, _values(texts), strict=True):
            if isinstance(one, decimal.Decimal):
                row[key] = value
    return rows


def _plain(value: Any) -> Value:
    """Make a value of a table one of JSON; what is no number is text, what is not there is null."""
    if hasattr(value, "item"):  # of NumPy
        value = value.item()
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, (datetime.date, datetime.datetime, datetime.time)):
        return None if str(value) == "NaT" else value.isoformat()
    return str(value)


def _check_columns(source: str, names: list[str], line: int) -> None:
    if COLUMN not in names:
        shown = ", ".join(names[:20]) or "none"
        _fail(source, line, f"expected a column {COLUMN} with paths, found the columns {shown}")
    if repeated := {name for name in names if names.count(name) > 1}:
        _fail(source, line, f"column {min(repeated)} is there more than once")


def _read_csv(file: str) -> Iterator[Row]:
    line = 1
    try:
        with open(file, encoding="utf-8-sig", newline="") as text:
            header = text.readline(1 << 20)
            delimiter = max(",;\t", key=header.count)
            text.seek(0)
            reader = csv.reader(text, delimiter=delimiter, strict=True)
            names = [name.strip() for name in next(reader, [])]
            _check_columns(file, names, 1)
            rows: list[tuple[int, list[str]]] = []
            for fields in reader:
                line = reader.line_num
                if len(fields) != len(names):
                    if not fields:
                        continue
                    _fail(file, line, f"expected {len(names)} fields, found {len(fields)}")
                rows.append((line, fields))
    except UnicodeDecodeError as error:
        _fail(
            file, line, f"expected text in UTF-8, found the byte 0x{error.object[error.start]:02x}"
        )
    except csv.Error as error:
        _fail(file, reader.line_num, str(error))
    except OSError as error:
        _fail(file, 0, f"expected a readable file, found none ({error.strerror})")
    columns = [_values([fields[k].strip() for _, fields in rows]) for k in range(len(names))]
    where = names.index(COLUMN)
    columns[where] = [fields[where].strip() for _, fields in rows]
    for k, (number, _) in enumerate(rows):
        yield number, {name: column[k] for name, column in zip(names, columns, strict=True)}


def as_number(text: str) -> int | float | None:
    """Return the number that a text is written as, or None where a number would lose part of it.

    "0012" and "1_1" are names. Readers of JSON keep every digit of whole numbers below 2**53.
    """
    if not NUMBER.fullmatch(text):
        return None
    number = float(text)
    if text.lstrip("-").isdecimal():
        return int(text) if abs(number) < 2**53 else None
    return number if math.isfinite(number) else None


def _values(column: list[str]) -> list[Value]:
    """Make a column numbers where every field that is not empty is one, so that none is mixed."""
    numbers = [as_number(field) for field in column]
    if any(field and number is None for field, number in zip(column, numbers, strict=True)):
        return [field or None for field in column]
    if any(isinstance(number, float) for number in numbers):
        return [None if number is None else float(number) for number in numbers]
    return list(numbers)


def _read_parquet(file: str) -> Iterator[Row]:
    try:
        from pyarrow import ArrowException, parquet
    except ImportError as error:
        raise UsageError(f"Parquet needs pyarrow: pip install 'lipoid[fleet]' ({error})") from None
    try:
        with parquet.ParquetFile(file) as table:
            _check_columns(file, table.schema_arrow.names, 0)
            for batch in table.iter_batches():
                for row in batch.to_pylist():
                    yield 0, row
    except (ArrowException, OSError) as error:
        _fail(file, 0, f"expected a readable Parquet file, found: {error}")


def _read_query(source: str, query: str) -> Iterator[Row]:
    if not query:
        raise UsageError(f"{source} is a database: --query says which rows, with a column {COLUMN}")
    try:
        import sqlalchemy
    except ImportError as error:
        message = f"a database needs sqlalchemy: pip install 'lipoid[fleet]' ({error})"
        raise UsageError(message) from None
    if "://" in source:
        engine, shown = _engine(source)
    else:
        if not os.path.exists(source):
            _fail(source, 0, "expected a readable file, found none (No such file or directory)")
        uri = Path(source).absolute().as_uri() + "?mode=ro"  # never made, never changed
        engine = sqlalchemy.create_engine(
            "sqlite://", creator=lambda: sqlite3.connect(uri, uri=True)
        )
        shown = source
    try:
        with engine.connect() as connection:
            result = connection.execute(sqlalchemy.text(query))
            if not result.returns_rows:
                raise UsageError("--query: expected a SELECT, found a statement without rows")
            _check_columns(shown, list(result.keys()), 0)
            for row in result.mappings():
                yield 0, dict(row)
    except sqlalchemy.exc.SQLAlchemyError as error:
        _fail(shown, 0, f"the query failed: {str(error).splitlines()[0]}")
    finally:
        engine.dispose()


def _engine(url: str) -> tuple[Any, str]:
    """Return the way to a database, and its address without a password."""
    import sqlalchemy

    try:
        shown = sqlalchemy.make_url(url).render_as_string(hide_password=True)
    except (sqlalchemy.exc.ArgumentError, ValueError):
        raise UsageError(
            "SOURCE: expected an SQLAlchemy URL such as postgresql+psycopg://USER@HOST/DATABASE; "
            "this one cannot be read as one"
        ) from None
    try:
        return sqlalchemy.create_engine(url), shown
    except sqlalchemy.exc.NoSuchModuleError as error:
        raise UsageError(f"{shown}: SQLAlchemy knows no such database ({error})") from None
    except ImportError as error:
        raise UsageError(
            f"{shown}: the driver of this database is not installed ({error}): pip install it, or "
            "name another one in the URL, as in postgresql+psycopg://"
        ) from None


def metadata_text(metadata: dict[str, Value]) -> str:
    """Return what stands in the column ``metadata``."""
    return json.dumps(metadata, allow_nan=False, ensure_ascii=False)
