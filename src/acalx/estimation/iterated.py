"""Iterated least squares: Gauss and Newton's steps on the residual itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from acalx.estimation.base import Estimator, Linearize
from acalx.estimation.losses import Loss, Squares
from acalx.estimation.residuals import Magnitude, Residual
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Iterated"]


@final
@dataclass(frozen=True)
class Iterated(Estimator):
    """Least squares of the whole residual, |inv(A) (W - bias)| - 1, not of its linear model.

    Right whatever the size of the errors is, and of the orientation it needs nothing. The first
    step from zero is that of `Linear`; three or four more reach rounding.

    Parameters
    ----------
    residual : Residual
    loss : Loss
    tolerance : float
        Steps end where they are smaller, in g, relative and rad.
    iterations : int
        Most steps.
    """

    residual: Residual = field(default_factory=Magnitude)
    loss: Loss = field(default_factory=Squares)
    tolerance: float = 1e-10
    iterations: int = 200

    def __post_init__(self) -> None:
        self.check_options()

    def linearization(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> Linearize:
        """The residual itself, and its derivatives, at whatever the parameters are."""

        def linearize(parameters: Array) -> tuple[Array, Array]:
            return self.residual.at(model, parameters, measurement, stimulus)

        return linearize
