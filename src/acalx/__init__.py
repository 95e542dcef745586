"""acalx designs calibration programs for inertial sensors and says how good they are.

The names below are imported when they are first used, so that ``import acalx`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from acalx.criteria import A, Criterion, D, E, Inequality, Product
    from acalx.errors import AcalxError
    from acalx.information import Information, Parameter
    from acalx.metrics import figures_of_merit
    from acalx.models import Model, ScalarAccel
    from acalx.optimizers import Convex, DifferentialEvolution, Gradient, Optimizer, Result
    from acalx.problem import Problem
    from acalx.programs import Program, find_program, published, read_program
    from acalx.stands import Setting, Stand, TwoAxis
    from acalx.stimulus import Stimulus

__version__ = "0.1.0"

__all__ = [
    "A",
    "AcalxError",
    "Convex",
    "Criterion",
    "D",
    "DifferentialEvolution",
    "E",
    "Gradient",
    "Inequality",
    "Information",
    "Model",
    "Optimizer",
    "Parameter",
    "Problem",
    "Product",
    "Program",
    "Result",
    "ScalarAccel",
    "Setting",
    "Stand",
    "Stimulus",
    "TwoAxis",
    "figures_of_merit",
    "find_program",
    "published",
    "read_program",
]

_HOMES = {
    "acalx.criteria": ("A", "Criterion", "D", "E", "Inequality", "Product"),
    "acalx.errors": ("AcalxError",),
    "acalx.information": ("Information", "Parameter"),
    "acalx.metrics": ("figures_of_merit",),
    "acalx.models": ("Model", "ScalarAccel"),
    "acalx.optimizers": ("Convex", "DifferentialEvolution", "Gradient", "Optimizer", "Result"),
    "acalx.problem": ("Problem",),
    "acalx.programs": ("Program", "find_program", "published", "read_program"),
    "acalx.stands": ("Setting", "Stand", "TwoAxis"),
    "acalx.stimulus": ("Stimulus",),
}


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'acalx' has no attribute {name!r}")
