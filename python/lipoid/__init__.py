"""Identify lithium-polymer cells from lab logs, and fly the result.

Discharge current is positive, every name carries its unit, a state of charge is a fraction.
"""

from lipoid import _core
from lipoid._aloft import Endurance, Health, endurance, health
from lipoid._campaign import Campaign
from lipoid._cell import Cell, Simulation, cells
from lipoid._identify import Identification, identify, validate
from lipoid._log import Log, read_log
from lipoid._more import (
    Comparison,
    Fleet,
    Flight,
    compare,
    export,
    fly,
    identify_many,
    maneuvers,
    optimizers,
    plan,
    study,
    synthesize,
    targets,
    vehicles,
)
from lipoid._report import report
from lipoid.errors import Diagnostic, LoadError, OptionError, PreconditionError

__version__: str = _core.version

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
