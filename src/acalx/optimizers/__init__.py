"""Optimizers: what searches for the best program."""

from acalx.optimizers.base import Account, Design, Optimizer, Result, Solution
from acalx.optimizers.convex import Convex
from acalx.optimizers.de import DifferentialEvolution
from acalx.optimizers.gradient import Gradient

__all__ = ["Account", "Convex", "Design", "DifferentialEvolution", "Gradient", "Optimizer", "Result", "Solution"]
