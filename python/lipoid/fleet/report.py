"""The command ``lipoid-fleet report``."""

from __future__ import annotations

import argparse
import json
import os
import sqlite3
from html import escape

import numpy as np
import pandas as pd

import lipoid
from lipoid.errors import LoadError
from lipoid.fleet import options, page, spread
from lipoid.fleet.errors import DONE, UsageError, say
from lipoid.fleet.files import STANDARD_OUTPUT, check_writable, write_text
from lipoid.fleet.results import open_for_reading
from lipoid.fleet.spread import Fleet, Quantity

WHAT = """Says what a fleet is like, from the results of lipoid-fleet: the spread of every
parameter, cells that stand out, and drift over batch and age. A cell stands out where a value is
far from the median, in units of 1.4826 times the median absolute deviation, or of the standard
error of the cell where that is larger."""
EXAMPLE = "example: lipoid-fleet report results.sqlite -o report.html --outliers outliers.csv"

SPREAD_TITLES = {
    "name": "parameter",
    "unit": "unit",
    "cells": "cells",
    "identified": "identified",
    "median": "median",
    "robust_standard_deviation": "robust std. dev.",
    "spread_percent": "spread in %",
    "quantile_5_percent": "5 % below",
    "quantile_95_percent": "95 % below",
    "minimum": "least",
    "maximum": "most",
    "outliers": "outliers",
}
OUTLIER_TITLES = {
    "campaign": "campaign",
    "name": "parameter",
    "value": "value",
    "unit": "unit",
    "deviation": "robust std. deviations off",
}
BATCH_TITLES = {
    "name": "parameter",
    "unit": "unit",
    "batch": "batch",
    "cells": "cells",
    "median": "median",
    "quantile_5_percent": "5 % below",
    "quantile_95_percent": "95 % below",
    "probability_by_chance": "probability by chance",
    "differs": "batches differ",
}
AGE_TITLES = {
    "name": "parameter",
    "unit": "unit",
    "cells": "cells",
    "slope_per_age": "change per unit of age",
    "low": "95 % from",
    "high": "to",
    "slope_percent_per_age": "% per unit of age",
    "drifts": "drifts",
}
AGE_BINS = 8
MOST_BATCHES = 30


def _parser() -> argparse.ArgumentParser:
    made = options.parser("lipoid-fleet report", WHAT, EXAMPLE)
    made.add_argument("results", metavar="RESULTS", help="the SQLite file of lipoid-fleet")
    made.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        required=True,
        help="a page (.html), or the table of the spread (.csv)",
    )
    made.add_argument(
        "--outliers", metavar="CSV", default="", help="write every value that stands out"
    )
    made.add_argument(
        "--drift",
        metavar="CSV",
        default="",
        help="write the medians of batches and the slopes over age",
    )
    made.add_argument(
        "--batch",
        metavar="COLUMN",
        default="batch",
        help="the column of the table of campaigns that groups cells (default batch)",
    )
    made.add_argument(
        "--age",
        metavar="COLUMN",
        default="age",
        help="the column with a number or a date, over "
        "which parameters may drift; dates as 2024-01-31 count in days since the first (default "
        "age)",
    )
    made.add_argument(
        "--outlier-sigmas",
        metavar="VALUE",
        type=float,
        default=4.0,
        help="robust standard "
        "deviations from the median from which a value stands out, more of few cells, whose "
        "deviation is itself off; 1 .. 100 (default 4)",
    )
    return made


def _check(given: argparse.Namespace) -> None:
    if not given.output.endswith((".html", ".csv")):
        raise UsageError(f"-o: expected a file .html or .csv, found {given.output!r}")
    if not 1.0 <= given.outlier_sigmas <= 100.0:
        raise UsageError(f"--outlier-sigmas: expected 1 .. 100, found {given.outlier_sigmas:g}")
    for column in (given.batch, given.age):
        if '"' in column:
            raise UsageError(f"expected the name of a column without quotes, found {column!r}")
    seen = {os.path.realpath(given.results): given.results}
    for output in (given.output, given.outliers, given.drift):
        if not output or output in STANDARD_OUTPUT:
            continue
        if other := seen.get(os.path.realpath(output)):
            raise UsageError(f"{output} would overwrite {other}")
        seen[os.path.realpath(output)] = output
        check_writable(output, _is_report)


