"""From measurements to a calibrated sensor."""

from acalx.errors import SingularError
from acalx.estimation.base import Estimator
from acalx.estimation.calibration import Calibration
from acalx.estimation.correction import Correction, read_correction
from acalx.estimation.estimate import Estimate
from acalx.estimation.files import read_groups, read_readings
from acalx.estimation.iterated import Iterated
from acalx.estimation.linear import Linear
from acalx.estimation.losses import Bisquare, Huber, Loss, Squares
from acalx.estimation.procedure import calibrate
from acalx.estimation.readings import Readings
from acalx.estimation.static import StaticIntervals
from acalx.estimation.units import Unit

__all__ = [
    "Bisquare",
    "Calibration",
    "Correction",
    "Estimate",
    "Estimator",
    "Huber",
    "Iterated",
    "Linear",
    "Loss",
    "Readings",
    "SingularError",
    "Squares",
    "StaticIntervals",
    "Unit",
    "calibrate",
    "read_correction",
    "read_groups",
    "read_readings",
]
