"""Plots by matplotlib; each returns the axes that it drew on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lipoid.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lipoid._cell import Cell, Simulation
    from lipoid._identify import Identification
    from lipoid._log import Log
    from lipoid._more import Comparison, Flight

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


def log(of: Log, axes: Any = None) -> list[Axes]:
    """Draw current and voltage over time."""
    both = of.voltage_V is not None
    drawn = _axes(axes, 1 + both)
    t, i = _thin(of.time_s, of.current_A)
    if of.voltage_V is not None:
        drawn[0].plot(t, _thin(of.voltage_V)[0], linewidth=0.8)
        drawn[0].set_ylabel("voltage / V")
    drawn[-1].plot(t, i, linewidth=0.8)
    drawn[-1].set(xlabel="time / s", ylabel="current / A")
    drawn[0].set_title(of.file)
    return drawn


def simulation(of: Simulation, axes: Any = None) -> list[Axes]:
    """Draw voltage and state of charge over time."""
    drawn = _axes(axes, 2)
    for k, voltage_V in enumerate(np.atleast_2d(of.voltage_V)):
        time_s = np.atleast_2d(of.time_s)[k if of.time_s.ndim == 2 else 0]
        t, v, a = _thin(time_s, voltage_V, np.atleast_2d(of.soc)[k])
        drawn[0].plot(t, v, linewidth=0.8)
        drawn[1].plot(t, a, linewidth=0.8)
    drawn[0].set(ylabel="voltage / V", title=of.cell.name)
    drawn[1].set(xlabel="time / s", ylabel="state of charge")
    return drawn


def _resistances(of: Cell) -> list[tuple[str, Any]]:
    data = of.to_dict()
    named = [("r_s", data["series_resistance_Ohm"])]
    named += [(f"r_{k}", one["resistance_Ohm"]) for k, one in enumerate(data["branches"], 1)]
    return named


def _draw_resistances(of: Cell, axis: Axes) -> None:
    for name, value in _resistances(of):
        if isinstance(value, dict):
            axis.plot(value["soc"], 1e3 * np.asarray(value["resistance_Ohm"]), "o-", label=name)
        else:
            axis.axhline(1e3 * value, label=name, linestyle="--")
    axis.set(xlabel="state of charge", ylabel="resistance / mOhm")
    axis.set_ylim(bottom=0.0)
    axis.legend()


def cell(of: Cell, axes: Any = None) -> list[Axes]:
    """Draw v_oc and the resistances over the state of charge."""
    drawn = _axes(axes, 2)
    soc = np.linspace(0.0, 1.0, 501)
    drawn[0].plot(soc, of.open_circuit_voltage(soc))
    drawn[0].set(ylabel="open-circuit voltage / V", title=of.name)
    _draw_resistances(of, drawn[1])
    return drawn


def _fit(of: Identification, axes: Any) -> list[Axes]:
    drawn = _axes(axes, 2)
    one = of.cell.pack(1, 1)
    offset_h = 0.0
    for kind, core, start in of.campaign._core.logs():
        if kind == "validation" or core.voltage_V is None:
            continue
        predicted = one.simulate(
            core.time_s, core.current_A, hold=core.hold, initial_soc=start
        ).voltage_V
        t, v, p = _thin(core.time_s, core.voltage_V, predicted)
        hours = offset_h + t / 3600.0
        first = offset_h == 0.0
        drawn[0].plot(hours, v, "k", linewidth=1.2, label="measured" if first else None)
        drawn[0].plot(hours, p, "C1", linewidth=0.7, label="predicted" if first else None)
        drawn[1].plot(hours, 1e3 * (v - p), linewidth=0.6, label=kind)
        offset_h = float(hours[-1]) + 0.2
    drawn[0].set(ylabel="voltage / V", title=of.sentence)
    drawn[0].title.set_wrap(True)
    drawn[0].legend()
    drawn[1].set(xlabel="time, one log after the other / h", ylabel="residual / mV")
    return drawn


def _open_circuit_voltage(of: Identification, axes: Any) -> list[Axes]:
    drawn = _axes(axes, 1)
    one = of.cell.pack(1, 1)
    for kind, core, start in of.campaign._core.logs():
        if kind != "low-rate" or core.voltage_V is None:
            continue
        flown = one.simulate(core.time_s, core.current_A, hold=core.hold, initial_soc=start)
        a, v = _thin(flown.soc, core.voltage_V)
        drawn[0].plot(a, v, ".", markersize=2, color="0.6", label="rows of the low-rate log")
    soc = np.linspace(0.0, 1.0, 501)
    drawn[0].plot(soc, one.open_circuit_voltage(soc), "C0", label="v_oc(A)")
    drawn[0].set(xlabel="state of charge", ylabel="voltage / V", title=of.cell.name)
    drawn[0].legend()
    return drawn


def _resistances_with_intervals(of: Identification, axes: Any) -> list[Axes]:
    drawn = _axes(axes, 1)
    _draw_resistances(of.cell, drawn[0])
    named = {name: value for name, value in _resistances(of.cell)}
    for name, low, high in of.parameters[["low_95", "high_95"]].itertuples():
        base, _, place = str(name).partition("@")
        value = named.get(base)
        if value is None or not (np.isfinite(low) and np.isfinite(high)):
            continue
        if isinstance(value, dict) and place:
            drawn[0].plot([float(place)] * 2, [1e3 * low, 1e3 * high], color="0.4", linewidth=1.0)
        elif not isinstance(value, dict):
            drawn[0].axhspan(1e3 * low, 1e3 * high, alpha=0.2)
    drawn[0].set_title(of.cell.name)
    return drawn


def _correlation(of: Identification, axes: Any) -> list[Axes]:
    uncertainty = of.cell.to_dict().get("uncertainty")
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


def _profile(of: Identification, axes: Any) -> list[Axes]:
    profiles = of.summary.get("profiles")
    if not profiles:
        raise OptionError('no profile was asked for: identify(..., profile=["beta"])')
    drawn = _axes(axes, len(profiles), share=False)
    for axis, one in zip(drawn, profiles, strict=True):
        points = one["points"]
        key = next(name for name in points[0] if name == "value" or name.startswith("value"))
        values = [point[key] for point in points]
        axis.plot(values, [1e3 * point["rmse_V"] for point in points], "o-")
        axis.set(xlabel=one["name"], ylabel="rmse / mV")
    return drawn


def identification(of: Identification, what: str = "fit", axes: Any = None) -> list[Axes]:
    """Draw a result; see :meth:`Identification.plot`."""
    drawings = {
        "fit": _fit,
        "open_circuit_voltage": _open_circuit_voltage,
        "resistances": _resistances_with_intervals,
        "correlation": _correlation,
        "profile": _profile,
    }
    if what not in drawings:
        raise OptionError(f"plot: expected one of {', '.join(drawings)}, found '{what}'")
    return drawings[what](of, axes)


def comparison(of: Comparison, axes: Any = None) -> list[Axes]:
    """Draw the error over the time of each optimizer."""
    drawn = _axes(axes, 1)
    table = of.results
    drawn[0].loglog(table["wall_s"], 1e3 * table["rmse_V"], "o")
    for name, wall_s, rmse_V in table[["wall_s", "rmse_V"]].itertuples():
        drawn[0].annotate(str(name), (wall_s, 1e3 * rmse_V), fontsize=8)
    drawn[0].set(xlabel="time / s", ylabel="rmse / mV")
    return drawn


def flight(of: Flight, axes: Any = None) -> list[Axes]:
    """Draw altitude, angles, voltage and current over time."""
    drawn = _axes(axes, 4)
    data = of.data.iloc[:: max(1, len(of.data) // _MOST_POINTS)]
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
    drawn[0].set_title(repr(of)[7:-1], fontsize=9)
    return drawn
