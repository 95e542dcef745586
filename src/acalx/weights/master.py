"""What finds the best weights of a few positions at a time, for the search over all candidates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

from acalx.criteria import Ceiling, Concave
from acalx.errors import CompatibilityError
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.weights.interior import Balance, balance
from acalx.weights.semidefinite import balance_semidefinite

__all__ = ["Master", "Newton", "Semidefinite", "newton_fits", "newton_master"]


class Master(Protocol):
    """Optimal weights of a few positions; `Newton`, `Semidefinite` and `acalx.weights.conic.Conic` are some."""

    def __call__(self, rows: Array, base: Array, tolerance: float) -> Balance:
        """Weights of positions with regressors (k, m, p) beside the information (p, p) that is there already.

        Parameters
        ----------
        rows : array (k, m, p)
        base : array (p, p)
            In units of one measurement of weight 1.
        tolerance : float
            The gap that is wanted; the answer says the one that was reached.
        """


@final
@dataclass(frozen=True)
class Newton:
    """Newton steps from the interior of the simplex, for smooth criteria.

    Parameters
    ----------
    criterion : Concave
    parameters : tuple of Parameter, length p
    """

    criterion: Concave
    parameters: tuple[Parameter, ...]

    def __call__(self, rows: Array, base: Array, tolerance: float) -> Balance:
        """Weights as `acalx.weights.interior` finds them."""
        return balance(rows, self.parameters, self.criterion, base=base, tolerance=tolerance)


@final
@dataclass(frozen=True, eq=False)
class Semidefinite:
    """The same for a criterion that is a matrix inequality.

    Parameters
    ----------
    criterion : Concave
    parameters : tuple of Parameter, length p
    inequality : array (p, p)
        Its matrix C; the value is the least t with C <= t M.
    """

    criterion: Concave
    parameters: tuple[Parameter, ...]
    inequality: Array

    def __call__(self, rows: Array, base: Array, tolerance: float) -> Balance:
        """Weights as `acalx.weights.semidefinite` finds them."""
        return balance_semidefinite(
            rows, self.parameters, self.criterion, self.inequality, base=base, tolerance=tolerance
        )


def newton_fits(criterion: Concave, p: int) -> bool:
    """Whether Newton's method on the weights can do without another master for p parameters."""
    if not isinstance(criterion, Ceiling):
        return True
    return criterion.inequality_matrix(p) is not None or criterion.smoothed() is not None


def newton_master(criterion: Concave, parameters: tuple[Parameter, ...]) -> Master:
    """Newton's method, of the kind that the criterion admits.

    Raises
    ------
    CompatibilityError
        A criterion with kinks that gives neither a matrix inequality nor a smooth one in its place.
    """
    if not isinstance(criterion, Ceiling):
        return Newton(criterion, parameters)
    inequality = criterion.inequality_matrix(len(parameters))
    if inequality is not None:
        return Semidefinite(criterion, parameters, inequality)
    smooth = criterion.smoothed()
    if smooth is not None:
        return Newton(smooth, parameters)
    raise CompatibilityError(
        f"Newton's method on the weights needs a smooth criterion or a matrix inequality, and {criterion.label} "
        "is neither; D, A and E are one of them each"
    )
