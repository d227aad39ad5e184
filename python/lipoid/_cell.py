"""Cells: what identification finds and simulations start from."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias, cast

import numpy as np
import numpy.typing as npt
import pandas as pd

from lipoid import _core, interoperability, plots
from lipoid._files import inputs_of, output
from lipoid._keywords import present, whole, whole_seed
from lipoid._log import Log, column, mission_of
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lipoid._core import Cell as CoreCell

logger = logging.getLogger("lipoid")
FloatArray = npt.NDArray[np.float64]
_MOST_CELLS = 100_000  # that are drawn at once: some kilobytes each


@dataclass(frozen=True, eq=False, repr=False)
class Simulation:
    """The voltage of a cell under a current.

    From the row on in which the cell is below its cut-off, its arrays are NaN.

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
    _open_circuit_V: FloatArray | None = field(default=None, repr=False)

    @property
    def rows(self) -> int | npt.NDArray[np.int64]:
        """Rows before the one in which the cell is below its cut-off, of each current."""
        counted = np.isfinite(self.voltage_V).sum(axis=-1)
        return int(counted) if self.voltage_V.ndim == 1 else cast(npt.NDArray[np.int64], counted)

    @property
    def open_circuit_V(self) -> FloatArray:
        """Open-circuit voltage of the pack in V, at each row."""
        if self._open_circuit_V is not None:
            return self._open_circuit_V
        flat, _ = self.cell._core.open_circuit_voltage(np.ascontiguousarray(self.soc.ravel()))
        return np.array(flat).reshape(self.soc.shape)

    def to_pandas(self) -> pd.DataFrame:
        """Return the columns of one current as a data frame, of the rows before the cut-off."""
        if self.current_A.ndim != 1:
            raise OptionError("to_pandas() is for one current; take a row of the arrays")
        columns = {
            "time_s": self.time_s,
            "current_A": self.current_A,
            "voltage_V": self.voltage_V,
            "open_circuit_V": self.open_circuit_V,
            "soc": self.soc,
        }
        if self.temperature_degC is not None:
            columns["temperature_degC"] = self.temperature_degC
        return pd.DataFrame(columns).iloc[: self.rows]

    def plot(self, axes: Any = None) -> list[Axes]:
        """Draw voltage and state of charge over time; return the axes."""
        return plots.simulation(self.time_s, self.voltage_V, self.soc, self.cell.name, axes)

    def __repr__(self) -> str:
        shape = " x ".join(str(n) for n in self.voltage_V.shape)
        text = f"Simulation({self.cell.name!r}: {shape} row{'' if shape == '1' else 's'}"
        if before := int(np.sum(self.rows)):
            if before != self.voltage_V.size:
                text += f", {before} before the cut-off"
            text += f", {np.nanmin(self.voltage_V):.4g} to {np.nanmax(self.voltage_V):.4g} V"
            text += f", soc down to {np.nanmin(self.soc):.3g}"
        else:
            text += ", none before the cut-off"
        return text + ")"


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
    _file = ""  # that it was read from
    _drawn_from: tuple[str, ...] = ()  # files behind the cell that it was drawn from

    def __init__(self, *_given: Any, **_named: Any) -> None:
        raise TypeError(
            "Cell(...) makes no cell; use lipoid.Cell.read(NAME_OR_FILE), "
            "lipoid.Cell.from_dict(KEYS) or lipoid.identify(...).cell"
        )

    @classmethod
    def _of(cls, core: CoreCell, file: str = "", drawn_from: tuple[str, ...] = ()) -> Cell:
        cell = cls.__new__(cls)
        cell._core = core
        cell._file = file
        cell._drawn_from = drawn_from
        return cell

    @classmethod
    def read(cls, name_or_file: str | os.PathLike[str]) -> Cell:
        """Read a cell file, or take a cell that is shipped, by its name (:func:`cells`)."""
        wanted = "a path or the name of a shipped cell"
        path = present("name_or_file", name_or_file, wanted)
        cell = cls._of(_core.load_cell(path), os.path.abspath(os.fsdecode(path)))
        cell._tell(_core.doubt_about_fit(cell._core))
        return cell

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Cell:
        """Make a cell of what :meth:`to_dict` returns: the keys of a cell file."""
        cell = cls._of(_core.parse_cell(json.dumps(data, default=_plain), "cell"))
        cell._tell(_core.doubt_about_fit(cell._core))
        return cell

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
        """Write the cell file: whole, or not at all, and not over what the cell was found from."""
        self._core.save(output("file", file, self._inputs_of_run))

    @property
    def _inputs_of_run(self) -> list[str]:
        run = self.to_dict().get("run")
        of_run = inputs_of(run.get("inputs")) if isinstance(run, dict) else []
        return [*of_run, *self._drawn_from]

    @property
    def _inputs(self) -> list[str]:
        return [self._file, *self._inputs_of_run]

    def pack(self, series: int = 1, parallel: int = 1) -> Cell:
        """Return one of these cells so many times in series and in parallel.

        A pack is not multiplied: ``cell.pack(3).pack(2)`` is 2 in series, and ``pack()`` the cell.
        """
        core = self._core.pack({"series": series, "parallel": parallel})
        return Cell._of(core, self._file, self._drawn_from)

    def with_typical_temperature(self) -> Cell:
        """Return the cell with typical temperature terms, where it has none of its own."""
        return (
            self
            if self._core.knows_temperature
            else Cell._of(self._core.with_typical_temperature(), self._file, self._drawn_from)
        )

    def open_circuit_voltage(self, soc: npt.ArrayLike) -> FloatArray:
        """Voltage of the pack at rest in V, at states of charge (fractions) of any shape."""
        given = present("soc", soc, "states of charge")
        flat, doubt = self._core.open_circuit_voltage(column(np.ravel(given), "soc"))
        self._tell(doubt)
        return np.array(flat).reshape(np.shape(given))

    def simulate(
        self,
        time_s: Any,
        current_A: Any = None,
        *,
        hold: Literal["backward", "forward"] | None = None,
        initial_soc: float | None = None,
        initial_voltage_V: float | None = None,
        temperature_degC: Any = None,
        ambient_degC: float | None = None,
        initial_degC: float | None = None,
        beyond_cutoff: bool = False,
        threads: int = 0,
    ) -> Simulation:
        """Predict the voltage under a current, or under many at once on all cores.

        Parameters
        ----------
        time_s : array_like or Log
            Times in s, or dates, or durations, shape (rows,); times in s also of shape (currents,
            rows), where each current has its own; or a log, whose current flows.
        current_A : array_like
            Currents of the pack in A, discharge positive, shape (rows,) or (currents, rows).
        hold : {"backward", "forward"}
            Whether a row's current holds since the row before, the default, or until the next. A
            log says it itself.
        initial_soc : float
            State of charge of the first row, where the cell is relaxed; 1 where nothing is said.
        initial_voltage_V : float, optional
            Instead: the voltage at which the pack rested before the first row, in V.
        temperature_degC : array_like, optional
            Measured at each row in degrees Celsius, shape (rows,) or (currents, rows); not given:
            that of the log, or the cell warms from the ambient. Only cells that know temperature
            look at it.
        ambient_degC : float, optional
            Temperature of the surroundings, where none was measured; not given: the reference of
            the cell.
        initial_degC : float, optional
            Temperature of the cell at the first row, where none was measured; not given: that of
            the surroundings.
        beyond_cutoff : bool
            Predict all rows, also those below the cell's cut-off, where no cell would go on.
        threads : int
            Cores to use; 0: all.

        Returns
        -------
        Simulation
            Arrays of the shape of the currents; NaN from the row on in which the cell is below its
            cut-off, as a warning then says.
        """
        t, i, measured, options = self._driven(
            "simulate",
            time_s,
            current_A,
            hold,
            temperature_degC,
            ambient_degC,
            initial_degC,
            (1, 2),
        )
        options |= {"initial_soc": initial_soc, "initial_voltage_V": initial_voltage_V}
        options["beyond_cutoff"] = beyond_cutoff
        voltage_V, soc = np.full_like(i, np.nan), np.full_like(i, np.nan)
        rest_V = np.full_like(i, np.nan) if self._core.rests_beside_curve else None
        warm = np.full_like(i, np.nan) if self._core.knows_temperature else None
        outside, before, cutoff_s, doubts = self._core.simulate(
            np.atleast_2d(t),
            np.atleast_2d(i),
            np.atleast_2d(voltage_V),
            np.atleast_2d(soc),
            None if rest_V is None else np.atleast_2d(rest_V),
            None if warm is None else np.atleast_2d(warm),
            None if measured is None else np.atleast_2d(measured),
            options,
            whole("threads", threads),
        )
        self._tell_of_cutoff(np.atleast_2d(i), before, cutoff_s)
        self._tell(*doubts)
        # What the caller does to his arrays afterwards is not what flowed.
        return Simulation(np.array(t), np.array(i), voltage_V, soc, outside, self, warm, rest_V)

    def _tell_of_cutoff(
        self, current_A: FloatArray, before: list[int], cutoff_s: list[float]
    ) -> None:
        count, rows = current_A.shape
        below = [k for k, n in enumerate(before) if n < rows]
        if not below:
            return
        k = below[0]
        n = before[k]
        kept = f"the {n} of {rows} rows above it, within {5 * self.series} mV, were predicted"
        self._tell(
            f"the cell reaches its cut-off of {self.series * self.cutoff_V:.4g} V"
            + (f" under {len(below)} of {count} currents; current {k}" if count > 1 else "")
            + f" at {round(cutoff_s[k], 2):.10g} s under {current_A[k, n]:.4g} A: {kept}"
            + ", the others are NaN (beyond_cutoff=True predicts all)"
        )

    def band(
        self,
        time_s: Any,
        current_A: Any = None,
        *,
        cells: int = 200,
        seed: int = 0,
        hold: Literal["backward", "forward"] | None = None,
        initial_soc: float | None = None,
        initial_voltage_V: float | None = None,
        temperature_degC: Any = None,
        ambient_degC: float | None = None,
        initial_degC: float | None = None,
        beyond_cutoff: bool = False,
    ) -> tuple[FloatArray, FloatArray]:
        """Voltages in V between which 95 % of cells drawn from the covariance lie, row by row.

        NaN from the row on in which this cell is below its cut-off, as a warning then says.

        Parameters
        ----------
        cells : int
            How many are drawn.
        seed : int
            Of what is drawn.
        time_s, current_A, hold, initial_soc, initial_voltage_V, temperature_degC, ambient_degC, \
        initial_degC, beyond_cutoff
            As in :meth:`simulate`, of one current.

        Raises
        ------
        OptionError
            Where the cell carries no uncertainty: it was not identified.
        """
        t, i, measured, options = self._driven(
            "band", time_s, current_A, hold, temperature_degC, ambient_degC, initial_degC, (1,)
        )
        options |= {"initial_soc": initial_soc, "initial_voltage_V": initial_voltage_V}
        options["beyond_cutoff"] = beyond_cutoff
        count = whole("cells", cells, least=2, most=_MOST_CELLS)
        low_V, high_V, before, cutoff_s, of_curve, *of_draws = self._core.band(
            t, i, measured, options, count, whole_seed(seed)
        )
        self._tell_of_cutoff(np.atleast_2d(i), [before], [cutoff_s])
        self._tell(*of_curve, *of_draws)
        return np.array(low_V), np.array(high_V)

    def _driven(
        self,
        what: str,
        time_s: Any,
        current_A: Any,
        hold: str | None,
        temperature_degC: Any,
        ambient_degC: float | None,
        initial_degC: float | None,
        dimensions: tuple[int, ...],
    ) -> tuple[FloatArray, FloatArray, FloatArray | None, dict[str, Any]]:
        """Return times, currents and measured temperatures that go together, and options."""
        for name, said in (("ambient_degC", ambient_degC), ("initial_degC", initial_degC)):
            if temperature_degC is not None and said is not None:
                raise OptionError(f"{what}: give temperature_degC or {name}, not both")
        if isinstance(time_s, Log):
            if current_A is not None or hold is not None:
                given = "current_A" if current_A is not None else "hold"
                raise OptionError(
                    f"{what}: the log says its {'current' if given == 'current_A' else 'hold'}; "
                    f"leave {given} out, or give the columns one by one"
                )
            hold = time_s.hold
            if temperature_degC is None:
                temperature_degC = time_s.temperature_degC
            time_s, current_A = time_s.time_s, time_s.current_A
        elif isinstance(time_s, Mapping) or hasattr(time_s, "columns"):
            found = type(time_s).__name__
            raise OptionError(
                f"{what}: expected times or a Log, found a {found}; lipoid.Log(...) makes one"
            )
        elif isinstance(time_s, (str, os.PathLike)):
            raise OptionError(
                f"{what}: expected times or a Log, found {str(time_s)!r:.200}; a file is read by "
                "lipoid.read_log(file)"
            )
        elif current_A is None:
            raise OptionError(f"{what}: current_A is missing")
        i = column(current_A, "current_A", dimensions)
        t = column(time_s, "time_s", dimensions)
        if t.shape not in (i.shape, i.shape[-1:]):
            raise OptionError(f"{what}: times {t.shape} do not go with currents {i.shape}")
        if i.size == 0:
            raise OptionError(f"{what}: expected at least one row, found none")
        if not bool(np.all(np.diff(t) > 0.0)):
            raise OptionError(f"{what}: expected times that increase")
        if not (np.isfinite(t).all() and np.isfinite(i).all()):
            raise OptionError(f"{what}: expected finite times and currents")
        measured = None
        if temperature_degC is not None:
            measured = column(temperature_degC, "temperature_degC", dimensions)
            if measured.shape not in (i.shape, i.shape[-1:]) or not np.isfinite(measured).all():
                raise OptionError(f"{what}: expected a finite temperature for each row")
            if wrong := _core.impossible_temperature(np.atleast_2d(t), np.atleast_2d(measured)):
                raise OptionError(f"{what}: temperature_degC: {wrong}")
        self._tell_what_says_nothing(ambient_degC, initial_degC)
        if measured is not None:
            self._tell(self._in_place_of(ambient_degC, initial_degC))
            ambient_degC = initial_degC = None
        for felt in (measured, ambient_degC, initial_degC):
            if felt is not None:
                lowest, highest = float(np.min(felt)), float(np.max(felt))
                self._tell(_core.doubt_about_temperature(self._core, lowest, highest))
        among = {"ambient_degC": ambient_degC, "initial_degC": initial_degC}
        return t, i, measured, {"hold": hold, **among}

    def _tell(self, *doubts: str) -> None:
        for doubt in doubts:
            if doubt:
                logger.warning("%s: %s", self.name, doubt)

    def _tell_what_says_nothing(
        self, ambient_degC: float | None, initial_degC: float | None
    ) -> None:
        said = _said(ambient_degC, initial_degC)
        if said and not self._core.knows_temperature:
            logger.warning(
                "%s knows no temperature: %s changes nothing; with typical values it is "
                "cell.with_typical_temperature()",
                self.name,
                said,
            )

    def _in_place_of(self, ambient_degC: float | None, initial_degC: float | None) -> str:
        """Say what a log's own temperature replaces, "" where nothing."""
        said = _said(ambient_degC, initial_degC)
        if not said or not self._core.knows_temperature:
            return ""
        return f"the log has temperature_degC, which is used in place of {said}"

    def _tell_what_is_assumed(self, options: Mapping[str, Any], size_factor: float = 1.0) -> None:
        if options.get("ambient_degC") is None:
            return
        if text := _core.typical_temperature_text(self._core, size_factor):
            logger.warning("%s %s", self.name, text)

    def resample(self, count: int, *, seed: int = 0) -> list[Cell]:
        """Draw cells from the covariance of the estimates, for ensembles.

        Cell ``k`` depends on the seed and on ``k`` alone.

        Raises
        ------
        OptionError
            Where the cell carries no uncertainty: it was not identified.
        """
        several = whole("count", count, most=_MOST_CELLS)
        drawn, doubt = self._core.resample(several, whole_seed(seed))
        self._tell(doubt)
        return [Cell._of(one, drawn_from=tuple(self._inputs)) for one in drawn]

    def to_pybamm(self, *, initial_soc: float = 1.0) -> interoperability.PybammCell:
        """Make PyBaMM's Thevenin model with diffusion element, and its parameter values.

        Parameters
        ----------
        initial_soc : float
            State of charge at the start. Of a pack PyBaMM gets one cell.
        """
        return interoperability.to_pybamm(self._core, initial_soc)

    def to_thevenin(
        self, *, branches: int = 2, mission: Log | str | os.PathLike[str] | None = None
    ) -> Any:
        """Make a ``thevenin.Simulation`` with the circuit that follows the cell best.

        Parameters
        ----------
        branches : int
            Pairs of resistor and capacitor, 1 or 2. Of a pack thevenin gets one cell.
        mission : Log or path, optional
            What the circuit is fitted over; not given: two levels of current with rests.
        """
        made, warnings = interoperability.to_thevenin(self._core, branches, mission_of(mission))
        self._tell(*warnings)
        return made

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

    def __getstate__(self) -> tuple[str, str, tuple[str, ...]]:
        return self._core.to_json(), self._file, self._drawn_from

    def __setstate__(self, state: tuple[str, str, tuple[str, ...]]) -> None:
        text, self._file, self._drawn_from = state
        self._core = _core.parse_cell(text, "cell")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Cell) and self._itself() == other._itself()

    def __hash__(self) -> int:
        return hash(self._itself())

    def _itself(self) -> str:
        """Return the keys of the cell file without the run that made it, as text."""
        return json.dumps({key: of for key, of in self.to_dict().items() if key != "run"})

    def __repr__(self) -> str:
        data = self.to_dict()
        r_s = data["series_resistance_Ohm"]
        shown = f"r_s {1e3 * r_s:.4g} mOhm" if isinstance(r_s, float) else "r_s over soc"
        branches = len(data["branches"])
        parts = [f"{self.capacity_Ah:g} Ah", shown, f"{branches} branch{'es' * (branches != 1)}"]
        parts.append(f"cut-off {self.cutoff_V:g} V")
        if (self.series, self.parallel) != (1, 1):
            parts.append(f"{self.series}S{self.parallel}P")
        if self._core.knows_temperature:
            parts.append("knows temperature")
        return f"Cell({self.name!r}: {', '.join(parts)})"

    def _repr_html_(self) -> str:
        data = self.to_dict()
        rows = [("capacity", f"{self.capacity_Ah:g} Ah"), ("cut-off", f"{self.cutoff_V:g} V")]
        if (self.series, self.parallel) != (1, 1):
            rows.insert(0, ("pack", f"{self.series} in series, {self.parallel} in parallel"))
        if self._core.knows_temperature:
            rows.append(("temperature", _known(data["temperature"])))
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


