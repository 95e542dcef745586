"""Optimizers: what searches for the best program."""

from acalx.optimizers.base import Account, Optimizer, Result, Solution
from acalx.optimizers.de import DifferentialEvolution
from acalx.optimizers.gradient import Gradient

__all__ = ["Account", "DifferentialEvolution", "Gradient", "Optimizer", "Result", "Solution"]
