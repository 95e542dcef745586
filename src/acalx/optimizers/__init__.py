"""Optimizers: what searches for the best program."""

from acalx.optimizers.base import Account, Optimizer, Result, Solution
from acalx.optimizers.de import DifferentialEvolution
from acalx.optimizers.gradient import Gradient
from acalx.optimizers.nsga2 import NSGA2
from acalx.optimizers.pareto import FrontPoint
from acalx.optimizers.scalarized import Scalarized

__all__ = [
    "NSGA2",
    "Account",
    "DifferentialEvolution",
    "FrontPoint",
    "Gradient",
    "Optimizer",
    "Result",
    "Scalarized",
    "Solution",
]
