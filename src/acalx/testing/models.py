"""The contracts of a sensor, of a comparison, and of the model that they make."""

from __future__ import annotations

import numpy as np

from acalx.models import Compared, Comparison, Model
from acalx.models.table import Table
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import UNITS_OF, Stimulus
from acalx.sensors import Sensor
from acalx.stands import Stand
from acalx.testing.rules import STACKS, N, require, require_close, require_derivative, require_shape, require_stacked

__all__ = ["check_comparison", "check_model", "check_sensor"]

# Errors of the sensors that are tried, a share of what they read.
_SIZE = 0.03
# Derivatives agree with numerical ones in ten digits.
_TEN_DIGITS = 1e-10
# Time in each position, for sensors whose noise or readings depend on it.
_DWELL_S = 60.0


def check_sensor(sensor: Sensor, stand: Stand, *, seed: int = 0) -> None:
    """Check a sensor on a stand: names, parts, readings, derivatives, noise, what was felt from what was read.

    Parameters
    ----------
    sensor : Sensor
    stand : Stand
        One that provides what it needs.
    seed : int
        Of the random settings and errors.
    """
    p, k = len(sensor.parameters), len(sensor.channels)
    for what, items in (("parameter", sensor.parameters), ("channel", sensor.channels)):
        names = [item.name for item in items]
        require(bool(names) and len(set(names)) == len(names), sensor, f"each {what} has its own name, got {names}")
    numbers = sorted(number for part in sensor.parts.values() for number in part)
    require(numbers == list(range(k)), sensor, f"parts have each of the {k} channels once, got {dict(sensor.parts)}")
    rng = np.random.default_rng(seed)
    model = Compared(sensor)
    for stack in STACKS:
        settings = stand.axes.random(rng, (*stack, N))
        stimulus = _felt(model, stand, settings)
        parameters = sensor.nominal + _SIZE * rng.standard_normal((*stack, p))
        found = sensor.readings(parameters, stimulus)
        require_shape(sensor, "readings", found, (*stack, N, k))
        turned = stimulus.made({name: value[..., ::-1, :] for name, value in stimulus.items()})
        rule = "a position's readings depend on it alone, not on its place among the others"
        if not {"time"} & set(sensor.needs):
            require_close(sensor, rule, sensor.readings(parameters, turned), found[..., ::-1, :], 1e-9)
        for index in np.ndindex(stack):
            alone = stimulus.made({name: value[index] for name, value in stimulus.items()})
            rule = "readings of a stack are those of its members"
            require_close(sensor, rule, found[index], sensor.readings(parameters[index], alone), 1e-9)
        slopes, numerical = (
            sensor.by_parameters(parameters, stimulus),
            Sensor.by_parameters(sensor, parameters, stimulus),
        )
        slopes, numerical = (np.broadcast_to(each, (*stack, N, k, p)) for each in (slopes, numerical))
        require_close(sensor, "by_parameters agrees with the numerical derivatives", slopes, numerical, _TEN_DIGITS)
        exact, wanted = sensor.by_stimulus(parameters, stimulus), Sensor.by_stimulus(sensor, parameters, stimulus)
        for name, expected in wanted.items():
            rule = f"by_stimulus agrees with the numerical derivative by {name}"
            require_close(sensor, rule, np.broadcast_to(exact[name], expected.shape), expected, _TEN_DIGITS)
        _check_noise(sensor, stimulus, (*stack, N))
        _check_table(sensor, stimulus)
        if sensor.senses:
            felt = sensor.felt(parameters, found, stimulus)
            for name in sensor.senses:
                rule = f"felt finds the {name} from readings without noise"
                require_close(sensor, rule, felt[name], np.broadcast_to(stimulus[name], felt[name].shape), 1e-9)


