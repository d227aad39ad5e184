"""What a fleet is like: spread of each parameter, cells that stand out, drift over batch and age.

The center is the median and the width 1.4826 times the median absolute deviation, the standard
deviation of normally distributed values, so that a few odd cells do not hide themselves. Only
values that their logs identify take part.
"""

from __future__ import annotations

import datetime
import sqlite3
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

# Theil and Sen's slope looks at every pair.
MOST_FOR_SLOPE = 1500
# A difference between batches counts where chance would show one like it once in so many reports.
CHANCE = 0.001
BINS = 40


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
        Of the identified ones: campaign, value, deviation (in robust standard deviations), batch,
        age.
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

    def spread_percent(self) -> float:
        """Return the width over the center."""
        return 100.0 * self.width / abs(self.center) if self.center else np.nan

    def outliers(self, sigmas: float) -> pd.DataFrame:
        """Return the cells that are further from the center than so many widths, worst first."""
        far = self.values[self.values["deviation"].abs() > sigmas]
        return far.sort_values("deviation", key=abs, ascending=False, kind="stable")


def _ages(texts: list[object]) -> np.ndarray:
    """Return ages as numbers; dates count in days since the first one."""
    numbers = np.full(len(texts), np.nan)
    days = np.full(len(texts), np.nan)
    for k, one in enumerate(texts):
        if isinstance(one, (int, float)):
            numbers[k] = one
        elif isinstance(one, str):
            try:
                days[k] = datetime.datetime.fromisoformat(one).timestamp() / 86400.0
            except ValueError:
                continue
    if np.isfinite(days).any():
        days -= np.nanmin(days)
        return days
    return numbers


def read(database: sqlite3.Connection, batch: str, age: str) -> list[Quantity]:
    """Return every parameter that a cell of the results has, then the errors of the fits.

    Parameters
    ----------
    database : sqlite3.Connection
        Results of lipoid-fleet.
    batch, age : str
        Columns of the table that the campaigns came from.
    """
    keys = [f'$."{name}"' for name in (batch, age)]
    of = pd.DataFrame(
        database.execute(
            "SELECT id, campaign, json_extract(metadata, ?), json_extract(metadata, ?), "
            "mean_error_percent, rmse_V FROM campaigns WHERE status = 'done' ORDER BY campaign",
            keys,
        ).fetchall(),
        columns=["id", "campaign", "batch", "age", "mean_error_percent", "rmse_V"],
    ).set_index("id")
    of["age"] = _ages(list(of["age"]))
    of["batch"] = [None if one is None else str(one) for one in of["batch"]]
    quantities = []
    names = database.execute("SELECT name, min(unit) FROM parameters GROUP BY name ORDER BY name")
    for name, unit in names.fetchall():
        rows = database.execute(
            "SELECT id, estimate, verdict FROM parameters WHERE name = ?", (name,)
        ).fetchall()
        table = pd.DataFrame(rows, columns=["id", "value", "verdict"]).set_index("id")
        known = table[(table["verdict"] == "identified") & table["value"].notna()]
        quantities.append(_quantity(name, unit, len(table), known["value"], of))
    for name, unit in (("mean_error_percent", "%"), ("rmse_V", "V")):
        errors = of[name].dropna()
        quantities.append(_quantity(name, unit, len(errors), errors, of))
    return quantities


def _quantity(
    name: str, unit: str, cells: int, values: pd.Series[float], of: pd.DataFrame
) -> Quantity:
    from scipy import stats

    table = of.loc[of.index.intersection(values.index), ["campaign", "batch", "age"]].copy()
    table["value"] = values.reindex(table.index).astype(float)
    made = Quantity(name, unit, cells, len(table), table)
    numbers = table["value"].to_numpy()
    deviations = np.zeros(numbers.size)
    if numbers.size:
        made.center = float(np.median(numbers))
    if numbers.size > 1:
        made.width = float(stats.median_abs_deviation(numbers, scale="normal"))
        with np.errstate(divide="ignore", invalid="ignore"):
            deviations = np.nan_to_num((numbers - made.center) / made.width, nan=0.0)
    table["deviation"] = deviations
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
                "spread_percent": one.spread_percent(),
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


def age_table(quantities: list[Quantity]) -> pd.DataFrame:
    """Return the slope of each quantity over age: Theil and Sen's, the median over all pairs.

    Drifts: the interval, of 95 % over all quantities together, holds no zero.
    """
    from scipy import stats

    rows = []
    for one in quantities:
        known = one.values.dropna(subset=["age"]).sort_values("age", kind="stable")
        if known["age"].nunique() < 3 or known["value"].nunique() < 2:
            continue
        step = int(np.ceil(len(known) / MOST_FOR_SLOPE))
        some = known.iloc[::step]
        confidence = 1.0 - 0.05 / len(quantities)
        slope, _, low, high = stats.theilslopes(some["value"], some["age"], alpha=confidence)
        rows.append(
            {
                "name": one.name,
                "unit": one.unit,
                "cells": len(known),
                "slope_per_age": float(slope),
                "low": float(low),
                "high": float(high),
                "slope_percent_per_age": 100.0 * float(slope) / abs(one.center),
                "drifts": bool(low > 0.0 or high < 0.0),
            }
        )
    return pd.DataFrame(rows)
