"""From readings in a number of positions to a calibrated sensor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError, DataError, Option, SingularError
from acalx.estimation.base import Estimator
from acalx.estimation.calibration import CONFIDENCE, Calibration
from acalx.estimation.columns import columns_for, needs_of
from acalx.estimation.estimate import Estimate
from acalx.estimation.files import deviations_of
from acalx.estimation.iterated import Iterated
from acalx.estimation.plausible import OF_LENGTH_ONE, check_positions, question_unit
from acalx.estimation.readings import Readings
from acalx.estimation.units import Unit
from acalx.models import Model, ScalarAccel, as_model
from acalx.models.contract import check_sensor
from acalx.models.sensor_model import SensorModel
from acalx.numerics.arrays import Array
from acalx.numerics.sphere import fit_sphere
from acalx.options import is_number, require_confidence, require_part
from acalx.problem.parts import check_readings
from acalx.quantities.information import Information
from acalx.quantities.parameter import parameter_groups
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import Sensor

__all__ = ["calibrate", "prepared", "require_known", "starting_point"]

# Measured positions are never quite those of a program: coefficients as small as their errors say nothing.
_SHOWN_COEFFICIENT = 0.05
_MODEL, _ESTIMATOR = ScalarAccel(), Iterated()


def calibrate(
    readings: Readings | Array,
    model: Model | Sensor = _MODEL,
    estimator: Estimator = _ESTIMATOR,
    unit: Unit | None = None,
    noise: float | str | None = None,
    confidence: float = CONFIDENCE,
) -> Calibration:
    """Calibrate a sensor from what it read in a number of positions.

    Parameters
    ----------
    readings : Readings, or array (n, k) of their means
        In the sensor's unit, with what is known of each position where the model's comparison takes that.
    model : Model or Sensor
        Its parameters are those that are estimated; of a sensor the outputs are compared.
    estimator : Estimator
    unit : Unit, optional
        Of the readings; that of the sensor's channels where it is not given. Where it says how many are 1 g, a mean
        magnitude far from that is refused.
    noise : float, ``"columns"``, or None
        Standard deviation of the residuals as a multiple of the model's noise, which for `ScalarAccel` is in g:
        known, from the deviations and counts of the readings, or estimated from the residuals.
    confidence : float
        Of intervals and of the tests.

    Raises
    ------
    SingularError
        Positions that can't show all the parameters, with the combinations.
    DataError
        Readings that can't be used, or of which too little is known.
    ArgumentError, CompatibilityError
        Options that can't; a comparison that the readings do not have.
    PluginError
        A sensor that does not give what it must.
    """
    require_part("estimator", estimator, Estimator)
    require_confidence(confidence)
    model = estimator.model_for(as_model(model))
    unit = prepared(model, unit)
    readings = Readings.of(readings)
    require_known(readings, model)
    known = readings.stimulus
    if known is not None and all(name in known for name in model.needs):
        _check_sensors(model, known)
    check_positions(readings, model, unit)
    start, per = starting_point(readings.means - unit.offset, readings.stimulus, model, unit)
    question_unit(readings, model, unit)
    _check_shown(readings, model, estimator, start, (readings.means - unit.offset) / per)
    estimate = _estimate(readings, model, estimator, per, unit.offset, noise, start)
    if unit.per_g is None:  # once more, with scale errors that are relative to their mean
        mean = 1.0 + float(np.mean(estimate.parameters[parameter_groups(model.parameters)["scale"]]))
        start = _relative_to(estimate.parameters, model, mean)
        per = per * mean
        estimate = _estimate(readings, model, estimator, per, unit.offset, noise, start)
        unit = replace(unit, per_g=float(per[0]))
    return Calibration(model, readings, unit, estimate, confidence)


def _check_sensors(model: Model, known: Stimulus) -> None:
    """Raise PluginError where a sensor does not give what it must for what was felt."""
    for one, _ in model.singles:
        if isinstance(one, SensorModel):
            check_sensor(one.sensor, one.in_units(known).without_samples())
    check_readings(model, known)


def prepared(model: Model, unit: Unit | None) -> Unit:
    """The unit of the readings of a model; ArgumentError where it is none, or can't be found from them."""
    unit = Unit(None) if unit is None else unit
    require_part("unit", unit, Unit)
    unit = unit.named_for(model.channels)
    if unit.per_g is not None:
        unit.per_channel(model.channels)  # says what is missing
        return unit
    if not model.by_length:
        raise CompatibilityError(
            "the scale is not known ({unknown}), and {model} is not compared by a magnitude that would tell it: give "
            "{number}",
            unknown=Option("per_g", None),
            model=model.called,
            number=Option("per_g", "NUMBER", "NUMBER"),
        )
    if "scale" not in parameter_groups(model.parameters):
        raise ArgumentError(
            "the scale is not known ({unknown}), so it has to be among the parameters that are estimated: "
            "give {groups} or {number}",
            unknown=Option("per_g", None),
            groups=Option("groups", ["...", "scale"], '(..., "scale")'),
            number=Option("per_g", "NUMBER", "NUMBER"),
        )
    return unit


def starting_point(means: Array, known: Stimulus | None, model: Model, unit: Unit) -> tuple[Array, Array]:
    """Parameters (..., p) to start from, and how many units are one of each channel's, (..., k), for (..., n, k)."""
    if unit.per_g is not None:
        per = unit.per_channel(model.channels)
        return model.start(means / per, known), per
    if "bias" in parameter_groups(model.parameters):
        _, radius = fit_sphere(means)
    else:
        radius = np.linalg.norm(means, axis=-1).mean(axis=-1)
    per = np.repeat(radius[..., None], means.shape[-1], axis=-1)
    return model.start(means / per[..., None, :], known), per


