"""Lengths and an angle of channels that each have their own noise, which is then correlated: from the physics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from acalx.models import Angle, Compared, Magnitude, Together
from acalx.numerics.arrays import Array
from acalx.sensors import AccelMagnetometer, Channel, Polynomial, Term
from acalx.stands import TwoAxis

SIGMA = np.array([1e-3, 5e-4, 3e-3, 5e-3, 2e-2, 1e-3])
DIP, AZIMUTH = np.radians(65.0), np.radians(70.0)
BOTH = Together([Magnitude("specific_force"), Magnitude("magnetic_field"), Angle()])


@dataclass(frozen=True)
class Uneven(Polynomial):
    senses: ClassVar[tuple[str, ...]] = AccelMagnetometer().senses
    terms: ClassVar[tuple[Term, ...]] = AccelMagnetometer().terms

    @property
    def channels(self) -> tuple[Channel, ...]:
        known = AccelMagnetometer().channels
        return tuple(Channel(one.name, one.unit, float(noise)) for one, noise in zip(known, SIGMA, strict=True))


NAMES = [parameter.name for parameter in Uneven().parameters]


def attitude(first: float, second: float) -> Array:
    """From axes of the room to those of a sensor that turned about -y, then about x."""
    s, c, u, v = np.sin(first), np.cos(first), np.sin(second), np.cos(second)
    return np.array([[1, 0, 0], [0, v, u], [0, -u, v]]) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def readings(errors: dict[str, float], turned: Array) -> Array:
    """Accelerometers in g, then magnetometers, whose axes are turned by small angles, in units of the field."""
    level = np.cos(DIP)
    outside = [[0.0, 0.0, 1.0], [level * np.cos(AZIMUTH), level * np.sin(AZIMUTH), -np.sin(DIP)]]
    found = []
    for sensor, felt in zip(("accel", "magnetometer"), (turned @ np.array(each) for each in outside), strict=True):

        def error(kind: str, sensor: str = sensor) -> float:
            return errors.get(f"{sensor}_{kind}", 0.0)

        matrix = np.diag([1.0 + error(f"scale_{axis}") for axis in "xyz"])
        matrix[0, 1], matrix[0, 2] = error("nonorthogonality_xy"), error("nonorthogonality_xz")
        matrix[2, 1] = error("nonorthogonality_zy")
        found.append(np.array([error(f"bias_{axis}") for axis in "xyz"]) + matrix @ felt)
        if sensor == "magnetometer":
            found[-1] -= np.cross([errors.get(f"alignment_{axis}", 0.0) for axis in "xyz"], felt)
    return np.concatenate(found)


def aspects(both: Array) -> Array:
    """Two lengths and the cosine between them, as a sensor without errors has them."""
    one, two = both[:3], both[3:]
    lengths = np.linalg.norm(one), np.linalg.norm(two)
    return np.array([*lengths, one @ two / (lengths[0] * lengths[1])])


def slope(function: Callable[[float], Array], step: float = 1e-3) -> Array:
    near, far = (function(m * step) - function(-m * step) for m in (1, 2))
    return (8.0 * near - far) / (12.0 * step)


def derivatives(turned: Array) -> tuple[Array, Array]:
    """Of what is compared, by the errors and by the readings."""
    clean = readings({}, turned)
    by_errors = [slope(lambda h, name=name: aspects(readings({name: h}, turned))) for name in NAMES]
    by_readings = [slope(lambda h, unit=unit: aspects(clean + h * unit)) for unit in np.eye(6)]
    return np.stack(by_errors, axis=-1), np.stack(by_readings, axis=-1)


@pytest.mark.parametrize("seed", range(3))
def test_noise_that_residuals_share_is_taken_out(seed: int) -> None:
    stand = TwoAxis(dip_deg=np.degrees(DIP), field_azimuth_deg=np.degrees(AZIMUTH))
    settings = stand.axes.random(np.random.default_rng(seed), (15,))
    expected, shared = np.zeros((len(NAMES),) * 2), 0.0
    for first, second in settings:
        rows, by_readings = derivatives(attitude(first, second))
        covariance = by_readings @ np.diag(SIGMA**2) @ by_readings.T
        sizes = np.sqrt(np.diag(covariance))
        shared = max(shared, float(np.abs(covariance / np.outer(sizes, sizes) - np.eye(3)).max()))
        expected += rows.T @ np.linalg.inv(covariance) @ rows
    assert shared > 0.5
    found = Compared(Uneven(), BOTH).information(stand.stimulus(settings)).matrix
    size = np.sqrt(np.diag(expected))
    assert np.abs((found - expected) / np.outer(size, size)).max() < 1e-8


def test_the_magnetometer_is_turned_as_its_description_says() -> None:
    stand = TwoAxis(dip_deg=np.degrees(DIP), field_azimuth_deg=np.degrees(AZIMUTH))
    settings = stand.axes.random(np.random.default_rng(4), (5,))
    truth = 0.1 * np.random.default_rng(5).standard_normal(len(NAMES))
    found = Uneven().readings(truth, stand.stimulus(settings))
    expected = [readings(dict(zip(NAMES, truth, strict=True)), attitude(*position)) for position in settings]
    np.testing.assert_allclose(found, expected, atol=1e-13)
