"""Comparisons of vectors of which not all is known: a magnitude, a projection, an angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError
from acalx.models.comparisons import Comparison, Residual
from acalx.models.sensed import along, of_sensor, unit_length
from acalx.models.table import Entry
from acalx.numerics.arrays import Array
from acalx.options import is_number, keep, require_switch
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["Angle", "Magnitude", "Projection"]


@final
@dataclass(frozen=True)
class Magnitude(Comparison):
    """Only the length of a vector is known: of gravity at rest, of the magnetic field, of a rate.

    The residual is |s| - |s0|, with s what the readings say was felt, once the errors are taken off, and s0
    what is known of it. Of the attitude nothing need be known.

    Parameters
    ----------
    quantity : str, optional
        A vector that the sensor senses; the only one where it is not given.
    varies : bool
        Whether the length differs between positions, as of a rate, and must be known for each. Otherwise it is 1,
        in the unit of the stimulus: gravity, or the strength of the field.

    Source: Egorov, Kiryachenko, Popov (2021), equation (2).
    """

    quantity: str | None = None
    varies: bool = False

    def __post_init__(self) -> None:
        _require_quantity(self.quantity)
        object.__setattr__(self, "varies", require_switch("varies", self.varies))

    def check(self, sensor: Sensor) -> None:
        """Refuse a sensor whose readings do not give the vector, or a length that nobody knows."""
        of_sensor(sensor, self.quantity, "magnitude")
        self.lengths(sensor)

    def count(self, sensor: Sensor) -> int:
        """One a position, a length."""
        return 1

    def knows(self, sensor: Sensor) -> tuple[str, ...]:
        """What the sensor needs beside what it senses; a length that varies too."""
        others = tuple(name for name in sensor.needs if name not in sensor.senses)
        return (*others, of_sensor(sensor, self.quantity)) if self.varies else others

    @property
    def by_length(self) -> bool:
        """Unless the length varies."""
        return not self.varies

    def lengths(self, sensor: Sensor) -> Mapping[str, float]:
        """That of the vector, unless it varies."""
        quantity = of_sensor(sensor, self.quantity)
        return {} if self.varies else {quantity: unit_length(sensor, quantity)}

    def entries(self, sensor: Sensor, noise: Array) -> list[Entry] | None:
        """The readings along the vector, where it has length 1 and they are nothing else."""
        return None if self.varies else along(sensor, of_sensor(sensor, self.quantity), noise)

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """|s| - |s0|, its rows u' inv(S) G, with u = s / |s|, S and G the derivatives of the readings by s and X."""
        quantity = of_sensor(sensor, self.quantity)
        felt = sensor.felt(parameters, readings, known)
        vector = felt[quantity]
        length = np.sqrt((vector * vector).sum(axis=-1, keepdims=True))
        target: Array | float
        if self.varies:
            assert known is not None  # `knows` says so
            target = _lengths(known[quantity])
        else:
            target = unit_length(sensor, quantity)
        with np.errstate(invalid="ignore", divide="ignore"):  # nan where nothing was felt
            slopes = {quantity: (vector / length)[..., None, :]}
        return _by_felt(sensor, parameters, felt, length - target, slopes)


@final
@dataclass(frozen=True)
class Projection(Comparison):
    """The readings along the known direction of a vector: W . eta - 1 where they are to be of gravity.

    Linear in the errors, and as good as the knowledge of the direction.

    Parameters
    ----------
    quantity : str, optional
        A vector that the sensor senses; the only one where it is not given.

    Source: Egorov, Kiryachenko, Popov (2021), equation (1).
    """

    quantity: str | None = None

    def __post_init__(self) -> None:
        _require_quantity(self.quantity)

    def check(self, sensor: Sensor) -> None:
        """Refuse a sensor whose readings are not the three components of the vector."""
        quantity = of_sensor(sensor, self.quantity, "projection")
        if sensor.senses != (quantity,):
            raise CompatibilityError(f"{type(sensor).__name__} reads more than the {quantity.replace('_', ' ')}")
        self.lengths(sensor)

    def count(self, sensor: Sensor) -> int:
        """One a position, a component."""
        return 1

    @property
    def at_once(self) -> bool:
        """It is linear in what was felt, means included."""
        return False

    def lengths(self, sensor: Sensor) -> Mapping[str, float]:
        """That of the vector that is projected on."""
        quantity = of_sensor(sensor, self.quantity)
        return {quantity: unit_length(sensor, quantity)}

    def entries(self, sensor: Sensor, noise: Array) -> list[Entry] | None:
        """The readings along the vector, where it has length 1 and they are nothing else."""
        return along(sensor, of_sensor(sensor, self.quantity), noise)

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """eta' (W - f(X, s)), and eta' times the derivatives of f."""
        assert known is not None  # `knows` says all of it
        vector = known[of_sensor(sensor, self.quantity)]
        along = (vector / _lengths(vector))[..., None, :]
        left = readings - sensor.readings(parameters, known)
        rows = along @ sensor.by_parameters(parameters, known)
        return Residual((along @ left[..., None])[..., 0], rows, along)


