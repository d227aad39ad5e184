"""Identify lithium-polymer cells from lab logs, and fly the result.

Discharge current is positive, every name carries its unit, a state of charge is a fraction.
"""

import atexit

from lipoid import _core
from lipoid._campaign import Campaign
from lipoid._cell import Cell, Simulation, cells
from lipoid._comparison import Comparison, compare, optimizers, study
from lipoid._endurance import Endurance, endurance
from lipoid._export import export, targets
from lipoid._flight import Flight, fly, maneuvers, vehicles
from lipoid._health import Health, health
from lipoid._identification import Identification, identify, validate
from lipoid._log import Log, read_log
from lipoid._many import Fleet, identify_many
from lipoid._planning import plan, synthesize
from lipoid._report import report
from lipoid.errors import Diagnostic, LoadError, OptionError, PreconditionError

__version__: str = _core.version

# Threads that still work when Python ends would end the process by an abort.
atexit.register(_core.end_work)

__all__ = [
    "Campaign",
    "Cell",
    "Comparison",
    "Diagnostic",
    "Endurance",
    "Fleet",
    "Flight",
    "Health",
    "Identification",
    "LoadError",
    "Log",
    "OptionError",
    "PreconditionError",
    "Simulation",
    "__version__",
    "cells",
    "compare",
    "endurance",
    "export",
    "fly",
    "health",
    "identify",
    "identify_many",
    "maneuvers",
    "optimizers",
    "plan",
    "read_log",
    "report",
    "study",
    "synthesize",
    "targets",
    "validate",
    "vehicles",
]
