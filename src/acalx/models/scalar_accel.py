"""Scalar (invariant) calibration of an accelerometer triad."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.models.base import Model
from acalx.numerics.arrays import Array, components, empty_as
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus

__all__ = ["ScalarAccel"]

_PARAMETERS = (
    *(Parameter(f"bias_{axis}", "bias", "g") for axis in "xyz"),
    *(Parameter(f"scale_{axis}", "scale", "1") for axis in "xyz"),
    *(Parameter(f"nonorthogonality_{pair}", "nonorthogonality", "rad") for pair in ("xy", "xz", "zy")),
)


_GROUPS = ("bias", "scale", "nonorthogonality")


@final
@dataclass(frozen=True)
class ScalarAccel(Model):
    """Nine parameters of an accelerometer triad, from the magnitude of gravity.

    In a position with the vertical eta = (ex, ey, ez) in sensor axes the triad reads W, in g:

        W = bias + A eta,   A = I + diag(scale) + [[0, xy, xz], [0, 0, 0], [0, zy, 0]].

    The residual J of the magnitude is then, to first order in the parameters X,

        J = h X,   h = (ex, ey, ez, ex^2, ey^2, ez^2, ex ey, ex ez, ez ey).

    Standard deviations come out in units of the standard deviation of J.

    Parameters
    ----------
    groups : sequence of str
        The groups of parameters that are estimated; the others are taken for zero. Without
        ``nonorthogonality`` the six faces of a cube are enough.

    Raises
    ------
    ArgumentError
        No groups, or one that there isn't.

    Source: Egorov, Kiryachenko, Popov (2021).
    """

    groups: Sequence[str] = _GROUPS

    def __post_init__(self) -> None:
        given = self.groups
        if isinstance(given, str) or not isinstance(given, Sequence) or not given or not set(given) <= set(_GROUPS):
            raise ArgumentError.of("groups", given, f"give one or more of {', '.join(_GROUPS)}", ["bias", "scale"])
        object.__setattr__(self, "groups", tuple(group for group in _GROUPS if group in given))

    @cached_property
    def _columns(self) -> list[int]:
        """Which of the nine parameters are estimated."""
        return [k for k, parameter in enumerate(_PARAMETERS) if parameter.group in self.groups]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Biases in g, relative scale-factor errors, non-orthogonalities in rad."""
        return tuple(_PARAMETERS[k] for k in self._columns)

    @property
    def needs(self) -> tuple[str, ...]:
        """The specific force alone: the vertical in sensor axes, in g."""
        return ("specific_force",)

    @property
    def degree(self) -> int:
        """Two: rows are linear for biases, quadratic in the vertical for scale and non-orthogonality."""
        return 2

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows h of the residual of the magnitude, (..., n, 1, p): the vertical, its squares and products."""
        force = _force(stimulus)
        rows = empty_as(force, (*force.shape[:-1], 9))
        x, y, z = (force[..., k] for k in range(3))
        rows[..., :3] = force
        np.multiply(force, force, out=rows[..., 3:6])
        np.multiply(x, y, out=rows[..., 6])
        np.multiply(x, z, out=rows[..., 7])
        np.multiply(z, y, out=rows[..., 8])
        return np.asarray(self._chosen(rows)[..., None, :])

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows with respect to the specific force, (..., n, 1, p, 3)."""
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
        chosen = rows if len(self._columns) == 9 else rows[..., self._columns, :]
        return Stimulus(specific_force=chosen[..., None, :, :])

    def split(self, parameters: Array) -> tuple[Array, Array]:
        """Bias (..., 3) in g and the matrix A (..., 3, 3) for parameters (..., p)."""
        full = np.zeros((*parameters.shape[:-1], 9))
        full[..., self._columns] = parameters
        matrix = np.zeros((*parameters.shape[:-1], 3, 3))
        matrix[..., range(3), range(3)] = 1.0 + full[..., 3:6]
        matrix[..., (0, 0, 2), (1, 2, 1)] = full[..., 6:9]
        return full[..., :3], matrix

    def measurement(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Noise-free readings W of a triad with these errors, in g.

        Parameters
        ----------
        parameters : array (..., p)
        stimulus : arrays (..., n, 3)

        Returns
        -------
        array (..., n, 3)
        """
        full = np.zeros((*parameters.shape[:-1], 9))
        full[..., self._columns] = parameters
        bx, by, bz, sx, sy, sz, xy, xz, zy = np.moveaxis(full, -1, 0)[..., None]
        x, y, z = np.moveaxis(_force(stimulus), -1, 0)
        return components(bx + x + (sx * x + xy * y + xz * z), by + y + sy * y, bz + z + (sz * z + zy * y))

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

    def magnitude_at(self, parameters: Array, measurement: Array) -> tuple[Array, Array]:
        """What is left of the residual of the magnitude once these errors are taken off, and its rows.

        J = |eta| - 1 with eta = inv(A) (W - bias); to first order J = h (X - parameters). At zero
        parameters these are `residual_magnitude` and the rows of the direction that was read,
        times its magnitude in the places of scale and non-orthogonality.

        Parameters
        ----------
        parameters : array (..., p)
        measurement : array (..., n, 3), in g

        Returns
        -------
        J, array (..., n), and the rows h, array (..., n, p)
        """
        full = np.zeros((*parameters.shape[:-1], 9))
        full[..., self._columns] = parameters
        bx, by, bz, sx, sy, sz, xy, xz, zy = np.moveaxis(full, -1, 0)[..., None]
        ax, ay, az = 1.0 / (1.0 + sx), 1.0 / (1.0 + sy), 1.0 / (1.0 + sz)
        # A is triangular once z and y change places: no elimination is needed
        y = (measurement[..., 1] - by) * ay
        z = (measurement[..., 2] - bz - zy * y) * az
        x = (measurement[..., 0] - bx - xy * y - xz * z) * ax
        magnitude = np.sqrt(x * x + y * y + z * z)
        inverse = 1.0 / magnitude
        # the rows of inv(A)' times the unit vector
        wx = x * inverse * ax
        wz = (z * inverse - xz * wx) * az
        wy = (y * inverse - xy * wx - zy * wz) * ay
        rows = empty_as(x, (*x.shape, 9))
        for k, (weight, factor) in enumerate(((wx, x), (wy, y), (wz, z))):
            rows[..., k] = weight
            np.multiply(weight, factor, out=rows[..., 3 + k])
        for k, (weight, factor) in enumerate(((wx, y), (wx, z), (wz, y)), 6):
            np.multiply(weight, factor, out=rows[..., k])
        return magnitude - 1.0, self._chosen(rows)

    def _chosen(self, rows: Array) -> Array:
        return rows if len(self._columns) == 9 else rows[..., self._columns]


def _force(stimulus: Stimulus) -> Array:
    assert stimulus.specific_force is not None  # Model.check has refused a stand without it
    return stimulus.specific_force
