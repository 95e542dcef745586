"""Optimizers: what searches for the best program."""

from acalx.optimizers.auto import Auto
from acalx.optimizers.base import Account, Design, Optimizer, Result, Solution, Survey
from acalx.optimizers.convex import Convex
from acalx.optimizers.de import DifferentialEvolution
from acalx.optimizers.exchange import Exchange
from acalx.optimizers.gradient import Gradient
from acalx.optimizers.nsga2 import NSGA2
from acalx.optimizers.pareto import FrontPoint
from acalx.optimizers.scalarized import Scalarized
from acalx.optimizers.traversal import Traversal

__all__ = [
    "NSGA2",
    "Account",
    "Auto",
    "Convex",
    "Design",
    "DifferentialEvolution",
    "Exchange",
    "FrontPoint",
    "Gradient",
    "Optimizer",
    "Result",
    "Scalarized",
    "Solution",
    "Survey",
    "Traversal",
]
