"""Scalar (invariant) calibration of an accelerometer triad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

import numpy as np

from acalx.models.prior import noise_of, require_told
from acalx.models.sensor_model import SensorModel
from acalx.models.vectors import Magnitude
from acalx.numerics.arrays import Array, components, empty_as
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import AccelTriad
from acalx.sensors.base import suits
from acalx.sensors.triads import GROUPS

__all__ = ["ScalarAccel"]

_NINE = AccelTriad().parameters


@final
@dataclass(frozen=True)
class ScalarAccel(SensorModel):
    """Nine parameters of an accelerometer triad, from the magnitude of gravity.

    In a position with the vertical eta = (ex, ey, ez) in sensor axes the triad reads W, in g:

        W = bias + A eta,   A = I + diag(scale) + [[0, xy, xz], [0, 0, 0], [0, zy, 0]].

    The residual J of the magnitude is then, to first order in the parameters X,

        J = h X,   h = (ex, ey, ez, ex^2, ey^2, ez^2, ex ey, ex ez, ez ey).

    Standard deviations come out in the units of the parameters where `noise_g` is told, otherwise in units of the
    standard deviation of J. It is an `AccelTriad` compared by its
    `Magnitude`, with the arithmetic of both written out: what most people calibrate, and what has to be fast.

    Parameters
    ----------
    groups : sequence of str
        The groups of parameters that are estimated; the others are taken for zero. Without
        ``nonorthogonality`` the six faces of a cube are enough.
    noise_g : float, g, optional
        Standard deviation of a reading. None: it is 1, and results are in units of it.
    prior : mapping of str to float
        As of `Compared`; it takes a noise that is told.

    Raises
    ------
    ArgumentError
        No groups, or one that there isn't; a noise that is not positive; a prior as of `Compared`, or without a noise.

    Source: Egorov, Kiryachenko, Popov (2021).
    """

    usual: ClassVar[Mapping[str, Any]] = suits(criterion=None, errors=None, n=9)
    tells_noise: ClassVar[str] = "noise_g"
    groups: Sequence[str] = GROUPS
    noise_g: float | None = None

    def __post_init__(self) -> None:
        triad = AccelTriad(groups=self.groups, noise_g=self._deviation)
        object.__setattr__(self, "groups", triad.groups)  # in their order
        self._compare(triad, Magnitude())
        require_told("noise_g", self.noise_g, self.prior, 1e-4)

    @cached_property
    def _deviation(self) -> float:
        """Standard deviation of J: that of a reading, whatever the direction."""
        return noise_of("noise_g", self.noise_g)

    @cached_property
    def _columns(self) -> list[int]:
        """Which of the nine parameters are estimated."""
        return [k for k, parameter in enumerate(_NINE) if parameter.group in self.groups]

    # ---- as `SensorModel` has them, in fewer steps

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows h of the magnitude, (..., n, 1, p), over its noise: the vertical, its squares and products."""
        if not stimulus.plain:
            return super().regressors(stimulus)
        force = stimulus["specific_force"]
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
        if not stimulus.plain:
            return super().derivative(stimulus)
        force = stimulus["specific_force"]
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
        return Stimulus(specific_force=self._over_noise(chosen)[..., None, :, :])

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the rows, (..., n, 1, p), to the specific force, (..., n, 3)."""
        if not stimulus.plain:
            return super().pull(stimulus, rows)
        by_force = self.derivative(stimulus)["specific_force"]
        return Stimulus(specific_force=np.einsum("...nmp,...nmpk->...nk", rows, by_force))

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Noise-free readings W (..., n, 3) of a triad with these errors (..., p), in g."""
        if not stimulus.plain:
            return super().readings(parameters, stimulus)
        bx, by, bz, sx, sy, sz, xy, xz, zy = self._nine(parameters)
        x, y, z = np.moveaxis(stimulus["specific_force"], -1, 0)
        return components(bx + x + (sx * x + xy * y + xz * z), by + y + sy * y, bz + z + (sz * z + zy * y))

    def linearized(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """|W| - 1 less h X, over the noise; where no attitude is known, the direction that was read is taken for it."""
        lengths = np.sqrt((readings * readings).sum(axis=-1))
        if known is None:
            known = Stimulus(specific_force=readings / lengths[..., None])
        rows = self.regressors(known)[..., 0, :]
        explained = parameters @ rows.T if rows.ndim == 2 else np.einsum("...np,...p->...n", rows, parameters)
        return self._over_noise(lengths - 1.0) - explained, rows

    def residual(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """What is left of the residual of the magnitude once these errors are taken off, and its rows.

        J = |eta| - 1 with eta = inv(A) (W - bias); to first order J = h (X - parameters). At zero
        parameters these are |W| - 1 and the rows of the direction that was read,
        times its magnitude in the places of scale and non-orthogonality. Both over the noise.
        """
        bx, by, bz, sx, sy, sz, xy, xz, zy = self._nine(parameters)
        ax, ay, az = 1.0 / (1.0 + sx), 1.0 / (1.0 + sy), 1.0 / (1.0 + sz)
        # A is triangular once z and y change places: no elimination is needed
        y = (readings[..., 1] - by) * ay
        z = (readings[..., 2] - bz - zy * y) * az
        x = (readings[..., 0] - bx - xy * y - xz * z) * ax
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
        return self._over_noise(magnitude - 1.0), self._chosen(rows)

    def _nine(self, parameters: Array) -> Array:
        """All nine parameters, (9, ..., 1), for those that are estimated, (..., p)."""
        full = np.zeros((*parameters.shape[:-1], 9))
        full[..., self._columns] = parameters
        return np.moveaxis(full, -1, 0)[..., None]

    def _chosen(self, rows: Array) -> Array:
        """The rows of the parameters that are estimated, over the noise."""
        return self._over_noise(rows if len(self._columns) == 9 else rows[..., self._columns])

    def _over_noise(self, values: Array) -> Array:
        return values if self.noise_g is None else values / self._deviation
