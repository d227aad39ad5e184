"""All results as Parquet: one row for each campaign, a column for each parameter."""

from __future__ import annotations

from typing import Any

from lipoid.fleet.errors import UsageError
from lipoid.fleet.files import appears_whole
from lipoid.fleet.results import COLUMNS, open_for_reading

ROWS_AT_A_TIME = 2000
OF_A_PARAMETER = ("estimate", "standard_error", "low_95", "high_95")
REAL = {"mean_error_percent", "rmse_V", "wall_s", "cpu_s"}
WHOLE = {"attempts", "peak_memory_bytes"}
YES_OR_NO = {"converged", "usable"}


def check() -> None:
    """Say before a long run that pyarrow is missing, not after it."""
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise UsageError(
            f"--parquet needs pyarrow: pip install 'lipoid[fleet]' ({error})"
        ) from None


def _schema(parameters: list[str]) -> Any:
    import pyarrow as pa

    fields = []
    for name in COLUMNS:
        kind = pa.string()
        if name in REAL:
            kind = pa.float64()
        elif name in WHOLE:
            kind = pa.int64()
        elif name in YES_OR_NO:
            kind = pa.bool_()
        fields.append(pa.field(name, kind))
    for parameter in parameters:
        fields += [pa.field(column_name(parameter, what), pa.float64()) for what in OF_A_PARAMETER]
        fields.append(pa.field(column_name(parameter, "verdict"), pa.string()))
    return pa.schema(fields, metadata={"schema": "lipoid.fleet/1"})


def column_name(parameter: str, what: str) -> str:
    """Return the column of a parameter's estimate, standard_error, low_95, high_95 or verdict."""
    return parameter if what == "estimate" else f"{parameter}_{what}"


def write(results: str, file: str) -> None:
    """Write the results as Parquet, sorted by campaign whatever the order of the run."""
    import pyarrow as pa
    from pyarrow import parquet

    with appears_whole(file) as temporary:
        database = open_for_reading(results)
        try:
            names = [
                str(name)
                for (name,) in database.execute(
                    "SELECT DISTINCT name FROM parameters ORDER BY name"
                )
            ]
            schema = _schema(names)
            shown = ", ".join(f'"{name}"' for name in COLUMNS)
            rows = database.execute(f"SELECT id, {shown} FROM campaigns ORDER BY campaign")
            with parquet.ParquetWriter(temporary, schema) as writer:
                while some := rows.fetchmany(ROWS_AT_A_TIME):
                    table = [_row(database, row) for row in some]
                    writer.write_table(pa.Table.from_pylist(table, schema=schema))
        finally:
            database.close()


def _row(database: Any, row: tuple[Any, ...]) -> dict[str, Any]:
    made = dict(zip(COLUMNS, row[1:], strict=True))
    for name in YES_OR_NO:
        made[name] = None if made[name] is None else bool(made[name])
    found = database.execute(
        "SELECT name, estimate, standard_error, low_95, high_95, verdict FROM parameters "
        "WHERE id = ?",
        (row[0],),
    )
    for name, *values in found:
        for what, value in zip((*OF_A_PARAMETER, "verdict"), values, strict=True):
            made[column_name(name, what)] = value
    return made
