"""Iterated least squares: Gauss and Newton's steps on the residual itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from acalx.estimation.base import Estimator, Linearize
from acalx.estimation.losses import Loss, Squares
from acalx.models import Comparison, Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Iterated"]


@final
@dataclass(frozen=True)
class Iterated(Estimator):
    """Least squares of the whole residual, as |inv(A) (W - bias)| - 1 of a magnitude, not of its linear model.

    Right whatever the size of the errors is. The first step from a sensor without errors is that of `Linear`;
    three or four more reach rounding.

    Parameters
    ----------
    comparison : Comparison, optional
        Instead of what the model compares.
    loss : Loss
    tolerance : float
        Steps end where they are smaller, in standard errors, or no more than rounding.
    iterations : int
        Most steps.
    """

    comparison: Comparison | None = None
    loss: Loss = field(default_factory=Squares)
    tolerance: float = 1e-6
    iterations: int = 200

    def __post_init__(self) -> None:
        self.check_options()

    def linearization(self, model: Model, readings: Array, known: Stimulus | None) -> Linearize:
        """The residual itself, and its derivatives, at whatever the parameters are."""

        def linearize(parameters: Array) -> tuple[Array, Array]:
            return model.residual(parameters, readings, known)

        return linearize