@final
@dataclass(frozen=True)
class Angle(Comparison):
    """The angle between two vectors, as of gravity and the magnetic field, which is the same in every attitude.

    The residual is that of the cosine, c - c0.

    Parameters
    ----------
    quantities : pair of str
        Vectors that the sensor senses.
    angle_deg : float, optional
        Between them, where it is known: 90 degrees and the dip for the specific force, which points up at rest, and the
        magnetic field. Of the attitude nothing need be known then. None: it follows from the attitude of each position.
    """

    quantities: Sequence[str] = ("specific_force", "magnetic_field")
    angle_deg: float | None = None

    def __post_init__(self) -> None:
        given = self.quantities
        if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2 or given[0] == given[1]:
            raise ArgumentError.of(
                "quantities", given, "give two different vectors", ["specific_force", "angular_rate"]
            )
        keep(self, "quantities")
        angle = self.angle_deg
        if angle is not None and (not is_number(angle) or not 0.0 < angle < 180.0):
            raise ArgumentError.of("angle_deg", angle, "the angle between two vectors lies between 0 and 180 degrees")

    def check(self, sensor: Sensor) -> None:
        """Refuse a sensor whose readings do not give both vectors."""
        for quantity in self.quantities:
            of_sensor(sensor, quantity, "angle")

    def count(self, sensor: Sensor) -> int:
        """One a position, a cosine."""
        return 1

    def knows(self, sensor: Sensor) -> tuple[str, ...]:
        """The attitude, unless the angle is known."""
        return tuple(name for name in sensor.needs if self.angle_deg is None or name not in sensor.senses)

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """u . v - c0 for unit vectors u and v of what was felt, and its rows."""
        felt = sensor.felt(parameters, readings, known)
        (u, size), (v, other) = (_unit(felt[name]) for name in self.quantities)
        cosine = (u * v).sum(axis=-1, keepdims=True)
        value = cosine - self._known(known)
        one, two = self.quantities
        slopes = {one: ((v - cosine * u) / size)[..., None, :], two: ((u - cosine * v) / other)[..., None, :]}
        return _by_felt(sensor, parameters, felt, value, slopes)

    def _known(self, known: Stimulus | None) -> Array | float:
        """The cosine as it should be, (..., n, 1), or one for all."""
        if self.angle_deg is not None:
            return math.cos(math.radians(self.angle_deg))
        assert known is not None  # `knows` says all of it
        (first, _), (second, _) = (_unit(known[name]) for name in self.quantities)
        return np.asarray((first * second).sum(axis=-1, keepdims=True))


def _by_felt(sensor: Sensor, parameters: Array, felt: Stimulus, value: Array, slopes: dict[str, Array]) -> Residual:
    """A residual of what was felt, with its slopes (..., n, m, width) by the quantities that it depends on."""

    def by_readings(at: Array) -> Array:
        """phi_z inv(S): what a change of the readings does to it, for a sensor with these parameters."""
        by_stimulus = sensor.by_stimulus(at, felt)
        matrix = np.concatenate([by_stimulus[name] for name in sensor.senses], axis=-1)
        m = value.shape[-1]
        full = [slopes.get(name, np.zeros((*value.shape, felt[name].shape[-1]))) for name in sensor.senses]
        phi = np.concatenate([np.broadcast_to(each, (*value.shape, each.shape[-1])) for each in full], axis=-1)
        turned = np.broadcast_to(matrix.swapaxes(-1, -2), (*value.shape[:-1], *matrix.shape[-2:]))
        right = np.broadcast_to(phi, (*value.shape[:-1], m, phi.shape[-1])).swapaxes(-1, -2)
        with np.errstate(invalid="ignore"):
            solved = _solved(turned, right)
        return solved.swapaxes(-1, -2)

    own, nominal = by_readings(parameters), sensor.nominal
    without_errors = own if np.array_equal(parameters, nominal) else by_readings(nominal)
    return Residual(value, own @ sensor.by_parameters(parameters, felt), without_errors)


def _require_quantity(quantity: object) -> None:
    if quantity is not None and not isinstance(quantity, str):
        raise ArgumentError.of("quantity", quantity, "give the name of a vector, such as specific_force, or null")


def _solved(matrix: Array, right: Array) -> Array:
    """Solutions of equations; nan where parameters went anywhere and there are none: `converged` tells."""
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=float)
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)


def _lengths(vector: Array) -> Array:
    return np.asarray(np.sqrt((vector * vector).sum(axis=-1, keepdims=True)))


def _unit(vector: Array) -> tuple[Array, Array]:
    """A vector (..., w) over its length, and the length (..., 1)."""
    length = _lengths(vector)
    with np.errstate(invalid="ignore", divide="ignore"):
        return vector / length, length