def _said(ambient_degC: float | None, initial_degC: float | None) -> str:
    """Name the keyword that says how warm it is; "": none."""
    if ambient_degC is not None:
        return "ambient_degC"
    return "" if initial_degC is None else "initial_degC"


def _known(temperature: Mapping[str, Any]) -> str:
    """Return how a cell knows temperature."""
    if temperature.get("assumed"):
        return "known, by typical values"
    seen_degC = temperature.get("seen_degC")
    return "known, seen from {:.4g} to {:.4g} degC".format(*seen_degC) if seen_degC else "known"


def _plain(value: Any) -> Any:
    """Return numbers and arrays of NumPy as those of JSON."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"Cell.from_dict: expected numbers, texts and lists of them, found {value!r}")


class HasCell(Protocol):
    """What stands for the cell that it found: an :class:`Identification`."""

    @property
    def cell(self) -> Cell:
        """The cell."""
        ...


OneCell: TypeAlias = "Cell | HasCell | str | os.PathLike[str]"


def as_cell(cell: OneCell) -> Cell:
    """Return a cell, that of an identification, or read the one of that name or file."""
    if isinstance(cell, Cell):
        return cell
    found = getattr(cell, "cell", None)
    if isinstance(found, Cell):
        return found
    wanted = "a Cell, a path or the name of a shipped cell"
    return Cell.read(cast("str | os.PathLike[str]", present("cell", cell, wanted)))


def cells() -> list[str]:
    """Names of the cells that are shipped."""
    return _core.cell_names()