def _check_table(sensor: Sensor, stimulus: Stimulus) -> None:
    """A table of products beside the readings, (..., n, k), of a sensor without errors."""
    if sensor.table is None:
        return
    k, p = len(sensor.channels), len(sensor.parameters)
    rows = Table(k, p, tuple(sensor.table)).rows(stimulus)
    expected = np.broadcast_to(Sensor.by_parameters(sensor, sensor.nominal, stimulus), rows.shape)
    require_close(sensor, "the products of the table are the derivatives of the readings", rows, expected, _TEN_DIGITS)
    if sensor.ideal and not sensor.nominal.any():
        table = tuple((channel, 0, factor, product) for channel, factor, product in sensor.ideal)
        found, reads = Table(k, 1, table).rows(stimulus)[..., 0], sensor.readings(sensor.nominal, stimulus)
        require_close(sensor, "ideal is what a sensor without errors reads", found, reads, 1e-9)


def _check_noise(sensor: Sensor, stimulus: Stimulus, shape: tuple[int, ...]) -> None:
    """Standard deviations of readings in positions of this shape (..., n), and how positions share their noise."""
    deviations = np.asarray(sensor.deviations(stimulus))
    k = len(sensor.channels)
    require(
        deviations.shape in ((k,), (*shape, k)),
        sensor,
        f"deviations have shape {(k,)} or {(*shape, k)}, got {deviations.shape}",
    )
    positive = bool((np.isfinite(deviations) & (deviations > 0.0)).all())
    require(positive, sensor, "deviations are positive and finite")
    middles = _DWELL_S * (np.arange(shape[-1]) + 0.5)
    found = sensor.correlation(np.broadcast_to(middles, shape))
    if found is None:
        return
    n = shape[-1]
    require_shape(sensor, "correlation", found, (*shape, n))
    require_close(sensor, "correlation is symmetric", found, np.swapaxes(found, -1, -2), 1e-12)
    require_close(
        sensor, "correlation is 1 of a position with itself", np.diagonal(found, 0, -2, -1), np.ones(shape), 1e-9
    )
    require(bool((np.linalg.eigvalsh(found) > 0.0).all()), sensor, "correlation is positive definite")


def check_comparison(comparison: Comparison, sensor: Sensor, stand: Stand, *, seed: int = 0) -> None:
    """Check a comparison of a sensor: nothing is left of the right parameters, and its rows are derivatives.

    Parameters
    ----------
    comparison : Comparison
    sensor : Sensor
        One that has what is compared.
    stand : Stand
        One that provides what the sensor needs.
    seed : int
        Of the random settings and errors.
    """
    comparison.check(sensor)
    rng = np.random.default_rng(seed)
    p, k, m = len(sensor.parameters), len(sensor.channels), comparison.count(sensor)
    require(set(comparison.knows(sensor)) <= set(sensor.needs), comparison, "knows names quantities that are felt")
    known = _felt(Compared(sensor), stand, stand.axes.random(rng, (N,)))
    truth = sensor.nominal + _SIZE * rng.standard_normal((2, p))
    readings = sensor.readings(truth, known)
    found = comparison.residual(sensor, truth, readings, known)
    require_shape(comparison, "the residual", np.broadcast_to(found.value, (2, N, m)), (2, N, m))
    scale = float(np.abs(readings).max())
    require_close(comparison, "the right parameters leave nothing", found.value / scale, np.zeros((2, N, m)), 1e-9)
    step = 1e-5
    for number in range(p):
        shift = step * (np.arange(p) == number)
        above, below = (comparison.residual(sensor, truth + s, readings, known).value for s in (shift, -shift))
        rows = np.broadcast_to(found.rows, (2, N, m, p))[..., number]
        require_close(
            comparison, "rows say how much of it a parameter takes off", rows, (below - above) / (2 * step), 1e-5
        )
    nominal = comparison.rows(sensor, known)
    by_readings = np.eye(k) if nominal.by_readings is None else nominal.by_readings
    clean = sensor.readings(sensor.nominal, known)
    for number in range(k):
        shift = step * scale * (np.arange(k) == number)
        above, below = (comparison.residual(sensor, sensor.nominal, clean + s, known).value for s in (shift, -shift))
        slope = np.broadcast_to(by_readings, (N, m, k))[..., number]
        rule = "by_readings are its derivatives by the readings"
        require_close(comparison, rule, slope, (above - below) / (2 * step * scale), 1e-5)


