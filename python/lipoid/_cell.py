"""Cells: what identification finds and simulations start from."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
import numpy.typing as npt
import pandas as pd

from lipoid import _core, interoperability, plots
from lipoid._log import Log, column, core_of
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lipoid._core import Cell as CoreCell

logger = logging.getLogger("lipoid")
FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Simulation:
    """The voltage of a cell under a current.

    Attributes
    ----------
    time_s : ndarray
        Times in s, shape (rows,) or (currents, rows).
    current_A : ndarray
        Currents of the pack in A, discharge positive, shape (rows,) or (currents, rows).
    voltage_V : ndarray
        Terminal voltage of the pack in V, of the shape of the currents.
    soc : ndarray
        State of charge, a fraction, of the shape of the currents.
    temperature_degC : ndarray or None
        Of a cell that knows temperature, in degrees Celsius, of the shape of the currents.
    rows_outside_curve : int
        Rows whose state of charge lies outside the range that v_oc(A) was made for.
    """

    time_s: FloatArray
    current_A: FloatArray
    voltage_V: FloatArray
    soc: FloatArray
    rows_outside_curve: int
    cell: Cell = field(repr=False)
    temperature_degC: FloatArray | None = None

    @property
    def open_circuit_V(self) -> FloatArray:
        """Open-circuit voltage of the pack in V, at each row."""
        flat = self.cell._core.open_circuit_voltage(np.ascontiguousarray(self.soc.ravel()))
        return cast(FloatArray, flat.reshape(self.soc.shape))

    def to_pandas(self) -> pd.DataFrame:
        """Return the columns of one current as a data frame."""
        if self.current_A.ndim != 1:
            raise OptionError("to_pandas() is for one current; take a row of the arrays")
        return pd.DataFrame(
            {
                "time_s": self.time_s,
                "current_A": self.current_A,
                "voltage_V": self.voltage_V,
                "open_circuit_V": self.open_circuit_V,
                "soc": self.soc,
            }
        )

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw voltage and state of charge over time; return the axes."""
        return plots.simulation(self.time_s, self.voltage_V, self.soc, self.cell.name, axes)

    def __repr__(self) -> str:
        shape = " x ".join(str(n) for n in self.voltage_V.shape)
        return (
            f"Simulation({self.cell.name!r}: {shape} rows, {self.voltage_V.min():.4g} to "
            f"{self.voltage_V.max():.4g} V, soc down to {self.soc.min():.3g})"
        )


