"""The contracts of an estimator and of what it is made of, a residual and a loss."""

from __future__ import annotations

import numpy as np

from acalx.estimation import Estimator, Loss, Residual
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.stands import Stand
from acalx.testing.rules import TOLERANCE, require, require_close, require_shape

__all__ = ["check_estimator", "check_loss", "check_residual"]

# Errors of the sensors that are tried: small enough for a linear model, large enough to be seen.
_SIZE = 1e-4
_SENSORS = 400
# Of standard errors by so many sensors; the scatter of a scatter is a quarter of it.
_SCATTER = 0.15


def check_estimator(estimator: Estimator, model: Model, stand: Stand, *, seed: int = 0) -> None:
    """Check an estimator on simulated readings: right to first order, alike in stacks, honest about its errors.

    Parameters
    ----------
    estimator : Estimator
    model : Model
        One that the residual of the estimator takes.
    stand : Stand
        One that provides what the model needs.
    seed : int
        Of the random positions, sensors and noise.
    """
    rng = np.random.default_rng(seed)
    stimulus, truth, measurement = _sensors(model, stand, rng)
    p = len(model.parameters)
    right = estimator.estimate(model, measurement, stimulus)
    rule = "the random positions of the stand show all the parameters; try another stand"
    require(not model.information(stimulus).singular.any(), stand, rule)
    require_shape(estimator, "parameters", right.parameters, (_SENSORS, p))
    require(bool(right.converged.all()), estimator, "steps become small where there is no noise")
    rule = "parameters are right to first order in the errors where there is no noise"
    _require_within(estimator, rule, right.parameters - truth, 0.05 * _SIZE)

    count = right.residual.shape[-1]
    noise = 1e-2 * _SIZE
    noisy = measurement + noise * rng.standard_normal(measurement.shape)
    known = estimator.estimate(model, noisy, stimulus, noise=np.full(count, noise))
    spread = (known.parameters - right.parameters).std(axis=0) / known.standard_errors.mean(axis=0) - 1.0
    _require_within(estimator, "standard errors are the scatter of the estimates", spread, _SCATTER)

    few = noisy[:6]
    stacked = estimator.estimate(model, few.reshape(2, 3, *few.shape[1:]), stimulus)
    one_by_one = [estimator.estimate(model, each, stimulus) for each in few]
    for name in ("parameters", "covariance"):
        each = np.stack([getattr(one, name) for one in one_by_one])
        off = getattr(stacked, name).reshape(each.shape) / np.abs(each).max() - each / np.abs(each).max()
        # members of a stack go on until the last of them has converged
        _require_within(estimator, f"the {name} of a stack are as of its members", off, 1e-3)


def check_residual(residual: Residual, model: Model, stand: Stand, *, seed: int = 0) -> None:
    """Check a residual on simulated readings: what errors leave of it, and that its rows are its derivatives.

    Parameters
    ----------
    residual : Residual
    model : Model
        One that it takes.
    stand : Stand
        One that provides what the model needs.
    seed : int
        Of the random positions and sensors.
    """
    residual.check(model)
    stimulus, truth, measurement = _sensors(model, stand, np.random.default_rng(seed))
    truth, measurement = truth[:3], measurement[:3]
    stack, p = truth.shape
    whole, rows = residual.linearized(model, measurement, stimulus)
    count = np.shape(whole)[-1]
    require_shape(residual, "linearized", whole, (stack, count))
    require_shape(residual, "its rows", rows, (*np.shape(rows)[:-2], count, p))
    zero = np.zeros(truth.shape)
    left, _ = residual.at(model, zero, measurement, stimulus)
    require_close(residual, "errors of zero leave all of it", left / _SIZE, whole / _SIZE, 1e-9)
    require(float(np.abs(whole).max()) > 1e-3 * _SIZE, residual, "errors of a sensor show in it")
    left, _ = residual.at(model, truth, measurement, stimulus)
    rule = "the right errors leave nothing of it, to first order"
    _require_within(residual, rule, left, 0.05 * float(np.abs(whole).max()))
    none = model.measurement(zero, stimulus)
    _, rows = residual.linearized(model, none, stimulus)
    _, there = residual.at(model, zero, none, stimulus)
    rows, there = np.broadcast_to(rows, (stack, count, p)), np.broadcast_to(there, (stack, count, p))
    require_close(residual, "rows at zero errors are those of the linear model", there, rows, TOLERANCE)
    step = 1e-3 * _SIZE
    _, there = residual.at(model, truth, measurement, stimulus)
    for k in range(p):
        shift = step * (np.arange(p) == k)
        above, _ = residual.at(model, truth + shift, measurement, stimulus)
        below, _ = residual.at(model, truth - shift, measurement, stimulus)
        slope = (below - above) / (2 * step)
        rule = "rows say how much of it a parameter takes off"
        require_close(residual, rule, np.broadcast_to(there, (stack, count, p))[..., k], slope, 1e-5)


def check_loss(loss: Loss) -> None:
    """Check a loss: full weight at zero, less beyond, a slope that is the derivative of the influence."""
    u = np.linspace(-6.0, 6.0, 1201) + 0.0013
    weight, slope = loss.weight(u), loss.slope(u)
    require_shape(loss, "weight", weight, u.shape)
    require_shape(loss, "slope", slope, u.shape)
    shaped = loss.weight(u[:12].reshape(3, 4))
    require_shape(loss, "weight of a table", shaped, (3, 4))
    require(float(loss.weight(np.zeros(1))[0]) == 1.0, loss, "the weight of a residual of zero is 1")
    require(bool(((weight >= 0.0) & (weight <= 1.0)).all()), loss, "weights are from 0 to 1")
    step = 1e-5  # a kink as near as that is passed over below
    above, below = ((u + s) * loss.weight(u + s) for s in (step, -step))
    wrong = np.abs((above - below) / (2 * step) - slope) > 1e-4
    require(wrong.mean() < 0.005, loss, "slope is the derivative of u times the weight")
    first = loss.first
    require(first is None or first.first is None, loss, "what it starts from has a single minimum")
    require(loss.variance_factor >= 1.0 - 1e-9, loss, "no loss is better than squares where the noise is normal")


def _sensors(model: Model, stand: Stand, rng: np.random.Generator) -> tuple[Stimulus, Array, Array]:
    """Positions, true parameters (_SENSORS, p) and readings without noise (_SENSORS, n, k)."""
    p = len(model.parameters)
    stimulus = stand.stimulus(stand.axes.random(rng, (4 * p,)))
    truth = _SIZE * rng.standard_normal((_SENSORS, p))
    return stimulus, truth, model.measurement(truth, stimulus)


def _require_within(part: object, rule: str, values: Array, limit: float) -> None:
    most = float(np.abs(values).max())
    require(most <= limit, part, f"{rule}; off by {most:.1e}, more than {limit:.1e}")
