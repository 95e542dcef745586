"""The contracts of an estimator and of the loss that it has."""

from __future__ import annotations

import numpy as np

from acalx.estimation import Estimator, Loss
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.stands import Stand
from acalx.testing.rules import require, require_shape

__all__ = ["check_estimator", "check_loss"]

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
        One whose readings have what the estimator compares.
    stand : Stand
        One that provides what the model needs.
    seed : int
        Of the random positions, sensors and noise.
    """
    rng = np.random.default_rng(seed)
    model = estimator.model_for(model)
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
    noisy = measurement + noise * model.deviations(stimulus) * rng.standard_normal(measurement.shape)
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
    truth = model.nominal + _SIZE * rng.standard_normal((_SENSORS, p))
    return stimulus, truth, model.readings(truth, stimulus)


def _require_within(part: object, rule: str, values: Array, limit: float) -> None:
    most = float(np.abs(values).max())
    require(most <= limit, part, f"{rule}; off by {most:.1e}, more than {limit:.1e}")
