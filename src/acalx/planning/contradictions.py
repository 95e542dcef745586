"""Whether programs have the losses that a search says they have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.search.result import Found, Front, Result

__all__ = ["contradiction"]

# Losses of a program and of the same program in another order, or read from its file, differ by less: sums and digits.
_SAME = 1e-6
# Of rounding errors, in units of the condition number times the precision of a double.
_ROUNDING = 100.0


def contradiction(problem: Problem, result: Found, settings: Array) -> str:
    """How the loss of a program, looked at anew, contradicts the search; nothing where none does.

    Parameters
    ----------
    problem : Problem
    result : Result or Front
        All its programs are looked at.
    settings : array (n, d), in rad
        The one to take, as it is given: in another order, or read from a file.
    """
    (_, first), *others = _told(result)
    told = [(settings, first), *others]
    for (program, losses), again in zip(told, _again(problem, [program for program, _ in told]), strict=True):
        excess = np.nan_to_num(np.abs(again - losses) - _SAME * (1.0 + np.abs(losses)), nan=np.inf).max()
        if excess > 0.0 and excess > _ROUNDING * np.finfo(float).eps * _condition(problem, program):
            of_program, of_search = (", ".join(f"{loss:.9g}" for loss in each) for each in (again, losses))
            return (
                f"a program has the loss {of_program}, but the search found {of_search}: does model "
                f"{problem.model.called} or stand {type(problem.stand).__name__} depend on the order of the "
                "positions, or on more than their settings, or is the optimizer wrong?"
            )
    return ""


def _told(result: Found) -> list[tuple[Array, Array]]:
    """Programs with the losses that the search says they have, (k,) of k objectives; the one to take first."""
    if isinstance(result, Front):
        knee, points = result.points[result.knee], result.points
        return [(point.settings, point.losses) for point in (knee, *points)]
    assert isinstance(result, Result)  # a search has found programs or a front
    return [(solution.settings, np.array([solution.loss])) for solution in result.solutions]


def _again(problem: Problem, programs: Sequence[Array]) -> Array:
    """Losses of programs (s, k) by each of k objectives, in one call where they have as many positions."""
    alike = len({len(program) for program in programs}) == 1
    stacks = [np.stack(programs)] if alike else [program[None] for program in programs]
    each = [np.stack([single.objective.loss(stack) for single in problem.singles], axis=-1) for stack in stacks]
    return np.concatenate(each)


def _condition(problem: Problem, program: Array) -> float:
    """Condition number of the information of a program, whatever the units of the parameters."""
    matrix = problem.information(program).matrix
    root = np.sqrt(np.maximum(matrix.diagonal(), np.finfo(float).tiny))
    values = np.linalg.eigvalsh(matrix / np.outer(root, root))
    return float(values[-1] / max(float(values[0]), np.finfo(float).eps))
