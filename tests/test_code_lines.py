"""A whole unit and its rate table as somebody outside would write them: sixty code lines, and the same information."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from acalx import IMU, AccelTemperature, Chamber, D, TwoAxisRateTable
from acalx.models import as_model
from acalx.problem import Problem
from costs import code_lines

UNIT = '''
"""Three accelerometers and three gyros with lever arms, 45 parameters, on a table that turns about two axes."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx import Channel, Parameter, Polynomial, Setting, Stand, Stimulus, Term
from acalx.quantities.stimulus import EARTH_RATE
from acalx.quantities.units import DEGREE_PER_SECOND

G, RATE = 9.80665, math.degrees(EARTH_RATE)
TURNING = EARTH_RATE**2 / G
NODES, SIZES = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True)
class Unit(Polynomial):
    @property
    def channels(self):
        kinds = (("a", "g", 1e-4), ("g", "deg/s", 0.01))
        return tuple(Channel(kind + axis, unit, noise) for kind, unit, noise in kinds for axis in "xyz")

    @cached_property
    def terms(self):
        return tuple(term for k, axes in enumerate(("xyz", "yzx", "zxy")) for term in self.of_axis(k, *axes))

    def of_axis(self, k, own, j, m):
        def of(sensor, group, unit, *products, axis=""):
            parameter = Parameter(f"{sensor}_{group}_{own}{axis}", f"{sensor}_{group}", unit)
            channel = k if sensor == "accel" else k + 3
            return [Term(parameter, word, factor, channel) for word, factor in products]

        for sensor, letter, factor, unit in (("accel", "f", 1.0, "g"), ("gyro", "w", RATE, "deg/s")):
            yield Term(None, letter + own, factor, k if sensor == "accel" else k + 3)
            yield from of(sensor, "bias", unit, ("", 1.0))
            yield from of(sensor, "scale", "1", (letter + own, factor))
            for other in (j, m):
                yield from of(sensor, "misalignment", "rad", (letter + other, factor), axis=other)
        for axis in "xyz":
            yield from of("gyro", "g_sensitivity", "deg/s/g", (f"f{axis}", 1.0), axis=axis)
        yield from of("accel", "quadratic", "1/g", (f"f{own} f{own}", 1.0))
        yield from of("accel", "arm", "m", (f"w{j} w{j}", -TURNING), (f"w{m} w{m}", -TURNING), axis=own)
        yield from of("accel", "arm", "m", (f"w{own} w{j}", TURNING), (f"a{m}", -1.0 / G), axis=j)
        yield from of("accel", "arm", "m", (f"w{own} w{m}", TURNING), (f"a{j}", 1.0 / G), axis=m)


@dataclass(frozen=True, eq=False)
class Table(Stand):
    latitude_deg: float = 34.25

    @property
    def settings(self):
        angles = (Setting(name, 0.0, 2.0 * math.pi) for name in ("outer", "inner"))
        most = math.radians(100.0)
        names = ("outer_rate", "inner_rate")
        return (*angles, *(Setting(name, -most, most, None, False, DEGREE_PER_SECOND) for name in names))

    def stimulus(self, settings):
        outer_rate, inner_rate = settings[..., 2, None], settings[..., 3, None]
        outer = settings[..., 0, None] + 0.5 * NODES * outer_rate
        inner = settings[..., 1, None] + 0.5 * NODES * inner_rate
        (s, c), (u, v) = ((np.sin(angle), np.cos(angle)) for angle in (outer, inner))

        def seen(y, z):
            y, z = c * y + s * z, c * z - s * y
            return np.stack([u * y, v * y, z], axis=-1)

        turning = np.stack([outer_rate * v, -outer_rate * u, inner_rate + 0.0 * v], axis=-1) / EARTH_RATE
        change = (outer_rate * inner_rate)[..., None] * np.stack([-u, -v, 0.0 * v], axis=-1)
        latitude = math.radians(self.latitude_deg)
        rate = seen(math.cos(latitude), math.sin(latitude)) + turning
        felt = {"specific_force": seen(0.0, 1.0), "angular_rate": rate, "angular_acceleration": change}
        return Stimulus(felt, weights=SIZES / 2.0)
'''
ARMS = [own + axis for own in "xyz" for axis in "xyz"]
ROOT = Path(__file__).parents[1] / "src" / "acalx"


@pytest.fixture(scope="module")
def lab() -> Iterator[dict[str, Any]]:
    module = ModuleType("lab_of_units")
    sys.modules[module.__name__] = module  # where dataclasses look
    exec(UNIT, module.__dict__)
    yield module.__dict__
    del sys.modules[module.__name__]


def test_a_unit_and_its_table_take_sixty_lines() -> None:
    assert code_lines(UNIT) <= 60


def test_they_show_what_the_shipped_ones_show(lab: dict[str, Any]) -> None:
    own, shipped = as_model(lab["Unit"]()), as_model(IMU(arms=ARMS))
    names = [parameter.name for parameter in own.parameters]
    order = [names.index(parameter.name) for parameter in shipped.parameters]
    assert len(order) == len(names) == 45
    groups = {parameter.name: parameter.group for parameter in shipped.parameters}
    assert {parameter.name: parameter.group for parameter in own.parameters} == groups
    table, other = TwoAxisRateTable(), lab["Table"]()
    settings = table.axes.random(np.random.default_rng(3), (24,))
    expected = shipped.information(table.stimulus(settings)).matrix
    found = own.information(other.stimulus(settings)).matrix[np.ix_(order, order)]
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(found / size, expected / size, atol=1e-9)


def test_their_numerical_gradient_is_the_exact_one_of_the_shipped(lab: dict[str, Any]) -> None:
    arms = IMU().arms  # no rate shows the others, whose loss would be infinite
    settings = TwoAxisRateTable().axes.random(np.random.default_rng(4), (24,))
    _, exact = Problem(TwoAxisRateTable(), as_model(IMU(arms=arms)), D(), 24).loss_and_gradient(settings)
    _, numerical = Problem(lab["Table"](), as_model(IMU(arms=arms)), D(), 24).loss_and_gradient(settings)
    np.testing.assert_allclose(numerical, exact, atol=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("files", "most"),
    [
        (("sensors/imu.py", "stands/two_axis_rate_table.py"), 60),
        (("sensors/accel_temperature.py", "stands/chamber.py"), 40),
    ],
)
def test_shipped_files_are_short(files: tuple[str, ...], most: int) -> None:
    assert sum(code_lines((ROOT / file).read_text(encoding="utf-8")) for file in files) <= most
    assert Chamber().stimulus(np.zeros((1, 3))).keys() >= set(AccelTemperature().needs)
