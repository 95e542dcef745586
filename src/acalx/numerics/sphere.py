"""The sphere that points lie on, nearly."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["fit_sphere"]


def fit_sphere(points: Array) -> tuple[Array, Array]:
    """Center (..., 3) and radius (...) of the sphere through points (..., n, 3), by linear least squares.

    |w - m|^2 = 2 c (w - m) + r^2 - |c|^2, with m the mean of the points. Points in a plane give
    the center in that plane.
    """
    middle = points.mean(axis=-2, keepdims=True)
    around = points - middle
    size = np.sqrt((around * around).sum(axis=-1, keepdims=True).mean(axis=-2, keepdims=True))
    around = around / size
    rows = np.concatenate([2.0 * around, np.ones((*around.shape[:-1], 1))], axis=-1)
    solution = (np.linalg.pinv(rows, rcond=1e-6) @ (around * around).sum(axis=-1)[..., None])[..., 0]
    center = solution[..., :3]
    radius = np.sqrt(np.maximum(solution[..., 3] + (center * center).sum(axis=-1), 0.0))
    return middle[..., 0, :] + center * size[..., 0], radius * size[..., 0, 0]
