"""The contract of each kind of part, for whoever writes one: call these from your own tests.

Each function tries a part on random input and raises AssertionError with the name of the part
and the rule that it broke. What a part itself raises comes through as it is.
"""

from acalx.testing.criteria import check_criterion
from acalx.testing.estimation import check_estimator, check_loss
from acalx.testing.models import check_comparison, check_model, check_sensor
from acalx.testing.optimizers import check_optimizer
from acalx.testing.schemes import check_scheme
from acalx.testing.stands import check_stand

__all__ = [
    "check_comparison",
    "check_criterion",
    "check_estimator",
    "check_loss",
    "check_model",
    "check_optimizer",
    "check_scheme",
    "check_sensor",
    "check_stand",
]
