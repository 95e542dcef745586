"""Where an estimate starts that knows no attitude, and with how few positions one can."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from acalx.errors import PluginError, asked
from acalx.models.base import Model
from acalx.numerics.arrays import Array
from acalx.numerics.sphere import fit_sphere
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["generic_least", "of_spheres", "sphere_start"]


def of_spheres(sensor: Sensor, lengths: Mapping[str, float]) -> bool:
    """Whether its channels are triads of vectors of these lengths: of one of them all, or of each of them one."""
    triads, senses = len(sensor.channels) // 3, sensor.senses
    return 3 * triads == len(sensor.channels) and set(senses) == set(lengths) and len(senses) in (1, triads)


def sphere_start(sensor: Sensor, readings: Array, known: Stimulus | None, lengths: Mapping[str, float]) -> Array:
    """Parameters (..., p) of a sensor whose triads read the spheres that their readings (..., n, k) lie on, nearly.

    The first triad lies along the axes; others of the same vector are turned to it as their readings are to those of
    the first. Vectors have the lengths that are given, in the units in which the sensor takes them.
    """
    directions = np.array([each for each in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(each)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    others = {} if known is None else {name: known[name] for name in sensor.needs if name not in sensor.senses}
    count = len(directions)
    around = {
        name: np.broadcast_to(each.mean(axis=-2).reshape(-1, each.shape[-1])[:1], (count, each.shape[-1]))
        for name, each in others.items()
    }
    at = Stimulus({**around, **{name: length * directions for name, length in lengths.items()}})
    rows = sensor.by_parameters(sensor.nominal, at)  # (26, k, p)
    triads = [readings[..., k : k + 3] for k in range(0, readings.shape[-1], 3)]
    fits = [fit_sphere(triad) for triad in triads]
    felt = [
        (triad - center[..., None, :]) / radius[..., None, None]
        for triad, (center, radius) in zip(triads, fits, strict=True)
    ]
    wanted = []
    for k, (center, radius) in enumerate(fits):
        alone = k == 0 or len(sensor.senses) > 1
        turned = directions if alone else directions @ _rotation(felt[0], felt[k]).swapaxes(-1, -2)
        wanted.append(center[..., None, :] + radius[..., None, None] * turned)
    off = np.concatenate(wanted, axis=-1) - sensor.readings(sensor.nominal, at)
    inverse = np.linalg.pinv(rows.reshape(-1, rows.shape[-1]))
    return np.asarray(sensor.nominal + off.reshape((*off.shape[:-2], -1)) @ inverse.T)


def _rotation(first: Array, second: Array) -> Array:
    """The rotation (..., 3, 3) that takes vectors (..., n, 3) nearest to others, by least squares.

    Source: Kabsch, Acta Cryst. A32 (1976), 922.
    """
    u, _, v = np.linalg.svd(np.nan_to_num(second).swapaxes(-1, -2) @ np.nan_to_num(first))
    u[..., -1] *= np.sign(np.linalg.det(u @ v))[..., None]
    return np.asarray(u @ v)


def generic_least(model: Model, least: int) -> int:
    """So many positions, `least` or more, as parameters show in where anything may be felt: no others show more.

    Which residuals share parameters decides it; a count of residuals and parameters is only a lower limit.
    """
    rng = np.random.default_rng(0)
    widths = model.widths
    units = dict(model.needs) if isinstance(model.needs, Mapping) else None
    prior = model.prior_information
    for n in range(least, 3 * least + 1):
        felt = {name: rng.standard_normal((n, width)) for name, width in widths.items()}
        felt = {name: value if widths[name] > 1 else 1.0 + np.abs(value) for name, value in felt.items()}
        with np.errstate(all="ignore"):  # a sensor may not bear what no stand does to it
            try:
                rows = asked(f"{model.called}.regressors", model.regressors, Stimulus(felt, units=units))
            except PluginError:
                break
            rows = rows.reshape(-1, len(prior))
            rows = np.concatenate([rows / np.abs(rows).max(axis=0), np.diag(prior > 0.0)])
        if not np.isfinite(rows).all():
            break
        if np.linalg.matrix_rank(rows) == len(prior):
            return n
    return least
