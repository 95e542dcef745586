"""Where an estimate starts that knows no attitude, and with how few positions one can."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from acalx.models.base import Model
from acalx.numerics.arrays import Array
from acalx.numerics.sphere import fit_sphere
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.sensors.base import Sensor

__all__ = ["generic_least", "sphere_start"]


def sphere_start(sensor: Sensor, readings: Array, known: Stimulus | None) -> Array:
    """Parameters (..., p) of a sensor that reads the sphere which readings (..., n, 3) lie on, nearly."""
    center, radius = fit_sphere(readings)
    directions = np.array([each for each in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(each)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    others = {} if known is None else {name: known[name] for name in sensor.needs if name not in sensor.senses}
    around = {
        name: np.broadcast_to(each.mean(axis=-2).reshape(-1, each.shape[-1])[:1], (26, each.shape[-1]))
        for name, each in others.items()
    }
    known = Stimulus({**around, sensor.senses[0]: directions})
    rows = sensor.by_parameters(sensor.nominal, known)  # (6, 3, p)
    ideal = sensor.readings(sensor.nominal, known)
    wanted = center[..., None, :] + radius[..., None, None] * directions - ideal
    inverse = np.linalg.pinv(rows.reshape(-1, rows.shape[-1]))
    return np.asarray(sensor.nominal + wanted.reshape((*wanted.shape[:-2], -1)) @ inverse.T)


def generic_least(model: Model, least: int) -> int:
    """So many positions, `least` or more, as parameters show in where anything may be felt: no others show more.

    Which residuals share parameters decides it; a count of residuals and parameters is only a lower limit.
    """
    rng = np.random.default_rng(0)
    widths = {name: 3 if name in VECTORS else 1 for name in model.needs}
    units = dict(model.needs) if isinstance(model.needs, Mapping) else None
    prior = model.prior_information
    for n in range(least, 3 * least + 1):
        felt = {name: rng.standard_normal((n, width)) for name, width in widths.items()}
        felt = {name: value if widths[name] > 1 else 1.0 + np.abs(value) for name, value in felt.items()}
        with np.errstate(all="ignore"):  # a sensor may not bear what no stand does to it
            rows = model.regressors(Stimulus(felt, units=units)).reshape(-1, len(prior))
            rows = np.concatenate([rows / np.abs(rows).max(axis=0), np.diag(prior > 0.0)])
        if not np.isfinite(rows).all():
            break
        if np.linalg.matrix_rank(rows) == len(prior):
            return n
    return least
