"""From readings in static positions to a calibrated sensor."""

from __future__ import annotations

import numpy as np

from acalx.errors import ArgumentError, DataError, Option, SingularError
from acalx.estimation.base import Estimate, Estimator
from acalx.estimation.calibration import CONFIDENCE, Calibration
from acalx.estimation.iterated import Iterated
from acalx.estimation.readings import Readings
from acalx.estimation.sphere import starting_point
from acalx.estimation.units import Unit
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.options import is_number, require_confidence, require_part
from acalx.quantities.information import Information
from acalx.quantities.parameter import parameter_groups

__all__ = ["calibrate", "noise_of"]

# Measured positions are never quite those of a program: coefficients as small as their errors say nothing.
_SHOWN_COEFFICIENT = 0.05
_MODEL, _ESTIMATOR, _UNIT = ScalarAccel(), Iterated(), Unit()


def calibrate(
    readings: Readings | Array,
    model: ScalarAccel = _MODEL,
    estimator: Estimator = _ESTIMATOR,
    unit: Unit = _UNIT,
    noise: float | str | None = None,
    confidence: float = CONFIDENCE,
) -> Calibration:
    """Calibrate a triad from static positions.

    Parameters
    ----------
    readings : Readings, or array (n, 3) of their means
        In the sensor's unit.
    model : ScalarAccel
        Its groups of parameters are those that are estimated.
    estimator : Estimator
    unit : Unit
        Of the readings. Where it says how many are 1 g, a mean magnitude far from that is refused.
    noise : float in g, ``"columns"``, or None
        Standard deviation of the residuals: known, from the deviations and counts of the
        readings, or estimated from the residuals.
    confidence : float
        Of intervals and of the tests.

    Raises
    ------
    SingularError
        Positions that can't show all the parameters, with the combinations.
    DataError
        Readings that can't be used.
    ArgumentError
        Options that can't.
    """
    _require_parts(model, estimator, unit)
    require_confidence(confidence)
    readings = Readings.of(readings)
    estimator.residual.check(model)
    _check_positions(readings)
    if estimator.residual.needs_directions and readings.directions is None:
        estimator.residual.linearized(model, readings.means, None)  # says what is missing
    start, units = starting_point(readings.means - unit.offset, model, unit.per_g)
    per_g = float(units)
    if unit.per_g is not None:
        _question_magnitude(readings, unit)
    _check_shown(readings, model, estimator, start, (readings.means - unit.offset) / per_g)
    estimate = _estimate(readings, model, estimator, per_g, unit.offset, noise, start)
    if unit.per_g is None:  # once more, with scale errors that are relative to their mean
        mean = 1.0 + float(np.mean(estimate.parameters[parameter_groups(model.parameters)["scale"]]))
        start = _relative_to(estimate.parameters, model, mean)
        per_g *= mean
        estimate = _estimate(readings, model, estimator, per_g, unit.offset, noise, start)
    return Calibration(model, readings, Unit(unit.name, per_g, unit.offset), estimate, confidence)


def _require_parts(model: ScalarAccel, estimator: Estimator, unit: Unit) -> None:
    for name, part, kind in (("model", model, ScalarAccel), ("estimator", estimator, Estimator), ("unit", unit, Unit)):
        require_part(name, part, kind)
    if unit.per_g is None and "scale" not in model.groups:
        raise ArgumentError(
            "the scale is not known ({unknown}), so it has to be among the parameters that are estimated: "
            "give {groups} or {number}",
            unknown=Option("per_g", None),
            groups=Option("groups", ["...", "scale"], '(..., "scale")'),
            number=Option("per_g", "NUMBER", "NUMBER"),
        )


def noise_of(readings: Readings, noise: float | str | None, per_g: float, directions: Array) -> Array | None:
    """Known standard deviation of each residual in g, (n,); None where it is to be estimated."""
    if noise is None:
        return None
    if noise == "columns":
        if readings.deviations is None or readings.counts is None:
            raise DataError(
                "{name}: {asked} needs standard deviations in columns sx, sy, sz and numbers of samples in a column n",
                name=readings.name,
                asked=Option("noise", noise),
            )
        variances = (directions**2 * readings.deviations**2).sum(axis=-1) / readings.counts
        if not (variances > 0).all():
            k = int(np.argmin(variances))
            raise DataError(f"{readings.name}: position {k + 1} has standard deviations of zero; noise can't be that")
        return np.asarray(np.sqrt(variances) / per_g)
    if not is_number(noise) or not 0.0 < noise < 1.0:
        raise ArgumentError(
            "{given}: give the standard deviation of a position's mean in g, such as 1e-4, "
            "{columns} to take it from the file, or {unknown} to estimate it",
            given=Option("noise", noise),
            columns=Option("noise", "columns"),
            unknown=Option("noise", None),
        )
    return np.full(readings.n, float(noise))


