"""Which optimizer suits a problem where none is asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from acalx import optimizers
from acalx.optimizers import Optimizer
from acalx.problem import Problem

__all__ = ["default_optimizer", "suited"]


def suited(*, several: bool, stepped: bool) -> str:
    """The optimizer for several objectives or one criterion, on a stand with steps or without: its option's name."""
    if several:
        return "scalarized"
    return "exchange" if stepped else "de"


def default_optimizer(problem: Problem) -> Optimizer[Any]:
    """The optimizer that `suited` names for a problem, with its default options; the others are not imported."""
    made: dict[str, Callable[[], Optimizer[Any]]] = {
        "scalarized": lambda: optimizers.Scalarized(),
        "exchange": lambda: optimizers.Exchange(),
        "de": lambda: optimizers.DifferentialEvolution(),
    }
    return made[suited(several=len(problem.singles) > 1, stepped=problem.stand.axes.stepped)]()
