"""What acalx.calibrate shows of a calibration."""

from __future__ import annotations

import math

import numpy as np

from acalx.estimation import Calibration, Correction
from acalx.numerics.arrays import Array
from acalx.quantities.magnitude import significant
from acalx.reporting.tables import align

__all__ = ["parameters_table", "show"]

# Parameters are shown to so many decimals, or to more where standard errors are below the last of these.
_DECIMALS, _MOST_DECIMALS = 6, 15


def show(calibration: Calibration) -> None:
    """The parameters with their accuracy, the correction, the fit, and what is to be said of them."""
    correction = calibration.correction
    print(f"{parameters_table(calibration)}\n")
    print(f"{correction.formula}, readings in {correction.unit}")
    if isinstance(correction, Correction):
        cells = [[f"{value:+.9g}" for value in row] for row in correction.matrix]
        head = ["matrix", *[""] * (len(cells) - 1), "offset"]
        print(align([head, *([*c, f"{o:+.7g}"] for c, o in zip(cells, correction.offset, strict=True))]))
    print()
    print(calibration.summary())
    for remark in calibration.remarks():
        print(remark)


def parameters_table(calibration: Calibration) -> str:
    """Estimates with standard errors and intervals, a row for each parameter."""
    estimate = calibration.estimate
    rows = [["parameter", "unit", "estimate", "standard error", f"{100 * calibration.confidence:g} % interval"]]
    decimals = _decimals(estimate.parameters, estimate.standard_errors)
    for parameter, value, error, half in zip(
        estimate.model.parameters,
        estimate.parameters,
        estimate.standard_errors,
        calibration.half_widths,
        strict=True,
    ):
        low, high = (f"{end:+.{decimals}f}" for end in (value - half, value + half))
        interval = f"{low} to {high}" if np.isfinite(half) else "-"
        shown = significant(error) if np.isfinite(error) else "-"
        rows.append([parameter.name, parameter.unit, f"{value:+.{decimals}f}", shown, interval])
    return align(rows)


def _decimals(values: Array, errors: Array) -> int:
    """Decimals with which the smallest standard error shows four digits; without any, the largest estimate."""
    known = errors[np.isfinite(errors) & (errors > 0)]
    smallest = float(known.min()) if len(known) else float(np.abs(values).max())
    if smallest == 0.0:
        return _DECIMALS
    return min(_MOST_DECIMALS, max(_DECIMALS, 3 - math.floor(math.log10(smallest))))