def _estimate(
    readings: Readings,
    model: ScalarAccel,
    estimator: Estimator,
    per_g: float,
    offset: float,
    noise: float | str | None,
    start: Array,
) -> Estimate:
    measurement = (readings.means - offset) / per_g
    bias, _ = model.split(start)
    felt = measurement - bias
    directions = felt / np.linalg.norm(felt, axis=-1, keepdims=True)
    known = noise_of(readings, noise, per_g, directions)
    estimate = estimator.estimate(model, measurement, readings.stimulus, known, start)
    if not estimate.converged:
        raise DataError(
            f"{readings.name}: the estimate did not settle in {estimator.iterations} steps; "
            "a gross error among the positions, or positions that hardly show the parameters, can do that"
        )
    return estimate


def _relative_to(parameters: Array, model: ScalarAccel, mean: float) -> Array:
    """The same sensor, in a unit that is `mean` times as large."""
    scale = parameter_groups(model.parameters)["scale"]
    out = parameters / mean
    out[scale] = (1.0 + parameters[scale]) / mean - 1.0
    return out


def _check_positions(readings: Readings) -> None:
    if readings.n == 1:
        raise DataError(f"{readings.name}: a single position; a calibration needs several, turned differently")
    nothing = np.flatnonzero((readings.means == 0.0).all(axis=1))
    if len(nothing):
        raise DataError(f"{readings.name}: position {nothing[0] + 1} reads 0, 0, 0; is it missing?")
    spread = np.ptp(readings.means, axis=0).max()
    if spread <= 1e-3 * np.abs(readings.means).max():
        raise DataError(f"{readings.name}: all {readings.n} positions read the same; turn the sensor between them")


def _question_magnitude(readings: Readings, unit: Unit) -> None:
    """Refuse readings that can't be in the unit that they are said to be in."""
    per_g = unit.per_g
    assert per_g is not None  # nothing to question where it is to be found
    lengths = np.linalg.norm(readings.means - unit.offset, axis=1)
    mean = float(lengths.mean())
    if 0.7 < mean / per_g < 1.4:
        return
    meters, g = Option("unit", "m_s2", 'Unit("m/s^2", 9.80665)'), Option("unit", "g", "Unit()")
    guess = "m/s^2 ({meters})" if 7.0 < mean < 13.0 else "g ({g})" if 0.7 < mean < 1.4 else "counts, {mean:.4g} a g"
    raise DataError(
        "{name}: the mean magnitude is {mean:.5g}, but 1 g should read {per_g:.6g} {unit}; "
        f"is the unit right? This looks like {guess}. Nothing is scaled silently: give the right unit, "
        "or {counts} {unknown} to have the scale found",
        name=readings.name,
        mean=mean,
        per_g=per_g,
        unit=unit.name,
        meters=meters,
        g=g,
        counts=Option("unit", "counts", 'Unit("counts", None),'),
        unknown=Option("unit.per_g", None),
    )


def _check_shown(readings: Readings, model: ScalarAccel, estimator: Estimator, start: Array, felt: Array) -> None:
    _, rows = estimator.linearization(model, felt[None], readings.stimulus)(start[None])
    rows = np.broadcast_to(rows, (1, *rows.shape[-2:]))[0]
    unseen = Information.from_regressors(rows[:, None, :], model.parameters).inestimable(_SHOWN_COEFFICIENT)
    if unseen:
        raise SingularError(
            "{name}: {n} positions can't estimate all the {count} parameters; they can't see: {unseen}. "
            "Visit more positions, or estimate fewer groups, as in {fewer}",
            unseen,
            name=readings.name,
            n=readings.n,
            count=len(model.parameters),
            unseen="; ".join(unseen),
            fewer=Option("model.groups", ["bias", "scale"], '("bias", "scale")'),
        )
