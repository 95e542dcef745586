"""Which optimizer suits a problem where none is asked for."""

from __future__ import annotations

from typing import Any

from acalx.optimizers import DifferentialEvolution, Exchange, Optimizer, Scalarized
from acalx.problem import Problem

__all__ = ["default_optimizer", "suited"]


def suited(*, several: bool, stepped: bool) -> str:
    """The optimizer for several objectives or one criterion, on a stand with steps or without: its option's name."""
    if several:
        return "scalarized"
    return "exchange" if stepped else "de"


def default_optimizer(problem: Problem) -> Optimizer[Any]:
    """The optimizer that `suited` names, with its default options."""
    kinds: dict[str, type[Optimizer[Any]]] = {
        "scalarized": Scalarized,
        "exchange": Exchange,
        "de": DifferentialEvolution,
    }
    return kinds[suited(several=len(problem.singles) > 1, stepped=problem.stand.axes.stepped)]()
