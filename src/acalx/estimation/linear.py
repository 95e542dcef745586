"""Linear least squares."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

import numpy as np

from acalx.estimation.base import Estimator, Linearize
from acalx.estimation.losses import Loss, Squares
from acalx.estimation.residuals import Magnitude, Residual
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Linear"]


@final
@dataclass(frozen=True)
class Linear(Estimator):
    """X = inv(H'H) H'J with the rows h of errors that are zero.

    For the magnitude it leaves an error of second order in the parameters: with errors of 1e-4 some
    1e-8, with errors of 5 % some 1e-3. For the residual W . eta it is exact.

    Parameters
    ----------
    residual : Residual
    loss : Loss
    tolerance : float
        Steps of a robust loss end where they are smaller, in g, relative and rad.
    iterations : int
        Most steps.

    Source: Egorov, Kiryachenko, Popov (2021).
    """

    residual: Residual = field(default_factory=Magnitude)
    loss: Loss = field(default_factory=Squares)
    tolerance: float = 1e-10
    iterations: int = 200

    def __post_init__(self) -> None:
        self.check_options()

    def linearization(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> Linearize:
        """J - h X with rows h that stay those of errors that are zero."""
        residual, rows = self.residual.linearized(model, measurement, stimulus)

        def linearize(parameters: Array) -> tuple[Array, Array]:
            shared = rows.ndim == 2
            explained = parameters @ rows.T if shared else np.einsum("tnp,tp->tn", rows, parameters)
            return residual - explained, rows

        return linearize
