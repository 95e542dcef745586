"""Linear least squares."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

import numpy as np

from acalx.estimation.base import Estimator, Linearize
from acalx.estimation.losses import Loss, Squares
from acalx.models import Comparison, Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Linear"]


@final
@dataclass(frozen=True)
class Linear(Estimator):
    """X = inv(H'H) H'J with the rows h of errors that are zero.

    For the magnitude it leaves an error of second order in the parameters: with errors of 1e-4 some
    1e-8, with errors of 5 % some 1e-3. For outputs, and for the projection W . eta, it is exact.

    Parameters
    ----------
    comparison : Comparison, optional
        Instead of what the model compares.
    loss : Loss
    tolerance : float
        Steps of a robust loss end where they are smaller, in standard errors, or no more than rounding.
    iterations : int
        Most steps.

    Source: Egorov, Kiryachenko, Popov (2021).
    """

    comparison: Comparison | None = None
    loss: Loss = field(default_factory=Squares)
    tolerance: float = 1e-6
    iterations: int = 200

    def __post_init__(self) -> None:
        self.check_options()

    def linearization(self, model: Model, readings: Array, known: Stimulus | None) -> Linearize:
        """J - h X with rows h that stay those of a sensor without errors."""
        residual, rows = model.linearized(model.nominal, readings, known)

        def linearize(parameters: Array) -> tuple[Array, Array]:
            off = parameters - model.nominal
            explained = off @ rows.T if rows.ndim == 2 else np.einsum("tnp,tp->tn", rows, off)
            return residual - explained, rows

        return linearize
