"""How far from the best possible a program is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.bounds.bound import Bound, bound
from acalx.errors import ArgumentError, CompatibilityError, NoProgramError
from acalx.numerics.arrays import Array
from acalx.options import require_part
from acalx.problem import Problem
from acalx.quantities.magnitude import double_of, from_log, written_from_log

__all__ = ["Certificate", "certify"]

# The efficiency from which a program counts as proved optimal is one less this.
_OPTIMAL = 1e-6
# Bounds are rounded down by less: a loss so far below one shows that it is none.
_REFUTED = 1e-7
# The same of a program that is beyond its limits by a few digits.
_BEYOND = 1e-3
# A position within this of a limit, in rad, is on it: limits are printed with a few digits.
_TOLERANCE = 1e-6


@final
@dataclass(frozen=True)
class Certificate:
    """A program beside the bound that no program of as many positions can beat.

    Parameters
    ----------
    loss : float
        Of the program.
    bound : Bound or None
        None where there is none.
    reason : str
        Why there is none.
    """

    loss: float
    bound: Bound | None
    reason: str = ""

    @property
    def gap(self) -> float | None:
        """Loss of the program less that of the bound."""
        return None if self.bound is None else self.loss - self.bound.loss

    @property
    def efficiency(self) -> float | None:
        """Of the program, 0 to 1, on the scale of a variance: (bound / value) to the power 1 / degree."""
        if self.bound is None or not self.bound.scale:
            return None
        return from_log((self.bound.loss - self.loss) / self.bound.scale)

    @property
    def optimal(self) -> bool:
        """Whether the program is proved optimal, to an efficiency of 1 - 1e-6."""
        efficiency = self.efficiency
        if self.bound is None or efficiency is None or not self.bound.proved:
            return False
        return abs(efficiency - 1.0) <= _OPTIMAL

    def entries(self) -> dict[str, Any]:
        """As it is written to result.json: values of the criterion, and their logarithms beside them."""
        if self.bound is None:
            return {"bound": None, "efficiency": None, "gap": None, "method": self.reason, "proved": False}
        return {
            "bound": double_of(self.bound.loss),
            "log_bound": self.bound.loss,
            "efficiency": self.efficiency,
            "gap": self.gap,
            "method": self.bound.method,
            "status": self.bound.status,
            "margin": self.bound.margin,
            "proved": self.optimal,
            "optimal": self.optimal,
            "parts": {name: double_of(loss) for name, loss in self.bound.parts.items()},
            "log_parts": dict(self.bound.parts),
        }

    def __str__(self) -> str:
        if self.bound is None:
            return f"no bound: {self.reason}"
        least, efficiency = written_from_log(self.bound.loss), self.efficiency
        sure = "" if self.bound.proved else ", computed but not proved"
        if efficiency is None:
            return f"no program of as many positions gets the criterion below {least} ({self.bound.method})"
        if self.optimal:
            return f"proved optimal: no program of as many positions is better (efficiency {efficiency:.6f})"
        return (
            f"efficiency {efficiency:.5f}: the criterion is {written_from_log(self.loss)} here, "
            f"and no program of as many positions gets it below {least}{sure}"
        )


def require_program(problem: Problem, program: Array) -> None:
    """Raise ArgumentError unless a program is one of the problem's, which its bound holds for."""
    shape, given = (problem.n, problem.d), np.shape(program)
    if given != shape or not np.isfinite(program).all():
        raise ArgumentError(f"program: finite settings of shape {shape} are expected, in rad; got shape {given}")
    free = program[problem.held :]
    wrong = np.flatnonzero(~problem.stand.axes.allows(free, _TOLERANCE)) + problem.held + 1
    if len(wrong):
        raise ArgumentError(f"program: the stand can't take position {', '.join(map(str, wrong))}")
    if problem.fixed is not None and not np.allclose(program[: problem.held], problem.fixed, atol=_TOLERANCE):
        raise ArgumentError(f"program: the first {problem.held} positions must be the fixed ones")
    if problem.restrictions.active and not problem.restrictions.permits(program):
        raise ArgumentError("program: it has positions that the problem does not permit, or repeats some")


def certify(problem: Problem, program: Array) -> Certificate:
    """Bound what any program of a problem could reach, and compare one with it.

    Parameters
    ----------
    problem : Problem
        With one criterion.
    program : array (n, d), in rad

    Returns
    -------
    Certificate
        Without a bound, and with the reason, where there is none, or where the program refutes it.

    Raises
    ------
    ArgumentError
        A program that is none of the problem's: another number of positions, positions that its
        stand can't take, or other fixed ones.
    CompatibilityError
        Several objectives, which have no single loss.
    """
    require_part("problem", problem, Problem)
    program = np.asarray(program, dtype=float)
    require_program(problem, program)
    loss = float(problem.objective.loss(program))
    try:
        found = bound(problem)
        within = bool(problem.stand.axes.allows(program[problem.held :]).all())
        if loss < found.loss - (_REFUTED if within else _BEYOND) * (1.0 + abs(loss)):
            return Certificate(loss, None, _refuted(problem, loss, found))
        return Certificate(loss, found)
    except (CompatibilityError, NoProgramError, np.linalg.LinAlgError) as error:
        return Certificate(loss, None, str(error))


def _refuted(problem: Problem, loss: float, found: Bound) -> str:
    """What is to be said where a program is better than any can be."""
    parts = (problem.criterion, problem.model, problem.stand)
    criterion, model, stand = (type(part).__name__ for part in parts)
    return (
        f"the program's loss of {loss:.9g} refutes that none is below {found.loss:.9g}, which would follow from what "
        f"criterion {criterion}, model {model} and stand {stand} say of themselves: is the degree of one of them "
        "wrong, or the support of the criterion?"
    )
