"""Whether what a stand says of the degree of its stimulus in each setting is so."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array
from acalx.stands.base import Stand

__all__ = ["wrong_degree"]

# What a fit of the degree that is said may leave, of the largest value: rounding, and what it is amplified by.
_SLACK = 1e-7
_LOOKED_AT = 3


def wrong_degree(stand: Stand) -> str:
    """The name of a setting in which the stimulus is no polynomial of the degree that the stand says; empty where none.

    Along each setting, with the others anywhere, a trigonometric polynomial of that degree in an angle, a polynomial in
    a setting that is none, is fitted to twice as many points as it has coefficients, and must go through all.
    """
    if stand.frequencies is None:
        return ""
    rng = np.random.default_rng(0)
    for number, (setting, degree) in enumerate(zip(stand.settings, stand.frequencies, strict=True)):
        count = (2 * degree if setting.angle else degree) + 1
        span = min(setting.upper - setting.lower, 2.0 * np.pi * (1.0 - 1.0 / count)) if setting.angle else None
        most = setting.lower + (setting.upper - setting.lower if span is None else span)
        points = np.linspace(setting.lower, most, 2 * count + 1)
        if points[-1] <= points[0]:
            continue
        program = np.repeat(stand.axes.random(rng, (_LOOKED_AT, 1)), len(points), axis=1)
        program[..., number] = points
        x = points if setting.angle else (points - points[0]) / (points[-1] - points[0])
        basis = _trigonometric(x, degree) if setting.angle else x[:, None] ** np.arange(degree + 1)
        for value in stand.stimulus(program).values():
            values = np.moveaxis(value, 1, 0).reshape(len(points), -1)
            fitted = basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
            if np.abs(values - fitted).max() > _SLACK * max(1e-300, float(np.abs(values).max())):
                return setting.name
    return ""


def _trigonometric(angles: Array, degree: int) -> Array:
    orders = np.arange(1, degree + 1)
    return np.concatenate(
        [np.ones((len(angles), 1)), np.cos(angles[:, None] * orders), np.sin(angles[:, None] * orders)], axis=1
    )
