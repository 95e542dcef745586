"""Optimizers: what searches for the best program."""

from acalx.optimizers.auto import Auto
from acalx.optimizers.base import Account, Optimizer, Result, Solution
from acalx.optimizers.de import DifferentialEvolution
from acalx.optimizers.exchange import Exchange
from acalx.optimizers.gradient import Gradient

__all__ = ["Account", "Auto", "DifferentialEvolution", "Exchange", "Gradient", "Optimizer", "Result", "Solution"]
