"""A stand of three axes that all turn at once, which says only its axes, limits and surroundings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np
import pytest

from acalx import IMU, D, Problem
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import EARTH_RATE
from acalx.quantities.units import DEGREE_PER_SECOND
from acalx.stands import Setting
from acalx.stands.fields import limits, step
from acalx.stands.turning import Turning
from acalx.stands.turns import UP, Vector
from acalx.testing import check_stand

RATE = math.radians(100.0)


@dataclass(frozen=True)
class Gimbals(Turning):
    """Three axes, one of them the wrong way round."""

    turns: ClassVar[Mapping[str, str]] = {"base": "z", "outer": "-y", "inner": "x"}
    surroundings: ClassVar[Mapping[str, Vector]] = {"specific_force": UP, "angular_rate": (0.6, None, 0.8)}
    base_deg: Sequence[float] = limits(0.0, 360.0)
    outer_deg: Sequence[float] = limits(0.0, 360.0)
    inner_deg: Sequence[float] = limits(-90.0, 90.0)
    base_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    outer_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    inner_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    _: KW_ONLY
    base_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    outer_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    inner_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)


def attitude(angles: Array) -> Array:
    """From the room to the sensor, as a product of three matrices."""

    def turn(axis: int, angle: float) -> Array:
        u, v = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[u, u] = matrix[v, v] = math.cos(angle)
        matrix[u, v], matrix[v, u] = math.sin(angle), -math.sin(angle)
        return matrix

    base, outer, inner = angles
    return turn(0, inner) @ turn(1, -outer) @ turn(2, base)


def turning(angles: Array, rates: Array) -> Array:
    """The rate of the sensor in its axes, from how its attitude changes: C' C^T is minus the cross product with it."""
    h = 1e-6
    slope = (attitude(angles + h * rates) - attitude(angles - h * rates)) / (2.0 * h)
    cross = -slope @ attitude(angles).T
    return np.array([cross[2, 1], cross[0, 2], cross[1, 0]])


@pytest.mark.parametrize("averaging_s", [0.0, 1.0])
def test_it_keeps_the_contract_of_a_stand(averaging_s: float) -> None:
    check_stand(Gimbals(averaging_s=averaging_s))


def test_settings_are_angles_and_then_rates() -> None:
    names = [setting.name for setting in Gimbals().settings]
    assert names == ["base", "outer", "inner", "base_rate", "outer_rate", "inner_rate"]
    assert isinstance(Gimbals(base_rate_step_deg_s=10.0).settings[3], Setting)
    assert Gimbals(base_rate_step_deg_s=10.0).settings[3].step == pytest.approx(math.radians(10.0))


def test_what_is_felt_is_how_the_attitude_changes() -> None:
    rng = np.random.default_rng(0)
    stand = Gimbals(averaging_s=0.0)
    settings = stand.axes.random(rng, (10,))
    felt = stand.stimulus(settings)
    for k, (angles, rates) in enumerate(zip(settings[:, :3], settings[:, 3:], strict=True)):
        seen = attitude(angles)
        np.testing.assert_allclose(felt["specific_force"][k], seen @ [0.0, 0.0, 1.0], atol=1e-14)
        rate = turning(angles, rates) + EARTH_RATE * (seen @ [0.6, 0.0, 0.8])
        np.testing.assert_allclose(felt["angular_rate"][k] * EARTH_RATE, rate, atol=1e-8)
        h = 1e-4
        change = (turning(angles + h * rates, rates) - turning(angles - h * rates, rates)) / (2.0 * h)
        np.testing.assert_allclose(felt["angular_acceleration"][k], change, atol=1e-5)


def test_a_third_axis_shows_all_lever_arms() -> None:
    """On two axes what both rates do to the arms xz and yz cancels."""
    every = [own + axis for own in "xyz" for axis in "xyz"]
    stand = Gimbals()
    settings = stand.axes.random(np.random.default_rng(1), (30,))
    assert not Problem(stand, IMU(arms=every), D(), 30).information(settings).singular
