"""What a fleet is like: spread of each parameter, cells that stand out, drift over batch and age.

The center is the median and the width 1.4826 times the median absolute deviation, the standard
deviation of normally distributed values, so that a few odd cells do not hide themselves. Only
values that their logs identify take part. A cell is measured by the width, or by its own standard
error where that is larger.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import sqlite3
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pandas as pd

from lipoid.fleet import ages

# Theil and Sen's slope looks at every pair.
MOST_FOR_SLOPE = 1500
# Up to so many cells the chance of every order of their values is counted, not approximated.
MOST_FOR_COUNT = 30
# The slopes of all quantities together are wrong by chance once in so many reports.
CHANCE_OF_DRIFT = 0.05
# The width of fewer cells is no yardstick.
FEWEST_FOR_OUTLIERS = 10
# A value over the robust width of n normally distributed ones is distributed about as Student's t
# with (n - 1)/2 degrees of freedom.
FREEDOM_OF_WIDTH = 0.5
# A difference between batches counts where chance would show one like it once in so many reports.
CHANCE = 0.001
BINS = 40
MOST_OPTIONS = 5


@dataclass
class Quantity:
    """One parameter, or one error, over all cells.

    Attributes
    ----------
    name, unit : str
        As in identify.
    cells, identified : int
        That have it; whose logs identify it.
    values : pandas.DataFrame
        Of the identified ones: campaign, value, deviation (in robust standard deviations, or
        standard errors of the cell where these are larger; NaN where the width is zero or the
        cells are too few), batch, age.
    center, width : float
        Median and robust standard deviation.
    """

    name: str
    unit: str
    cells: int
    identified: int
    values: pd.DataFrame = field(repr=False)
    center: float = np.nan
    width: float = np.nan

    def quantile(self, share: float) -> float:
        """Return the value that this share of the cells is below."""
        values = self.values["value"].to_numpy()
        return float(np.quantile(values, share)) if values.size else np.nan

    def percent(self, value: float) -> float:
        """Return a value in percent of the center; NaN where the center is zero."""
        return 100.0 * value / abs(self.center) if self.center else np.nan

    def without_width(self) -> str:
        """Return a sentence on the cells that differ where no width can measure them, or ""."""
        off = (self.values["value"] - self.center).abs()
        if self.width != 0.0 or not off.any():
            return ""
        furthest = self.values.iloc[int(off.to_numpy().argmax())]
        others = int((off > 0.0).sum())
        unit = f" {self.unit}" if self.unit else ""
        return (
            f"{self.name}: more than half of the cells have exactly {self.center:.10g}{unit}, so "
            "that the robust standard deviation is 0 and no cell can be measured by it. "
            f"{_cells(others)} {'has' if others == 1 else 'have'} another value; the furthest, "
            f"{furthest['value']:.10g}{unit}, is of {furthest['campaign']}."
        )

    def limit(self, sigmas: float) -> float:
        """Return how many widths off chance takes a value as rarely as so many true deviations."""
        from scipy import stats

        freedom = FREEDOM_OF_WIDTH * (self.identified - 1)
        return float(stats.t.isf(stats.norm.sf(sigmas), freedom))

    def outliers(self, sigmas: float) -> pd.DataFrame:
        """Return the cells that deviate from the center by more than limit(), worst first."""
        far = self.values[self.values["deviation"].abs() > self.limit(sigmas)]
        return far.sort_values("deviation", key=abs, ascending=False, kind="stable")


@dataclass
class Fleet:
    """What the results of a fleet hold.

    Attributes
    ----------
    quantities : list of Quantity
        Every parameter that a cell of the results has, then the errors of the fits.
    cells : int
        How many cells are identified.
    ages : int
        How many different ages the cells have.
    caveats : list of str
        What a reader must know before comparing cells.
    """

    quantities: list[Quantity]
    cells: int
    ages: int
    caveats: list[str]


def read(database: sqlite3.Connection, batch: str, age: str) -> Fleet:
    """Return what the results hold.

    Parameters
    ----------
    database : sqlite3.Connection
        Results of lipoid-fleet.
    batch, age : str
        Columns of the table that the campaigns came from.
    """
    keys = [f'$."{name}"' for name in (batch, age)]
    # As objects: where a field is empty, pandas would make floats of whole numbers.
    of = pd.DataFrame(
        database.execute(
            "SELECT id, campaign, json_extract(metadata, ?), json_extract(metadata, ?), "
            "mean_error_percent, rmse_V FROM campaigns WHERE status = 'done' ORDER BY campaign",
            keys,
        ).fetchall(),
        columns=["id", "campaign", "batch", "age", "mean_error_percent", "rmse_V"],
        dtype=object,
    )
    of = of.astype({"id": int, "mean_error_percent": float, "rmse_V": float}).set_index("id")
    gone, copies = _twins(database)
    of = of.drop(index=gone)
    of["age"], left_out = ages.read(age, list(of["age"]))
    of["batch"] = [None if pd.isna(one) or one == "" else str(one) for one in of["batch"]]
    quantities = []
    names = database.execute("SELECT name, min(unit) FROM parameters GROUP BY name ORDER BY name")
    for name, unit in names.fetchall():
        rows = database.execute(
            "SELECT id, estimate, standard_error, verdict FROM parameters WHERE name = ?", (name,)
        ).fetchall()
        table = pd.DataFrame(rows, columns=["id", "value", "error", "verdict"]).set_index("id")
        table = table[table.index.isin(of.index)]
        known = table[(table["verdict"] == "identified") & table["value"].notna()]
        quantities.append(_quantity(name, unit, len(table), known, of))
    for name, unit in (("mean_error_percent", "%"), ("rmse_V", "V")):
        errors = of[[name]].dropna().set_axis(["value"], axis=1).assign(error=np.nan)
        quantities.append(_quantity(name, unit, len(errors), errors, of))
    caveats = [_several_options(database, gone), _of_twins(gone, copies), left_out]
    caveats.append(_too_few(quantities))
    caveats += [one.without_width() for one in quantities]
    return Fleet(quantities, len(of), of["age"].nunique(), [one for one in caveats if one])


def _twins(database: sqlite3.Connection) -> tuple[list[int], list[tuple[str, str]]]:
    """Find results of the same files, byte for byte.

    Returns
    -------
    gone : list of int
        Those whose campaign has another name now, or two of which another one is here.
    copies : list of pairs of str
        Of the others, each that has the files of another one, and that one.
    """
    rows = database.execute(
        "SELECT id, campaign, inputs FROM campaigns WHERE status = 'done' ORDER BY campaign"
    )
    alike: dict[tuple[str, ...], list[tuple[int, str]]] = {}
    for number, campaign, inputs in rows:
        if digests := tuple(sorted(one["sha256"] for one in json.loads(inputs or "[]"))):
            alike.setdefault(digests, []).append((number, campaign))
    gone: list[int] = []
    copies = []
    for of in alike.values():
        if len(of) == 1:
            continue
        there: dict[str, tuple[int, str]] = {}
        for one in of:
            if os.path.exists(one[1]):
                there.setdefault(os.path.realpath(one[1]), one)
        kept = list(there.values()) or of
        names = {campaign for _, campaign in kept}
        gone += [number for number, campaign in of if campaign not in names]
        copies += [(campaign, kept[0][1]) for _, campaign in kept[1:]]
    return gone, copies


def _of_twins(gone: list[int], copies: list[tuple[str, str]]) -> str:
    sentences = []
    if gone:
        sentences.append(
            f"Left out: {_results(len(gone))} of campaigns that were moved or renamed since, or "
            "have two names by a link; they count by one name that is there."
        )
    if copies:
        copy, first = copies[0]
        more = ", ..." if len(copies) > 1 else ""
        sentences.append(
            f"The files of {_results(len(copies))} are those of another one, byte for byte ({copy} "
            f"of {first}{more}), and each counts as a cell of its own."
        )
    return " ".join(sentences)


def _results(count: int) -> str:
    return "1 result" if count == 1 else f"{count} results"


def _several_options(database: sqlite3.Connection, gone: list[int]) -> str:
    found = database.execute(
        "SELECT options, count(*) FROM campaigns WHERE status = 'done' "
        "AND id NOT IN (SELECT value FROM json_each(?)) "
        "GROUP BY options ORDER BY count(*) DESC, options",
        (json.dumps(gone),),
    ).fetchall()
    if len(found) < 2:
        return ""
    shown = [
        f"{_cells(count)} of {'the defaults' if options == '{}' else options}"
        for options, count in found[:MOST_OPTIONS]
    ]
    more = ", ..." if len(found) > MOST_OPTIONS else ""
    return (
        f"The results are of {len(found)} sets of options: {', '.join(shown)}{more}. Differences "
        "between cells may be differences between methods. To compare cells, do all with the same "
        "options: lipoid-fleet with --replace."
    )


def _too_few(quantities: list[Quantity]) -> str:
    few = [one for one in quantities if 1 < one.identified < FEWEST_FOR_OUTLIERS]
    if not few:
        return ""
    named = ", ".join(f"{one.name} ({one.identified})" for one in few)
    return (
        f"There are not enough cells to tell whether one stands out: {named}. It takes "
        f"{FEWEST_FOR_OUTLIERS} whose logs identify the parameter."
    )


def _cells(count: int) -> str:
    return "1 cell" if count == 1 else f"{count} cells"


def _quantity(name: str, unit: str, cells: int, known: pd.DataFrame, of: pd.DataFrame) -> Quantity:
    from scipy import stats

    table = of.loc[of.index.intersection(known.index), ["campaign", "batch", "age"]].copy()
    table["value"] = known["value"].reindex(table.index).astype(float)
    made = Quantity(name, unit, cells, len(table), table)
    numbers = table["value"].to_numpy()
    table["deviation"] = np.nan
    if numbers.size:
        made.center = float(np.median(numbers))
    if numbers.size > 1:
        made.width = float(stats.median_abs_deviation(numbers, scale="normal"))
    if made.width > 0.0 and numbers.size >= FEWEST_FOR_OUTLIERS:
        errors = known["error"].reindex(table.index).astype(float)
        table["deviation"] = (numbers - made.center) / np.fmax(made.width, errors)
    return made


def spread_table(quantities: list[Quantity], sigmas: float) -> pd.DataFrame:
    """Return one row for each quantity."""
    rows = []
    for one in quantities:
        rows.append(
            {
                "name": one.name,
                "unit": one.unit,
                "cells": one.cells,
                "identified": one.identified,
                "median": one.center,
                "robust_standard_deviation": one.width,
                "spread_percent": one.percent(one.width),
                "minimum": one.quantile(0.0),
                "quantile_5_percent": one.quantile(0.05),
                "quantile_95_percent": one.quantile(0.95),
                "maximum": one.quantile(1.0),
                "outliers": len(one.outliers(sigmas)),
            }
        )
    return pd.DataFrame(rows)


def outlier_table(quantities: list[Quantity], sigmas: float) -> pd.DataFrame:
    """Return one row for each value that stands out, the furthest first."""
    tables = []
    for one in quantities:
        far = one.outliers(sigmas)[["campaign", "batch", "age", "value", "deviation"]].copy()
        far.insert(1, "name", one.name)
        far.insert(2, "unit", one.unit)
        tables.append(far)
    if not tables:
        return pd.DataFrame(columns=["campaign", "name", "unit", "value", "deviation"])
    together = pd.concat([one for one in tables if len(one)] or tables[:1])
    return together.sort_values(
        "deviation", key=abs, ascending=False, kind="stable", ignore_index=True
    )


def batch_table(quantities: list[Quantity]) -> pd.DataFrame:
    """Return one row for each quantity and batch, with the test of whether batches differ.

    The test is that of Kruskal and Wallis, which knows ranks alone; differs: its probability is
    below 0.001 divided by the number of quantities.
    """
    from scipy import stats

    rows = []
    for one in quantities:
        known = one.values.dropna(subset=["batch"])
        groups = {str(name): table["value"].to_numpy() for name, table in known.groupby("batch")}
        if len(groups) < 2:
            continue
        probability = np.nan
        if known["value"].nunique() > 1:
            probability = float(stats.kruskal(*groups.values()).pvalue)
        for name, values in groups.items():
            rows.append(
                {
                    "name": one.name,
                    "unit": one.unit,
                    "batch": name,
                    "cells": len(values),
                    "median": float(np.median(values)),
                    "quantile_5_percent": float(np.quantile(values, 0.05)),
                    "quantile_95_percent": float(np.quantile(values, 0.95)),
                    "probability_by_chance": probability,
                    "differs": bool(probability < CHANCE / len(quantities)),
                }
            )
    return pd.DataFrame(rows)


def fewest_for_drift(quantities: int) -> int:
    """Return how many cells of different ages can show a drift of one of so many quantities."""
    chance = CHANCE_OF_DRIFT / quantities
    return next(cells for cells in itertools.count(3) if 0.5 * chance * math.factorial(cells) >= 1)


def _orders(ages: npt.NDArray[np.float64]) -> list[int]:
    """Return how many orders of the values have 0, 1, ... pairs that fall as the age rises.

    The generating function is that of the inversions of a multiset, whose product over the cells
    this is: (1 - q^n) / (1 - q^j) for the n-th cell, the j-th of its age.
    """
    tied = Counter(ages.tolist()).values()
    pairs = math.comb(len(ages), 2) - sum(math.comb(count, 2) for count in tied)
    orders = [1] + [0] * pairs
    cells = itertools.count(1)
    for count in tied:
        for j in range(1, count + 1):
            n = next(cells)
            for k in range(pairs, n - 1, -1):
                orders[k] -= orders[k - n]
            for k in range(j, pairs + 1):
                orders[k] += orders[k - j]
    return orders


def _slope(
    values: npt.NDArray[np.float64], ages: npt.NDArray[np.float64], chance: float
) -> tuple[float, float, float]:
    """Return Theil and Sen's slope and its interval, NaN where the cells are too few for one."""
    from scipy import stats

    slope, _, low, high = stats.theilslopes(values, ages, alpha=1.0 - chance)
    if len(ages) <= MOST_FOR_COUNT:
        below = np.cumsum(np.array(_orders(ages), dtype=float))
        left_out = int(np.count_nonzero(below <= 0.5 * chance * below[-1]))
        if not left_out:
            return float(slope), np.nan, np.nan
        later = np.subtract.outer(ages, ages) > 0.0
        rises = np.subtract.outer(values, values)[later] / np.subtract.outer(ages, ages)[later]
        low, high = np.sort(rises)[[left_out - 1, -left_out]]
    return float(slope), float(low), float(high)


def age_table(quantities: list[Quantity]) -> pd.DataFrame:
    """Return the slope of each quantity over age: Theil and Sen's, the median over all pairs.

    Drifts: the interval, of 95 % over all quantities together, holds no zero; None without one.
    """
    rows = []
    for one in quantities:
        known = one.values.dropna(subset=["age"]).sort_values("age", kind="stable")
        if known["age"].nunique() < 3 or known["value"].nunique() < 2:
            continue
        some = known.iloc[:: int(np.ceil(len(known) / MOST_FOR_SLOPE))]
        slope, low, high = _slope(
            some["value"].to_numpy(float),
            some["age"].to_numpy(float),
            CHANCE_OF_DRIFT / len(quantities),
        )
        rows.append(
            {
                "name": one.name,
                "unit": one.unit,
                "cells": len(known),
                "slope_per_age": slope,
                "low": low,
                "high": high,
                "slope_percent_per_age": one.percent(slope),
                "drifts": None if np.isnan(low) else low > 0.0 or high < 0.0,
            }
        )
    return pd.DataFrame(rows)
