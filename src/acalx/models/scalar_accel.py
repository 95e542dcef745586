"""Scalar (invariant) calibration of an accelerometer triad."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.arrays import Array, empty_as
from acalx.information import Parameter
from acalx.models.base import Model
from acalx.stimulus import Stimulus

__all__ = ["ScalarAccel"]

_PARAMETERS = (
    *(Parameter(f"bias_{axis}", "bias", "g") for axis in "xyz"),
    *(Parameter(f"scale_{axis}", "scale", "1") for axis in "xyz"),
    *(Parameter(f"nonorthogonality_{pair}", "nonorthogonality", "rad") for pair in ("xy", "xz", "zy")),
)


@final
@dataclass(frozen=True)
class ScalarAccel(Model):
    """Nine parameters of an accelerometer triad, from the magnitude of gravity.

    In a position with the vertical eta = (ex, ey, ez) in sensor axes the triad reads W, in g:

        W = bias + (I + diag(scale) + N) eta,   N = [[0, xy, xz], [0, 0, 0], [0, zy, 0]].

    The residual J of the magnitude is then, to first order in the parameters X,

        J = h X,   h = (ex, ey, ez, ex^2, ey^2, ez^2, ex ey, ex ez, ez ey).

    Standard deviations come out in units of the standard deviation of J.

    Source: Egorov, Kiryachenko, Popov (2021).
    """

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Biases in g, relative scale-factor errors, non-orthogonalities in rad."""
        return _PARAMETERS

    @property
    def needs(self) -> tuple[str, ...]:
        """The specific force."""
        return ("specific_force",)

    @property
    def degree(self) -> int:
        """Two."""
        return 2

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows h, shape (..., n, 1, 9)."""
        force = _force(stimulus)
        rows = empty_as(force, (*force.shape[:-1], 9))
        x, y, z = (force[..., k] for k in range(3))
        rows[..., :3] = force
        np.multiply(force, force, out=rows[..., 3:6])
        np.multiply(x, y, out=rows[..., 6])
        np.multiply(x, z, out=rows[..., 7])
        np.multiply(z, y, out=rows[..., 8])
        return np.asarray(rows[..., None, :])

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows with respect to the specific force, (..., n, 1, 9, 3)."""
        force = _force(stimulus)
        x, y, z = (force[..., k] for k in range(3))
        rows = empty_as(force, (*force.shape[:-1], 9, 3))
        rows[...] = 0.0
        for k in range(3):
            rows[..., k, k] = 1.0
            np.multiply(2.0, force[..., k], out=rows[..., 3 + k, k])
        rows[..., 6, 0], rows[..., 6, 1] = y, x
        rows[..., 7, 0], rows[..., 7, 2] = z, x
        rows[..., 8, 1], rows[..., 8, 2] = z, y
        return Stimulus(specific_force=rows[..., None, :, :])

    def measurement(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Noise-free readings W of a triad with these errors, in g.

        Parameters
        ----------
        parameters : array (..., 9)
        stimulus : arrays (..., n, 3)

        Returns
        -------
        array (..., n, 3)
        """
        bias, scale, lean = parameters[..., 0:3], parameters[..., 3:6], parameters[..., 6:9]
        matrix = np.zeros((*parameters.shape[:-1], 3, 3))
        matrix[..., range(3), range(3)] = 1.0 + scale
        matrix[..., (0, 0, 2), (1, 2, 1)] = lean
        return bias[..., None, :] + _force(stimulus) @ matrix.swapaxes(-1, -2)

    def residual_oriented(self, measurement: Array, stimulus: Stimulus) -> Array:
        """J = W . eta / |g| - 1, where the orientation is known.

        Parameters
        ----------
        measurement : array (..., n, 3), in g
        stimulus : arrays (..., n, 3)

        Returns
        -------
        array (..., n)
        """
        return np.asarray((measurement * _force(stimulus)).sum(axis=-1) - 1.0)

    def residual_magnitude(self, measurement: Array) -> Array:
        """J = |W| / |g| - 1, where the orientation is not known: (..., n, 3) in g to (..., n)."""
        return np.asarray(np.sqrt((measurement * measurement).sum(axis=-1)) - 1.0)


def _force(stimulus: Stimulus) -> Array:
    assert stimulus.specific_force is not None  # Model.check has refused a stand without it
    return stimulus.specific_force
