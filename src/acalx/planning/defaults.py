"""Which optimizer suits a problem, and how many positions a model, where none are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from acalx import optimizers
from acalx.models import Model
from acalx.optimizers import Optimizer
from acalx.problem import Problem

__all__ = ["default_optimizer", "suited", "usual_n"]


def suited(*, several: bool, stepped: bool) -> str:
    """The optimizer for several objectives or one criterion, on a stand with steps or without: its option's name."""
    if several:
        return "scalarized"
    return "exchange" if stepped else "de"


def usual_n(model: Model) -> int:
    """So many positions as the model says, or six residuals more than it has parameters."""
    said = model.usual.get("n")
    if said is not None:
        return int(said)
    count = len(model.parameters)
    return max(-(-(count + 6) // model.outputs), model.smallest_n)


def default_optimizer(problem: Problem) -> Optimizer[Any]:
    """The optimizer that `suited` names for a problem, with its default options; the others are not imported."""
    made: dict[str, Callable[[], Optimizer[Any]]] = {
        "scalarized": lambda: optimizers.Scalarized(),
        "exchange": lambda: optimizers.Exchange(),
        "de": lambda: optimizers.DifferentialEvolution(),
    }
    return made[suited(several=len(problem.singles) > 1, stepped=problem.stand.axes.stepped)]()
