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
    """The optimizer that suits a problem, with the options that its model names; the others are not imported.

    With one criterion, on a stand without steps, that is what the model says; otherwise what `suited` names.
    """
    made: dict[str, Callable[..., Optimizer[Any]]] = {
        "scalarized": lambda: optimizers.Scalarized(),
        "exchange": lambda: optimizers.Exchange(),
        "de": lambda **options: optimizers.DifferentialEvolution(**options),
        "gradient": lambda **options: optimizers.Gradient(**options),
    }
    several, stepped, usual = len(problem.singles) > 1, problem.stand.axes.stepped, problem.model.usual
    said = usual.get("optimizer")
    if several or stepped or said not in made:
        return made[suited(several=several, stepped=stepped)]()
    return made[said](**{key.partition(".")[2]: value for key, value in usual.items() if key.startswith("optimizer.")})
