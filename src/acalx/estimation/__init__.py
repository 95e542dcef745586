"""From measurements to a calibrated sensor."""

from acalx.estimation.base import Estimate, Estimator
from acalx.estimation.iterated import Iterated
from acalx.estimation.linear import Linear
from acalx.estimation.losses import Bisquare, Huber, Loss, Squares
from acalx.estimation.residuals import Magnitude, Oriented, Residual

__all__ = [
    "Bisquare",
    "Estimate",
    "Estimator",
    "Huber",
    "Iterated",
    "Linear",
    "Loss",
    "Magnitude",
    "Oriented",
    "Residual",
    "Squares",
]