def require_known(readings: Readings, model: Model) -> None:
    """Raise DataError where the readings have other channels than the model, or do not say what it must know."""
    channels = model.channels
    if readings.means.shape[1] != len(channels):
        raise DataError(
            "{name}: {width} columns of readings, but model {model} has {k} channels: {channels}",
            name=readings.name,
            width=readings.means.shape[1],
            model=model.called,
            k=len(channels),
            channels=", ".join(f"{channel.name} in {channel.unit}" for channel in channels),
        )
    known = () if readings.stimulus is None else tuple(readings.stimulus)
    missing = [name for name in model.knows if name not in known]
    if missing:
        needs = needs_of(model)
        columns = " and ".join(columns_for(name, needs.get(name, ""), model.widths.get(name, 1)) for name in missing)
        lengths = ", or compare the magnitude" if all(model.widths[name] > 1 for name in missing) else ""
        raise DataError(
            "{name}: what is compared of {model} needs the {missing} in each position: give the settings of the stand "
            "in columns such as alpha1_deg, alpha2_deg, or {columns}" + lengths,
            name=readings.name,
            model=model.called,
            missing=" and the ".join(_words(name) for name in missing),
            columns=columns,
        )


def _words(quantity: str) -> str:
    vectors = {"specific_force": "direction of the vertical", "magnetic_field": "direction of the field"}
    return vectors.get(quantity, quantity.replace("_", " "))


def noise_of(readings: Readings, noise: float | str | None, model: Model, start: Array, per: Array) -> Array | None:
    """Known standard deviation of each residual in units of the model's noise, (n m,); None where it is estimated."""
    if noise is None:
        _check_told(readings, model)
        return None
    if noise == "columns":
        if readings.deviations is None or readings.counts is None:
            raise DataError(
                "{name}: {asked} needs standard deviations in columns {columns} and numbers of samples in a column n",
                name=readings.name,
                columns=" or ".join(map(", ".join, deviations_of([channel.name for channel in model.channels]))),
                asked=Option("noise", noise),
            )
        own = readings.deviations / np.sqrt(readings.counts)[:, None] / per
        sizes = model.residual_deviations(start, readings.means / per, readings.stimulus, own)
        if not (sizes > 0).all():
            k = int(np.argmin(sizes)) // model.outputs
            raise DataError(f"{readings.name}: position {k + 1} has standard deviations of zero; noise can't be that")
        return sizes
    # of what has length one, in units of that, a noise as large is a slip
    most = 1.0 if all(channel.unit in OF_LENGTH_ONE and channel.noise == 1.0 for channel in model.channels) else 1e6
    if not is_number(noise) or not 0.0 < noise < most:
        of_one = {channel.unit for channel in model.channels if channel.noise == 1.0}
        alike = len(of_one) == 1 and all(channel.noise == 1.0 for channel in model.channels)
        size = f"in {of_one.pop()}, such as 1e-4" if alike else "as a multiple of that of the model, such as 1"
        raise ArgumentError(
            f"{{given}}: give the standard deviation of a position's mean {size}, "
            "{columns} to take it from the file, or {unknown} to estimate it",
            given=Option("noise", noise),
            columns=Option("noise", "columns"),
            unknown=Option("noise", None),
        )
    return np.full(readings.n * model.outputs, float(noise))


def _check_told(readings: Readings, model: Model) -> None:
    """Refuse to estimate the noise beside a prior from no more residuals than parameters: these then fit exactly."""
    count, p = readings.n * model.outputs, len(model.parameters)
    if model.informed and count <= p:
        raise DataError(
            "{name}: {count} residuals of {n} positions do not tell the noise beside a prior of {p} parameters: give "
            "{noise}, a multiple of that of the model",
            name=readings.name,
            count=count,
            n=readings.n,
            p=p,
            noise=Option("noise", 1.0),
        )


def _estimate(
    readings: Readings,
    model: Model,
    estimator: Estimator,
    per: Array,
    offset: float,
    noise: float | str | None,
    start: Array,
) -> Estimate:
    moved = replace(readings, means=readings.means - offset)
    known = noise_of(moved, noise, model, start, per)
    estimate = estimator.estimate(model, moved.means / per, readings.stimulus, known, start)
    if not estimate.converged:
        raise DataError(
            f"{readings.name}: the estimate did not settle in {estimator.iterations} steps; "
            "a gross error among the positions, or positions that hardly show the parameters, can do that"
        )
    return estimate


def _relative_to(parameters: Array, model: Model, mean: float) -> Array:
    """The same sensor, in a unit that is `mean` times as large."""
    scale = parameter_groups(model.parameters)["scale"]
    out = parameters / mean
    out[scale] = (1.0 + parameters[scale]) / mean - 1.0
    return out


def _check_shown(readings: Readings, model: Model, estimator: Estimator, start: Array, felt: Array) -> None:
    known = readings.stimulus
    _, rows = estimator.linearization(model, felt[None], known)(start[None])
    rows = np.broadcast_to(rows, (1, *rows.shape[-2:]))[0]
    information = model.with_prior(Information.from_regressors(rows[:, None, :], model.parameters))
    unseen = information.inestimable(_SHOWN_COEFFICIENT)
    if unseen:
        fewer = len(parameter_groups(model.parameters)) > 1 and hasattr(model, "groups")
        raise SingularError(
            "{name}: {n} positions can't estimate all the {count} parameters; they can't see: {unseen}. "
            "Visit more positions" + (", or estimate fewer groups, as in {fewer}" if fewer else ""),
            unseen,
            name=readings.name,
            n=readings.n,
            count=len(model.parameters),
            unseen="; ".join(unseen),
            fewer=Option("model.groups", ["bias", "scale"], '("bias", "scale")'),
        )
