"""Cells and campaigns in other programs: PyBaMM, thevenin, PyBOP.

The numbers and their stated error are those of ``lipoid export``; here the other program's own
objects are made of them, for :meth:`Cell.to_pybamm`, :meth:`Cell.to_thevenin` and
:meth:`Campaign.to_pybop`.
"""

from __future__ import annotations

import importlib
import importlib.util
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lipoid import _core
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from lipoid._core import Cell, Log


def _imported(package: str) -> Any:
    """Return another program's package, or say how it is installed."""
    try:
        return importlib.import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        message = f"to_{package}: it needs {package}, which is not installed; pip install {package}"
        raise ModuleNotFoundError(message, name=package) from error


def _load(name: str, file: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location(name, file)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@dataclass(frozen=True)
class PybammCell:
    """A cell in PyBaMM: the model Thevenin with its diffusion element.

    Attributes
    ----------
    model : pybamm.equivalent_circuit.Thevenin
        Without its events: "Maximum SoC" is zero in a full cell and would end a run at once.
    parameter_values : pybamm.ParameterValues
        Of one cell.
    var_pts : dict
        The mesh of the diffusion element.
    run : callable
        ``run(time_s, current_A, initial_soc=1.0)``: the voltage of the pack, backward hold.
    summary : dict
        How far PyBaMM's law is from the cell (``lipoid export``).
    """

    model: Any
    parameter_values: Any
    var_pts: dict[Any, int]
    run: Callable[..., npt.NDArray[np.float64]]
    summary: dict[str, Any]


def to_pybamm(cell: Cell, initial_soc: float) -> PybammCell:
    """Make PyBaMM's model and parameter values of a cell; of a pack, those of one cell."""
    pybamm = _imported("pybamm")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "cell_in_pybamm.py"
        summary, _ = _core.export(cell, "pybamm", file, {}, [])
        module = _load("cell_in_pybamm", file)
    values = pybamm.ParameterValues(module.get_parameter_values())
    values["Initial SoC"] = initial_soc
    return PybammCell(module.make_model(), values, module.var_pts(), module.run, summary)


def to_thevenin(cell: Cell, branches: int, mission: Any) -> tuple[Any, list[str]]:
    """Make a ``thevenin.Simulation`` of a cell, of a pack that of one cell, and warnings."""
    thevenin = _imported("thevenin")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "cell.yaml"
        _, warnings = _core.export(
            cell, "thevenin", file, {"branches": branches, "mission": mission}, []
        )
        return thevenin.Simulation(str(file)), warnings


def to_pybop(cell: Cell, log: Log, free: tuple[str, ...], spread: float) -> Any:
    """Make a PyBOP problem: a log, PyBaMM's Thevenin model of the cell, a sum of squares."""
    pybamm, pybop = _imported("pybamm"), _imported("pybop")
    if log.voltage_V is None:
        raise OptionError("to_pybop: expected a log with voltages")
    made = to_pybamm(cell, initial_soc=1.0)
    values = made.parameter_values
    for name in free:
        start = values[name]
        if not isinstance(start, (int, float)):
            raise OptionError(
                f"to_pybop: {name} is no constant in this cell; identify with constants"
            )
        prior = pybop.Gaussian(start, spread * start, truncated_at=[0.1 * start, 10.0 * start])
        values[name] = pybop.Parameter(distribution=prior, initial_value=start)
    data = pybop.Dataset(
        {
            "Time [s]": np.array(log.time_s),
            "Current [A]": np.array(log.current_A),
            "Voltage [V]": np.array(log.voltage_V),
        }
    )
    simulator = pybop.pybamm.Simulator(
        made.model,
        parameter_values=values,
        protocol=data,
        solver=pybamm.IDAKLUSolver(),
        var_pts=made.var_pts,
    )
    return pybop.Problem(simulator, pybop.SumSquaredError(data))