class Cell:
    """A lithium-polymer cell, or a pack of equal ones: diffusion, v_oc(A), resistances, branches.

    Make one by :func:`identify`, :meth:`Cell.read` or :meth:`Cell.from_dict`.

    Examples
    --------
    >>> import lipoid
    >>> cell = lipoid.Cell.read("gifi-600mAh-1")
    >>> cell
    Cell('gifi-600mAh-1': 0.6 Ah, r_s 131.4 mOhm, 1 branch, cut-off 3 V)
    >>> flown = cell.simulate([0.0, 60.0, 120.0], [0.0, 2.0, 2.0])
    >>> bool(flown.voltage_V[-1] < flown.voltage_V[0])
    True
    """

    _core: CoreCell

    @classmethod
    def _of(cls, core: CoreCell) -> Cell:
        cell = cls.__new__(cls)
        cell._core = core
        return cell

    @classmethod
    def read(cls, name_or_file: str | os.PathLike[str]) -> Cell:
        """Read a cell file, or take a cell that is shipped, by its name (:func:`cells`)."""
        return cls._of(_core.load_cell(name_or_file))

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Cell:
        """Make a cell of what :meth:`to_dict` returns: the keys of a cell file."""
        return cls._of(_core.parse_cell(json.dumps(data), "cell"))

    @property
    def name(self) -> str:
        """The name of the cell."""
        return self._core.name

    @property
    def series(self) -> int:
        """Cells in series."""
        return self._core.series

    @property
    def parallel(self) -> int:
        """Cells in parallel."""
        return self._core.parallel

    @property
    def capacity_Ah(self) -> float:
        """Nominal capacity of one cell in Ah."""
        return self._core.capacity_Ah

    @property
    def cutoff_V(self) -> float:
        """Voltage of one cell that ends a discharge, in V."""
        return self._core.cutoff_V

    @property
    def alpha_C(self) -> float:
        """Charge of one cell from full to empty at vanishing rate, in C."""
        return self._core.alpha_C

    def to_dict(self) -> dict[str, Any]:
        """Return the keys of a cell file."""
        return self._core.to_dict()

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write the cell file: whole, or not at all."""
        self._core.save(file)

    def pack(self, series: int = 1, parallel: int = 1) -> Cell:
        """Return so many of these cells in series and in parallel."""
        return Cell._of(self._core.pack(series, parallel))

    def with_typical_temperature(self) -> Cell:
        """Return the cell with typical temperature terms, where it has none of its own."""
        return (
            self
            if self._core.knows_temperature
            else Cell._of(self._core.with_typical_temperature())
        )

    def open_circuit_voltage(self, soc: npt.ArrayLike) -> FloatArray:
        """Voltage of the pack at rest in V, at states of charge (fractions) of any shape."""
        array = np.asarray(soc, dtype=np.float64)
        flat = self._core.open_circuit_voltage(np.ascontiguousarray(array.ravel()))
        return cast(FloatArray, flat.reshape(array.shape))

    def simulate(
        self,
        time_s: Any,
        current_A: Any = None,
        *,
        hold: Literal["backward", "forward"] = "backward",
        initial_soc: float = 1.0,
        initial_voltage_V: float | None = None,
        temperature_degC: Any = None,
        ambient_degC: float | None = None,
        threads: int = 0,
    ) -> Simulation:
        """Predict the voltage under a current, or under many at once on all cores.

        Parameters
        ----------
        time_s : array_like or Log
            Times in s, shape (rows,), or (currents, rows) where each current has its own; or a log,
            whose current flows.
        current_A : array_like
            Currents of the pack in A, discharge positive, shape (rows,) or (currents, rows).
        hold : {"backward", "forward"}
            Whether a row's current holds since the row before or until the next.
        initial_soc : float
            State of charge of the first row, where the cell is relaxed.
        initial_voltage_V : float, optional
            Instead: the voltage at which the pack rested before the first row, in V.
        temperature_degC : array_like, optional
            Measured at each row in degrees Celsius, shape (rows,) or (currents, rows); not given:
            that of the log, or the cell warms from the ambient. Only cells that know temperature
            look at it.
        ambient_degC : float, optional
            Temperature of the surroundings, where none was measured; not given: the reference of
            the cell.
        threads : int
            Cores to use; 0: all.

        Returns
        -------
        Simulation
            Arrays of the shape of the currents.
        """
        if isinstance(time_s, Log):
            hold = time_s.hold
            if temperature_degC is None and ambient_degC is None:
                temperature_degC = time_s.temperature_degC
            time_s, current_A = time_s.time_s, time_s.current_A
        elif current_A is None:
            raise OptionError("simulate: current_A is missing")
        if initial_voltage_V is not None:
            initial_soc = self._core.soc_at_rest(initial_voltage_V)
        self._check_soc(initial_soc)
        if np.ma.is_masked(current_A) or np.ma.is_masked(time_s):
            raise OptionError("simulate: expected numbers, found masked ones; leave their rows out")
        i = np.ascontiguousarray(current_A, dtype=np.float64)
        t = np.ascontiguousarray(time_s, dtype=np.float64)
        if i.ndim not in (1, 2) or t.shape not in (i.shape, i.shape[-1:]):
            raise OptionError(f"simulate: times {t.shape} do not go with currents {i.shape}")
        if i.size == 0:
            raise OptionError("simulate: expected at least one row, found none")
        if not bool(np.all(np.diff(t) > 0.0)):
            raise OptionError("simulate: expected times that increase")
        if not (np.isfinite(t).all() and np.isfinite(i).all()):
            raise OptionError("simulate: expected finite times and currents")
        measured = None
        if temperature_degC is not None:
            measured = np.ascontiguousarray(temperature_degC, dtype=np.float64)
            if measured.shape not in (i.shape, i.shape[-1:]) or not np.isfinite(measured).all():
                raise OptionError("simulate: expected a finite temperature for each row")
            if ambient_degC is not None:
                raise OptionError("simulate: give temperature_degC or ambient_degC, not both")
        if ambient_degC is not None and not -100.0 <= ambient_degC <= 150.0:
            raise OptionError("simulate: expected ambient_degC in degrees Celsius")
        if ambient_degC is not None and not self._core.knows_temperature:
            logger.warning(
                "%s knows no temperature: ambient_degC changes nothing; with typical values it is "
                "cell.with_typical_temperature()",
                self.name,
            )
        voltage_V, soc = np.empty_like(i), np.empty_like(i)
        warm = np.empty_like(i) if self._core.knows_temperature else None
        outside = self._core.simulate(
            np.atleast_2d(t),
            np.atleast_2d(i),
            np.atleast_2d(voltage_V),
            np.atleast_2d(soc),
            None if warm is None else np.atleast_2d(warm),
            hold,
            initial_soc,
            None if measured is None else np.atleast_2d(measured),
            ambient_degC,
            threads,
        )
        return Simulation(t, i, voltage_V, soc, outside, self, warm)

    @staticmethod
    def _check_soc(initial_soc: float) -> None:
        low, high = _core.initial_socs
        if not low <= initial_soc <= high:  # NaN neither
            raise OptionError(f"option initial_soc: expected {low} .. {high}, found {initial_soc}")

    def band(
        self,
        time_s: Any,
        current_A: Any,
        *,
        cells: int = 200,
        seed: int = 0,
        hold: Literal["backward", "forward"] = "backward",
        initial_soc: float = 1.0,
    ) -> tuple[FloatArray, FloatArray]:
        """Voltages in V between which 95 % of cells drawn from the covariance lie, row by row."""
        self._check_soc(initial_soc)
        t, i = column(time_s, "time_s"), column(current_A, "current_A")
        return self._core.band(t, i, hold, initial_soc, cells, seed)

    def resample(self, count: int, *, seed: int = 0) -> list[Cell]:
        """Draw cells from the covariance of the estimates, for ensembles.

        Cell ``k`` depends on the seed and on ``k`` alone.

        Raises
        ------
        OptionError
            Where the cell carries no uncertainty: it was not identified.
        """
        return [Cell._of(one) for one in self._core.resample(count, seed)]

    def to_pybamm(self, *, initial_soc: float = 1.0) -> interoperability.PybammCell:
        """Make PyBaMM's Thevenin model with diffusion element, and its parameter values.

        Parameters
        ----------
        initial_soc : float
            State of charge at the start. Of a pack PyBaMM gets one cell.
        """
        return interoperability.to_pybamm(self._core, initial_soc)

    def to_thevenin(self, *, branches: int = 2, mission: Log | None = None) -> Any:
        """Make a ``thevenin.Simulation`` with the circuit that follows the cell best.

        Parameters
        ----------
        branches : int
            Pairs of resistor and capacitor, 1 or 2. Of a pack thevenin gets one cell.
        mission : Log, optional
            What the circuit is fitted over; not given: two levels of current with rests.
        """
        over = core_of("mission", mission)
        return interoperability.to_thevenin(self._core, branches, over)

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw v_oc and the resistances over the state of charge; return the axes."""
        soc = np.linspace(0.0, 1.0, 501)
        drawn = self.open_circuit_voltage(soc)
        return plots.cell(soc, drawn, self._resistances(), self.name, axes)

    def _resistances(self) -> list[tuple[str, plots.Resistance]]:
        data = self.to_dict()
        named = [("r_s", data["series_resistance_Ohm"])]
        return named + [
            (f"r_{k}", one["resistance_Ohm"]) for k, one in enumerate(data["branches"], 1)
        ]

    def __getstate__(self) -> str:
        return self._core.to_json()

    def __setstate__(self, state: str) -> None:
        self._core = _core.parse_cell(state, "cell")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Cell) and self._core.to_json() == other._core.to_json()

    def __hash__(self) -> int:
        return hash(self._core.to_json())

    def __repr__(self) -> str:
        data = self.to_dict()
        r_s = data["series_resistance_Ohm"]
        shown = f"r_s {1e3 * r_s:.4g} mOhm" if isinstance(r_s, float) else "r_s over soc"
        branches = len(data["branches"])
        parts = [f"{self.capacity_Ah:g} Ah", shown, f"{branches} branch{'es' * (branches != 1)}"]
        parts.append(f"cut-off {self.cutoff_V:g} V")
        if (self.series, self.parallel) != (1, 1):
            parts.append(f"{self.series}S{self.parallel}P")
        return f"Cell({self.name!r}: {', '.join(parts)})"

    def _repr_html_(self) -> str:
        data = self.to_dict()
        rows = [("capacity", f"{self.capacity_Ah:g} Ah"), ("cut-off", f"{self.cutoff_V:g} V")]
        if data.get("diffusion"):
            rows.append(("alpha", f"{data['diffusion']['alpha_C']:.5g} C"))
            rows.append(("beta", f"{data['diffusion']['beta_per_sqrt_s']:.4g} s<sup>-1/2</sup>"))
        for name, value in self._resistances():
            if isinstance(value, Mapping):
                values = value["resistance_Ohm"]
                text = f"{1e3 * min(values):.4g} to {1e3 * max(values):.4g} mOhm over soc"
            else:
                text = f"{1e3 * value:.4g} mOhm"
            rows.append((name, text))
        body = "".join(f"<tr><th>{a}</th><td>{b}</td></tr>" for a, b in rows)
        return f"<b>{escape(self.name)}</b><table>{body}</table>"


def as_cell(cell: Cell | str | os.PathLike[str]) -> Cell:
    """Return a cell, or read the one of that name or file."""
    return cell if isinstance(cell, Cell) else Cell.read(cell)


def cells() -> list[str]:
    """Names of the cells that are shipped."""
    return _core.cell_names()