def _is_report(begin: bytes) -> bool:
    """Whether this command wrote a file that begins so: no table of campaigns is lost to it."""
    first = begin.partition(b"\n")[0].strip()
    tables = (b"name,unit,", b"campaign,name,unit,")
    return first in (b"", b'""', b"<!doctype html>") or first.startswith(tables)


def _check_columns(database: sqlite3.Connection, given: argparse.Namespace) -> None:
    """Refuse a column that no result has; those of the defaults may be missing."""
    asked = {"--batch": given.batch, "--age": given.age}
    rows = database.execute("SELECT DISTINCT key FROM campaigns, json_each(metadata) ORDER BY key")
    known = [key for (key,) in rows]
    for option, column in asked.items():
        if column not in known and column != _parser().get_default(option.strip("-")):
            have = ", ".join(known[:20]) or "none"
            raise UsageError(f"{option}: expected a column of the results, {have}; found {column}")


def command(words: list[str]) -> int:
    """Write what was asked for; return the exit code."""
    given = _parser().parse_args(words)
    _check(given)
    try:
        database = open_for_reading(given.results)
    except (OSError, ValueError) as error:
        raise LoadError(str(error), [(given.results, 0, 0, str(error))]) from None
    try:
        _check_columns(database, given)
        fleet = spread.read(database, given.batch, given.age)
        failed = database.execute(
            "SELECT campaign, failure, reason FROM campaigns WHERE status = 'failed' "
            "ORDER BY campaign"
        ).fetchall()
        versions = database.execute('SELECT DISTINCT version, "commit" FROM campaigns').fetchall()
    except sqlite3.Error as error:
        message = f"{given.results}: error: cannot be read: {error}"
        raise LoadError(message, [(given.results, 0, 0, message)]) from None
    finally:
        database.close()
    quantities = fleet.quantities
    sigmas = given.outlier_sigmas
    spreads = spread.spread_table(quantities, sigmas)
    outliers = spread.outlier_table(quantities, sigmas)
    batches = spread.batch_table(quantities)
    ages = spread.age_table(quantities)
    if given.output.endswith(".csv"):
        write_text(given.output, spreads.to_csv(index=False))
    else:
        failures = pd.DataFrame(failed, columns=["campaign", "failure", "reason"])
        parts = _parts(fleet, sigmas, (versions, failures, spreads, outliers, batches, ages))
        write_text(given.output, page.page("Fleet of cells", parts))
    if given.outliers:
        write_text(given.outliers, outliers.to_csv(index=False))
    if given.drift:
        both = [
            one.assign(over=what) for one, what in ((batches, "batch"), (ages, "age")) if len(one)
        ]
        text = pd.concat(both).to_csv(index=False) if both else "name,unit,over\n"
        write_text(given.drift, text)
    for caveat in fleet.caveats:
        say(f"lipoid-fleet report: warning: {caveat}")
    cells = outliers["campaign"].nunique() if len(outliers) else 0
    say(
        f"{fleet.cells} cells, {len(failed)} failed; {cells} stand out by more than chance lets "
        f"{sigmas:g} standard deviations"
    )
    return DONE


def _age_ranges(one: Quantity) -> list[tuple[str, float, float, float]]:
    known = one.values.dropna(subset=["age"]).sort_values("age", kind="stable")
    if known["age"].nunique() < 3:
        return []
    rows = []
    for part in np.array_split(np.arange(len(known)), min(AGE_BINS, known["age"].nunique())):
        low, middle, high = np.quantile(known["value"].to_numpy()[part], (0.05, 0.5, 0.95))
        age = np.median(known["age"].to_numpy()[part])
        rows.append((f"age {age:.4g}", float(low), float(middle), float(high)))
    return rows


def _limits(fleet: Fleet, sigmas: float) -> str:
    """Say how many robust ones that is: these are known from few cells."""
    limits = [one.limit(sigmas) for one in fleet.quantities if one.identified > 1]
    if not limits:
        return ""
    low, high = f"{min(limits):.2g}", f"{max(limits):.2g}"
    return f", which is {low if low == high else f'{low} to {high}'} robust ones for so few cells"