def check_model(model: Model, stand: Stand, *, seed: int = 0) -> None:
    """Check a model on the stimulus of a stand: parameters, regressors, their derivative, readings, residual.

    Parameters
    ----------
    model : Model
    stand : Stand
        One that provides what the model needs.
    seed : int
        Of the random settings.
    """
    p, m, k = len(model.parameters), model.outputs, len(model.channels)
    names = [parameter.name for parameter in model.parameters]
    require(p > 0 and m > 0, model, "there are parameters and outputs")
    require(len(set(names)) == p, model, f"each parameter has its own name, got {names}")
    require(bool(tuple(model.needs)), model, f"needs names quantities, as {sorted(UNITS_OF)}")
    informed = model.informed
    require(informed or model.smallest_n * m >= p, model, "smallest_n gives as many readings as parameters")
    for stack in STACKS:
        angles = stand.axes.random(np.random.default_rng(seed), (*stack, N))
        stimulus = _timed(model, stand, angles)
        model.check(stimulus, stand)
        rows = model.regressors(stimulus)
        require_shape(model, "regressors", rows, (*stack, N, m, p))
        require_stacked(model, "regressors", lambda x: [model.regressors(_timed(model, stand, x))], angles)
        turned = stimulus.made({name: value[..., ::-1, :] for name, value in stimulus.items()})
        if stimulus.weights is None:
            rule = "a position's rows depend on it alone, not on its place among the others"
            require_close(model, rule, model.regressors(turned), rows[..., ::-1, :, :], 1e-9)
        if not model.ordered:  # rows of which depend on other positions too
            _check_derivatives(model, stimulus, rows)
        zeros = np.broadcast_to(model.nominal, (*stack, p))
        readings = model.readings(zeros, stimulus)
        require_shape(model, "readings", readings, (*stack, N, k))
        residual, there = model.residual(zeros, readings, stimulus)
        require_shape(model, "residual", residual, (*stack, N * m))
        rule = "a sensor without errors leaves nothing, and its rows are the regressors"
        require_close(model, rule, residual / np.abs(rows).max(), np.zeros(residual.shape), 1e-9)
        require_close(model, rule, np.broadcast_to(there, (*stack, N * m, p)), rows.reshape(*stack, N * m, p), 1e-9)


def _check_derivatives(model: Model, stimulus: Stimulus, rows: Array) -> None:
    """Derivatives of the rows, and a gradient pulled through them."""
    exact, numerical = model.derivative(stimulus), Model.derivative(model, stimulus)
    widths = {name: stimulus[name].shape[-1] for name in numerical}
    samples = () if stimulus.weights is None else stimulus.weights.shape
    for name, width in widths.items():
        alone, wanted = (Stimulus({name: each[name]}) for each in (exact, numerical))
        require_derivative(model, alone, wanted, (*rows.shape[:-2], *samples, *rows.shape[-2:], width))
    gradient = np.cos(np.arange(rows.size)).reshape(rows.shape)
    pulled, wanted = model.pull(stimulus, gradient), Model.pull(model, stimulus, gradient)
    for name, expected in wanted.items():
        require_close(model, f"pull by {name} is the chain rule", pulled[name], expected, 1e-6)


def _timed(model: Model, stand: Stand, settings: Array) -> Stimulus:
    """What is felt, and the time in each position where the model needs it."""
    return stand.stimulus(settings).timed(model.needs, _DWELL_S)


def _felt(model: Compared, stand: Stand, settings: Array) -> Stimulus:
    """What a sensor feels, in the units that it takes."""
    stimulus = _timed(model, stand, settings)
    Model.check(model, stimulus, stand)  # of the sensor itself the rules here say more
    return model.in_units(stimulus.mean())
