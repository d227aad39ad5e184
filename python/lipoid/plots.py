"""Plots by matplotlib; each draws plain columns and returns the axes that it drew on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from lipoid import _core
from lipoid.errors import OptionError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

FloatArray = npt.NDArray[np.float64]
# A number, or a table over the state of charge: {"soc": [...], "resistance_Ohm": [...]}.
Resistance = float | Mapping[str, Any]

_MOST_POINTS = 20_000


def _axes(axes: Any, count: int, *, share: bool = True) -> list[Axes]:
    """Return so many axes, one above the other: those given, or new ones."""
    from matplotlib import pyplot

    if axes is not None:
        given = list(np.ravel(np.asarray(axes, dtype=object)))
        if len(given) != count:
            raise OptionError(f"axes: expected {count}, found {len(given)}")
        return given
    _, made = pyplot.subplots(
        count,
        1,
        sharex=share,
        squeeze=False,
        figsize=(7.0, 2.4 + 1.6 * count),
        layout="constrained",
    )
    return list(made[:, 0])


def _thin(*columns: Any) -> list[Any]:
    """Return every so many rows, no more than a screen has."""
    step = max(1, len(columns[0]) // _MOST_POINTS)
    return [column[::step] for column in columns]


def log(
    time_s: FloatArray,
    current_A: FloatArray,
    voltage_V: FloatArray | None,
    title: str,
    axes: Any = None,
) -> list[Axes]:
    """Draw current, and voltage where it was measured, over time."""
    drawn = _axes(axes, 1 if voltage_V is None else 2)
    t, i = _thin(time_s, current_A)
    if voltage_V is not None:
        drawn[0].plot(t, _thin(voltage_V)[0], linewidth=0.8)
        drawn[0].set_ylabel("voltage / V")
    drawn[-1].plot(t, i, linewidth=0.8)
    drawn[-1].set(xlabel="time / s", ylabel="current / A")
    drawn[0].set_title(title)
    return drawn


def simulation(
    time_s: FloatArray, voltage_V: FloatArray, soc: FloatArray, title: str, axes: Any = None
) -> list[Axes]:
    """Draw voltage and state of charge over time, of one current or of several."""
    drawn = _axes(axes, 2)
    for k, one_V in enumerate(np.atleast_2d(voltage_V)):
        one_s = np.atleast_2d(time_s)[k if time_s.ndim == 2 else 0]
        t, v, a = _thin(one_s, one_V, np.atleast_2d(soc)[k])
        drawn[0].plot(t, v, linewidth=0.8)
        drawn[1].plot(t, a, linewidth=0.8)
    drawn[0].set(ylabel="voltage / V", title=title)
    drawn[1].set(xlabel="time / s", ylabel="state of charge")
    return drawn


def _draw_resistances(named: Iterable[tuple[str, Resistance]], axis: Axes) -> None:
    for k, (name, value) in enumerate(named):
        color = f"C{k}"
        if isinstance(value, Mapping):
            milliohms = 1e3 * np.asarray(value["resistance_Ohm"])
            axis.plot(value["soc"], milliohms, "o-", color=color, label=name)
        else:
            axis.axhline(1e3 * value, color=color, label=name, linestyle="--")
    axis.set(xlabel="state of charge", ylabel="resistance / mOhm")
    axis.set_ylim(bottom=0.0)
    axis.legend()


def cell(
    soc: FloatArray,
    open_circuit_V: FloatArray,
    resistances: Iterable[tuple[str, Resistance]],
    title: str,
    axes: Any = None,
) -> list[Axes]:
    """Draw v_oc and the resistances over the state of charge."""
    drawn = _axes(axes, 2)
    drawn[0].plot(soc, open_circuit_V)
    drawn[0].set(ylabel="open-circuit voltage / V", title=title)
    _draw_resistances(resistances, drawn[1])
    return drawn


class Predicted(NamedTuple):
    """A log that took part in a fit, and what the fitted cell predicts for it."""

    kind: str
    time_s: FloatArray
    measured_V: FloatArray
    predicted_V: FloatArray
    soc: FloatArray


def fit(logs: Iterable[Predicted], title: str, axes: Any = None) -> list[Axes]:
    """Draw measured and predicted voltage and their difference, one log after the other."""
    drawn = _axes(axes, 2)
    offset_h = 0.0
    for one in logs:
        t, v, p = _thin(one.time_s, one.measured_V, one.predicted_V)
        hours = offset_h + t / 3600.0
        first = offset_h == 0.0
        drawn[0].plot(hours, v, "k", linewidth=1.2, label="measured" if first else None)
        drawn[0].plot(hours, p, "C1", linewidth=0.7, label="predicted" if first else None)
        drawn[1].plot(hours, 1e3 * (v - p), linewidth=0.6, label=one.kind)
        offset_h = float(hours[-1]) + 0.2
    drawn[0].set(ylabel="voltage / V", title=title)
    drawn[0].title.set_wrap(True)
    drawn[0].legend()
    drawn[1].set(xlabel="time, one log after the other / h", ylabel="residual / mV")
    return drawn


def open_circuit_voltage(
    low_rate: Iterable[Predicted],
    soc: FloatArray,
    open_circuit_V: FloatArray,
    title: str,
    axes: Any = None,
) -> list[Axes]:
    """Draw v_oc(A) over the rows of low-rate logs."""
    drawn = _axes(axes, 1)
    for one in low_rate:
        a, v = _thin(one.soc, one.measured_V)
        drawn[0].plot(a, v, ".", markersize=2, color="0.6", label="rows of the low-rate log")
    drawn[0].plot(soc, open_circuit_V, "C0", label="v_oc(A)")
    drawn[0].set(xlabel="state of charge", ylabel="voltage / V", title=title)
    drawn[0].legend()
    return drawn


def resistances(
    values: Iterable[tuple[str, Resistance]], intervals: pd.DataFrame, title: str, axes: Any = None
) -> list[Axes]:
    """Draw the resistances over the state of charge, with the columns low_95 and high_95."""
    drawn = _axes(axes, 1)
    named = dict(values)
    _draw_resistances(named.items(), drawn[0])
    for name, low, high in intervals[["low_95", "high_95"]].itertuples():
        base, _, place = str(name).partition("@")
        value = named.get(base)
        if value is None or not (np.isfinite(low) and np.isfinite(high)):
            continue
        if isinstance(value, Mapping) and place:
            drawn[0].plot([float(place)] * 2, [1e3 * low, 1e3 * high], color="0.4", linewidth=1.0)
        elif not isinstance(value, Mapping):
            color = f"C{list(named).index(base)}"
            drawn[0].axhspan(1e3 * low, 1e3 * high, color=color, alpha=0.2)
    drawn[0].set_title(title)
    return drawn


def correlation(uncertainty: Mapping[str, Any] | None, axes: Any = None) -> list[Axes]:
    """Draw the correlation matrix of the estimates: key `uncertainty` of a cell file."""
    if not uncertainty:
        raise OptionError("this cell has no covariance to draw")
    names = uncertainty["parameters"]
    covariance = np.asarray(uncertainty["covariance"])
    sigma = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    drawn = _axes(axes, 1)
    image = drawn[0].imshow(covariance / np.outer(sigma, sigma), vmin=-1, vmax=1, cmap="RdBu_r")
    few = range(0, len(names), max(1, len(names) // 30))
    drawn[0].set_xticks(list(few), [names[k] for k in few], rotation=90, fontsize=7)
    drawn[0].set_yticks(list(few), [names[k] for k in few], fontsize=7)
    drawn[0].figure.colorbar(image, ax=drawn[0], label="correlation")
    return drawn


def profiles(found: Sequence[Mapping[str, Any]] | None, axes: Any = None) -> list[Axes]:
    """Draw the rmse over each profiled parameter: key `profiles` of a summary."""
    if not found:
        raise OptionError('no profile was asked for: identify(..., profile=["beta"])')
    none = [
        f"{one['name']}: {_core.in_python(one['none_because'])}"
        for one in found
        if not one["points"]
    ]
    found = [one for one in found if one["points"]]
    if not found:
        raise OptionError(f"no profile could be had of {'; '.join(none)}")
    drawn = _axes(axes, len(found), share=False)
    for axis, one in zip(drawn, found, strict=True):
        points = one["points"]
        key = next(name for name in points[0] if name == "value" or name.startswith("value"))
        values = [point[key] for point in points]
        axis.plot(values, [1e3 * point["rmse_V"] for point in points], "o-")
        axis.set(xlabel=one["name"], ylabel="rmse / mV")
    return drawn


def comparison(table: pd.DataFrame, axes: Any = None) -> list[Axes]:
    """Draw how far the error of each optimizer is above the least, over its time."""
    drawn = _axes(axes, 1)
    least_V = table["rmse_V"].min()
    above_percent = 100.0 * (table["rmse_V"] / least_V - 1.0)
    drawn[0].plot(table["wall_s"], above_percent, "o")
    drawn[0].set_xscale("log")
    # Linear up to a ten-thousandth of the error: optimizers that agree differ by less.
    drawn[0].set_yscale("symlog", linthresh=0.01)
    drawn[0].set_ylim(-0.005, max(0.01, 2.0 * above_percent.max()))
    middle_s = np.sqrt(table["wall_s"].min() * table["wall_s"].max())
    for name, wall_s, percent in zip(table.index, table["wall_s"], above_percent, strict=True):
        side = "left" if wall_s <= middle_s else "right"
        drawn[0].annotate(str(name), (wall_s, percent), fontsize=8, horizontalalignment=side)
    drawn[0].set(xlabel="time / s", ylabel=f"rmse above the least, {1e3 * least_V:.4g} mV, / %")
    return drawn


def flight(data: pd.DataFrame, title: str, axes: Any = None) -> list[Axes]:
    """Draw altitude, angles, voltage and current over time."""
    drawn = _axes(axes, 4)
    data = data.iloc[:: max(1, len(data) // _MOST_POINTS)]
    t = data["time_s"]

    def draw(axis: Axes, names: Sequence[str], scale: float, label: str) -> None:
        for name in names:
            axis.plot(t, scale * data[name], linewidth=0.9, label=name.rsplit("_", 1)[0])
        axis.set_ylabel(label)
        if len(names) > 1:
            axis.legend(fontsize=7, ncols=len(names))

    draw(drawn[0], ["altitude_m", "altitude_reference_m"], 1.0, "altitude / m")
    draw(drawn[1], ["roll_rad", "pitch_rad", "yaw_rad"], 180.0 / np.pi, "angle / degrees")
    draw(drawn[2], ["battery_V"], 1.0, "voltage / V")
    draw(drawn[3], ["battery_A"], 1.0, "current / A")
    drawn[3].set_xlabel("time / s")
    drawn[0].set_title(title, fontsize=9)
    return drawn