def _parts(
    fleet: Fleet,
    sigmas: float,
    found: tuple[
        list[tuple[str, str]],
        pd.DataFrame,
        pd.DataFrame,
        pd.DataFrame,
        pd.DataFrame,
        pd.DataFrame,
    ],
) -> list[str]:
    versions, failures, spreads, outliers, batches, ages = found
    made_by = ", ".join(f"lipoid {version} ({commit})" for version, commit in versions)
    parts = [
        f"<p>{fleet.cells} cells are identified, {len(failures)} campaigns failed. Identified by "
        f"{escape(made_by)}; this page by lipoid {lipoid.__version__}.</p>",
        *(f'<p class="found">{escape(one)}</p>' for one in fleet.caveats),
        "<h2>Spread</h2><p>Over the cells whose logs identify the parameter. The robust standard "
        "deviation is 1.4826 times the median absolute deviation.</p>",
        page.table(spreads, SPREAD_TITLES),
        '<div class="charts">'
        + "".join(page.histogram(one, sigmas) for one in fleet.quantities if one.identified > 1)
        + "</div>",
        "<h2>Cells that stand out</h2><p>Further from the median than chance puts a cell beyond "
        f"{sigmas:g} true standard deviations{_limits(fleet, sigmas)}; in standard errors of the "
        "cell where these are larger.</p>",
    ]
    if len(outliers):
        parts.append(page.table(outliers.head(page.MOST_OUTLIERS), OUTLIER_TITLES))
        if len(outliers) > page.MOST_OUTLIERS:
            parts.append(
                f"<p>The first {page.MOST_OUTLIERS} of {len(outliers)}; --outliers writes all.</p>"
            )
    else:
        parts.append("<p>None does.</p>")
    parts += _batch_parts(batches) + _age_parts(fleet, ages)
    if len(failures):
        parts.append("<h2>Failed campaigns</h2>")
        titles = {"campaign": "campaign", "failure": "failure", "reason": "reason"}
        parts.append(page.table(failures.head(page.MOST_OUTLIERS), titles))
    summary = json.dumps(sorted(set(failures["failure"]))) if len(failures) else ""
    if len(failures) > page.MOST_OUTLIERS:
        parts.append(
            f"<p>The first {page.MOST_OUTLIERS} of {len(failures)}, of the kinds "
            f"{escape(summary)}.</p>"
        )
    return parts


def _batch_parts(batches: pd.DataFrame) -> list[str]:
    if not len(batches):
        return ["<h2>Batches</h2><p>The results name fewer than two batches.</p>"]
    charts = []
    for name, of in batches.groupby("name", sort=False):
        columns = ["batch", "quantile_5_percent", "median", "quantile_95_percent"]
        rows = list(of[columns].head(MOST_BATCHES).itertuples(index=False, name=None))
        charts.append(
            page.ranges(f"{name} in {of['unit'].iloc[0] or 1}: median, 90 % of cells", rows)
        )
    return [
        "<h2>Batches</h2><p>Batches differ where Kruskal and Wallis' test of ranks gives a "
        f"probability below {spread.CHANCE:g} divided by the number of quantities.</p>",
        page.table(batches.head(40 * MOST_BATCHES), BATCH_TITLES),
        f'<div class="charts">{"".join(charts)}</div>',
    ]


def _age_parts(fleet: Fleet, ages: pd.DataFrame) -> list[str]:
    if not len(ages):
        why = "No parameter is known at three different ages and differs between cells."
        if fleet.ages < 3:
            why = (
                "The slopes need cells of at least three different ages; the results give "
                f"{fleet.ages}."
            )
        return [f"<h2>Age</h2><p>{why}</p>"]
    charts = [
        page.ranges(f"{one.name} in {one.unit or 1}: median, 90 % of cells", rows)
        for one in fleet.quantities
        if (rows := _age_ranges(one))
    ]
    return [
        "<h2>Age</h2><p>The slope is that of Theil and Sen, the median over pairs of cells; its "
        "interval holds for all quantities together with 95 %.</p>",
        page.table(ages, AGE_TITLES),
        *(
            [
                "<p>Without an interval there are not enough cells to tell: with these "
                f"{len(fleet.quantities)} quantities it takes "
                f"{spread.fewest_for_drift(len(fleet.quantities))} of different ages.</p>"
            ]
            if ages["low"].isna().any()
            else []
        ),
        f'<div class="charts">{"".join(charts)}</div>',
    ]
