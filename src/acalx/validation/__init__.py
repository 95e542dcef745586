"""How right a calibration is, by positions that it has not seen."""

from acalx.validation.comparison import Compared, compare_programs, directions_of
from acalx.validation.procedure import Validated, ValidatedSensor, validate
from acalx.validation.splits import Validation, held_out

__all__ = [
    "Compared",
    "Validated",
    "ValidatedSensor",
    "Validation",
    "compare_programs",
    "directions_of",
    "held_out",
    "validate",
]
