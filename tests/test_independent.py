"""Information by another route: readings from their formulas, differentiated here, in doubles and with 50 digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import integrate

from acalx import IMU, AccelMagnetometer, Angle, Compared, Magnitude, Together, TwoAxis, TwoAxisRateTable
from acalx.models import as_model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import EARTH_RATE, Stimulus
from acalx.sensors import Sensor
from acalx.stands.motion import TOLERANCES

G = 9.80665
NINE = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"]
FORCE, FIELD, RATE = "specific_force", "magnetic_field", "angular_rate"
PAIR = Compared(AccelMagnetometer(), Together([Magnitude(FORCE), Magnitude(FIELD), Angle()]))
LEVEL = TwoAxis(dip_deg=65, field_azimuth_deg=90)
# A tenth of a second: the rule of the table is then exact to rounding, and what is compared is all the rest.
BRIEF = TwoAxisRateTable(averaging_s=0.1, azimuth_deg=20.0)


def positions(stand: Any, n: int, seed: int) -> Array:
    settings: Array = stand.axes.random(np.random.default_rng(seed), (n,))
    if settings.shape[1] == 4:
        settings[::3, 2:] = 0.0  # at rest, as most programs have it
    return settings


def assert_same(found: Array, expected: Array, tolerance: float) -> None:
    """Entries of two matrices agree, each beside the diagonal of its row and its column."""
    own = np.diag(expected)
    own = np.maximum(own, 1e-12 * own.max())  # what no position shows is zero up to rounding
    size = np.sqrt(np.outer(own, own))
    assert np.abs((found - expected) / size).max() <= tolerance


# ---------------------------------------------------------------- by differences of the readings


def slope(function: Callable[[float], Array], step: float) -> Array:
    """A derivative at zero, by differences and one step of Richardson."""
    wide, narrow = ((function(h) - function(-h)) / (2.0 * h) for h in (step, step / 2.0))
    return (4.0 * narrow - wide) / 3.0


def by_parameters(sensor: Sensor, felt: Stimulus) -> Array:
    """Derivatives of the readings of a sensor without errors, (n, k, p)."""
    unit = np.eye(len(sensor.parameters))
    columns = [slope(lambda h, e=e: sensor.readings(sensor.nominal + h * e, felt), 1e-2) for e in unit]  # type: ignore[misc]
    return np.stack(columns, axis=-1)


def by_felt(sensor: Sensor, felt: Stimulus, names: list[str]) -> Array:
    """Derivatives of the same readings by components of what is felt, (n, k, 3 for each quantity)."""

    def moved(name: str, axis: int) -> Array:
        shift = np.eye(3)[axis]
        return slope(lambda h: sensor.readings(sensor.nominal, felt.made({**felt, name: felt[name] + h * shift})), 1e-2)

    return np.stack([moved(name, axis) for name in names for axis in range(3)], axis=-1)


def assembled(rows: Array, by_readings: Array, sigma: Array) -> Array:
    """Sum over positions of R' inv(J S J') R."""
    total = np.zeros((rows.shape[-1],) * 2)
    for r, j in zip(rows, by_readings, strict=True):
        total += r.T @ np.linalg.inv(j @ np.diag(sigma**2) @ j.T) @ r
    return total


def moving(table: TwoAxisRateTable, settings: Array, t: float) -> dict[str, Array]:
    """What is felt on the rate table t s from the middle of a reading, by rotation matrices, in g and rad/s."""
    felt: dict[str, list[Array]] = {FORCE: [], RATE: [], "angular_acceleration": []}
    latitude, azimuth = np.radians([table.latitude_deg, table.azimuth_deg])
    level = np.cos(latitude)
    earth = EARTH_RATE * np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(latitude)])
    for outer, inner, outer_rate, inner_rate in settings:
        (s, c), (u, v) = ((np.sin(x), np.cos(x)) for x in (outer + t * outer_rate, inner + t * inner_rate))
        rx = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
        rz = np.array([[v, u, 0], [-u, v, 0], [0, 0, 1]])
        felt[FORCE].append(rz @ rx @ [0, 0, 1])
        felt[RATE].append(rz @ rx @ earth + outer_rate * rz[:, 0] + [0, 0, inner_rate])
        # the outer axis, seen from what turns with the inner rate, goes the other way round
        felt["angular_acceleration"].append(-np.cross([0, 0, inner_rate], outer_rate * rz[:, 0]))
    return {name: np.array(values) for name, values in felt.items()}


@pytest.mark.parametrize("arms", [IMU().arms, NINE], ids=len)
@pytest.mark.parametrize("seed", range(4))
def test_an_imu_has_the_information_that_differences_of_its_readings_give(seed: int, arms: list[str]) -> None:
    sensor, settings = IMU(arms=arms), positions(BRIEF, 12, seed)
    rows = np.zeros((len(settings), 6, len(sensor.parameters)))
    nodes, sizes = np.polynomial.legendre.leggauss(10)
    for node, size in zip(nodes, sizes, strict=True):
        felt = moving(BRIEF, settings, 0.5 * BRIEF.averaging_s * node)
        at = Stimulus({**felt, RATE: felt[RATE] / EARTH_RATE})
        rows += 0.5 * size * by_parameters(sensor, at)
    sigma = np.array([sensor.accel_noise_g] * 3 + [sensor.gyro_noise_deg_s] * 3)
    expected = assembled(rows, np.broadcast_to(np.eye(6), (len(settings), 6, 6)), sigma)
    assert_same(as_model(sensor).information(BRIEF.stimulus(settings)).matrix, expected, 1e-7)


def aspects(force: Array, field: Array) -> Array:
    """Two lengths and the cosine between them, (..., 3)."""
    a, b = (np.sqrt((v * v).sum(axis=-1)) for v in (force, field))
    return np.stack([a, b, (force * field).sum(axis=-1) / (a * b)], axis=-1)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("azimuth", [0.0, 37.0, 90.0])
def test_a_pair_has_the_information_that_differences_of_its_readings_give(azimuth: float, seed: int) -> None:
    sensor, stand = PAIR.sensor, TwoAxis(dip_deg=-30, field_azimuth_deg=azimuth)
    felt = stand.stimulus(positions(stand, 12, seed))
    both = np.concatenate([felt[FORCE], felt[FIELD]], axis=-1)
    phi = np.stack(
        [slope(lambda h, e=e: aspects(*np.split(both + h * e, 2, axis=-1)), 1e-3) for e in np.eye(6)],  # type: ignore[misc]
        axis=-1,
    )
    by_readings = phi @ np.linalg.inv(by_felt(sensor, felt, [FORCE, FIELD]))
    rows = by_readings @ by_parameters(sensor, felt)
    expected = assembled(rows, by_readings, np.array([1e-3] * 3 + [5e-3] * 3))
    assert_same(PAIR.information(felt).matrix, expected, 1e-7)


# ---------------------------------------------------------------- with 50 digits


def vector(*components: Any) -> Any:
    return mpmath.matrix(components)


def cross(a: Any, b: Any) -> Any:
    return vector(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def about(axis: str, angle: Any) -> Any:
    """Components in axes that are turned about one of them."""
    s, c = mpmath.sin(angle), mpmath.cos(angle)
    if axis == "x":
        return mpmath.matrix([[1, 0, 0], [0, c, s], [0, -s, c]])
    if axis == "y":
        return mpmath.matrix([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return mpmath.matrix([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def table_motion(setting: list[Any], t: Any) -> tuple[Any, Any, Any]:
    """Specific force in g, rate in rad/s and its change on the table `BRIEF`."""
    outer, inner, outer_rate, inner_rate = setting
    latitude, azimuth = (mpmath.radians(mpmath.mpf(x)) for x in (BRIEF.latitude_deg, BRIEF.azimuth_deg))
    level = mpmath.cos(latitude)
    earth = mpmath.mpf(EARTH_RATE) * vector(
        level * mpmath.cos(azimuth), level * mpmath.sin(azimuth), mpmath.sin(latitude)
    )

    def turning(at: Any) -> Any:
        return about("z", inner + at * inner_rate) * vector(outer_rate, 0, 0) + vector(0, 0, inner_rate)

    attitude = about("z", inner + t * inner_rate) * about("x", outer + t * outer_rate)
    change = [mpmath.diff(lambda at, k=k: turning(at)[k], t) for k in range(3)]
    return attitude * vector(0, 0, 1), attitude * earth + turning(t), vector(*change)


def imu_reading(channel: int, errors: dict[str, Any], force: Any, rate: Any, change: Any) -> Any:
    """One of six channels, in g or deg/s, as the standards write it."""
    i = channel % 3
    own, others = "xyz"[i], [j for j in range(3) if j != i]

    def error(name: str) -> Any:
        return errors.get(name, 0)

    if channel < 3:
        arm = vector(*(error(f"accel_arm_{own}{axis}") for axis in "xyz"))
        moved = (cross(rate, cross(rate, arm)) + cross(change, arm))[i] / mpmath.mpf(G)
        skew = sum(error(f"accel_misalignment_{own}{'xyz'[j]}") * force[j] for j in others)
        square = error(f"accel_quadratic_{own}") * force[i] ** 2
        return error(f"accel_bias_{own}") + (1 + error(f"accel_scale_{own}")) * force[i] + skew + square + moved
    in_degrees = rate * 180 / mpmath.pi
    skew = sum(error(f"gyro_misalignment_{own}{'xyz'[j]}") * in_degrees[j] for j in others)
    by_force = sum(error(f"gyro_g_sensitivity_{own}{'xyz'[j]}") * force[j] for j in range(3))
    return error(f"gyro_bias_{own}") + (1 + error(f"gyro_scale_{own}")) * in_degrees[i] + skew + by_force


def as_numbers(matrix: Any) -> Array:
    return np.array(matrix.tolist(), dtype=float)


def test_an_imu_has_the_same_information_with_fifty_digits() -> None:
    sensor, settings = IMU(), positions(BRIEF, 9, 11)
    names = [parameter.name for parameter in sensor.parameters]
    with mpmath.workdps(50):
        near, _ = np.polynomial.legendre.leggauss(8)
        roots = [mpmath.findroot(lambda x: mpmath.legendre(8, x), mpmath.mpf(x)) for x in near]
        slopes = [mpmath.diff(lambda x: mpmath.legendre(8, x), root) for root in roots]
        weights = [1 / ((1 - x**2) * d**2) for x, d in zip(roots, slopes, strict=True)]  # which sum to 1
        half = mpmath.mpf(BRIEF.averaging_s) / 2
        total = mpmath.zeros(len(names))
        for setting in settings:
            felt = [table_motion([mpmath.mpf(value) for value in setting], half * x) for x in roots]
            for channel in range(6):
                sigma = mpmath.mpf(sensor.accel_noise_g if channel < 3 else sensor.gyro_noise_deg_s)

                def mean(name: str, size: Any, channel: int = channel, felt: list[Any] = felt) -> Any:
                    each = (imu_reading(channel, {name: size}, *at) for at in felt)
                    return sum(w * reading for w, reading in zip(weights, each, strict=True))

                row = mpmath.matrix([[mpmath.diff(lambda x, n=n: mean(n, x), 0) / sigma for n in names]])
                total += row.T * row
        expected = as_numbers(total)
    assert_same(as_model(sensor).information(BRIEF.stimulus(settings)).matrix, expected, 1e-10)


def pair_readings(errors: dict[str, Any], force: Any, field: Any) -> list[Any]:
    """Three accelerometers in g, three magnetometers in units of the field whose axes are turned by small angles."""

    def triad(name: str, s: Any, seen: Any) -> list[Any]:
        def error(kind: str) -> Any:
            return errors.get(f"{name}_{kind}", 0)

        skew = {
            0: error("nonorthogonality_xy") * s[1] + error("nonorthogonality_xz") * s[2],
            1: 0,
            2: error("nonorthogonality_zy") * s[1],
        }
        return [
            error(f"bias_{axis}") + error(f"scale_{axis}") * s[k] + skew[k] + seen[k] for k, axis in enumerate("xyz")
        ]

    small = vector(*(errors.get(f"alignment_{axis}", 0) for axis in "xyz"))
    return [*triad("accel", force, force), *triad("magnetometer", field, field - cross(small, field))]


def pair_aspects(readings: list[Any]) -> list[Any]:
    """What of the readings is compared: two lengths and a cosine."""
    first, second = readings[:3], readings[3:]
    a, b = (mpmath.sqrt(sum(x * x for x in v)) for v in (first, second))
    return [a, b, sum(x * y for x, y in zip(first, second, strict=True)) / (a * b)]


def test_a_pair_has_the_same_information_with_fifty_digits() -> None:
    settings, names = positions(LEVEL, 9, 12), [parameter.name for parameter in PAIR.parameters]
    with mpmath.workdps(50):
        dip, azimuth = mpmath.radians(65), mpmath.radians(90)
        level = mpmath.cos(dip)
        outside = vector(level * mpmath.cos(azimuth), level * mpmath.sin(azimuth), -mpmath.sin(dip))
        noise = mpmath.diag([mpmath.mpf(1e-3) ** 2] * 3 + [mpmath.mpf(5e-3) ** 2] * 3)
        total = mpmath.zeros(len(names))
        for a1, a2 in settings:
            attitude = about("x", mpmath.mpf(a2)) * about("y", -mpmath.mpf(a1))
            force, field = attitude * vector(0, 0, 1), attitude * outside
            exact = pair_readings({}, force, field)

            def moved(k: int, size: Any, exact: list[Any] = exact) -> list[Any]:
                return [value + (size if k == j else 0) for j, value in enumerate(exact)]

            def seen(name: str, size: Any, force: Any = force, field: Any = field) -> list[Any]:
                return pair_aspects(pair_readings({name: size}, force, field))

            j = mpmath.matrix(3, 6)
            rows = mpmath.matrix(3, len(names))
            for m in range(3):
                for k in range(6):
                    j[m, k] = mpmath.diff(lambda x, k=k, m=m: pair_aspects(moved(k, x))[m], 0)
                for k, name in enumerate(names):
                    rows[m, k] = mpmath.diff(lambda x, name=name, m=m: seen(name, x)[m], 0)
            total += rows.T * (j * noise * j.T) ** -1 * rows
        expected = as_numbers(total)
    assert_same(PAIR.information(LEVEL.stimulus(settings)).matrix, expected, 1e-10)


# ---------------------------------------------------------------- means along a motion


@pytest.mark.parametrize(
    ("averaging_s", "rate"), [(0.1, 100.0), (1.0, 100.0), (3.0, 100.0), (10.0, 100.0), (60.0, 30.0)]
)
def test_means_along_a_turn_are_those_of_the_motion(averaging_s: float, rate: float) -> None:
    table = TwoAxisRateTable(averaging_s=averaging_s, outer_rate_deg_s=(-rate, rate), inner_rate_deg_s=(-rate, rate))
    settings = positions(table, 6, 21)
    settings[:2, 2:] = np.radians([[rate, rate], [rate, -rate]])
    stimulus = table.stimulus(settings)
    weights = stimulus.weights
    assert weights is not None
    scales = {FORCE: 1.0, RATE: EARTH_RATE, "angular_acceleration": 1.0}
    single, double, _ = (1e-12, 1e-10, 0.0) if averaging_s == 0.1 else TOLERANCES

    def mean(function: Callable[[float], Array]) -> Array:
        half = 0.5 * averaging_s
        found = integrate.quad_vec(function, -half, half, epsabs=1e-12, epsrel=1e-11)[0]
        return np.asarray(found / averaging_s)

    means = {name: scales[name] * value for name, value in stimulus.mean().items()}
    for one, first in stimulus.items():
        expected = mean(lambda t, one=one: moving(table, settings, t)[one])  # type: ignore[misc]
        size = np.abs(expected).max()
        np.testing.assert_allclose(means[one], expected, atol=single * size)
        for two, second in stimulus.items():

            def product(t: float, one: str = one, two: str = two) -> Array:
                felt = moving(table, settings, t)
                return felt[one][:, :, None] * felt[two][:, None, :]

            found = np.einsum("k,nki,nkj->nij", weights, scales[one] * first, scales[two] * second)
            expected = mean(product)
            size = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, atol=double * size)
    of_squares = np.einsum("k,nki->ni", weights, stimulus[FORCE] ** 2)
    turned = np.abs(settings[:, 2:]).max(axis=1) > 0.5
    assert np.abs(of_squares - means[FORCE] ** 2)[turned].max() > (0.1 if averaging_s >= 1.0 else 1e-3)


def test_readings_along_a_turn_are_means_of_readings_and_not_of_what_is_felt() -> None:
    """The square of an accelerometer that turns through half a revolution: by its integral."""
    table = TwoAxisRateTable(averaging_s=1.0)
    sensor = IMU()
    names = [parameter.name for parameter in sensor.parameters]
    truth = np.zeros(len(names))
    truth[names.index("accel_quadratic_z")] = 1.0
    rate = np.radians(90.0)
    settings = np.array([[0.3, 0.0, rate, 0.0]])
    reading = as_model(sensor).readings(truth, table.stimulus(settings))[0, 2]
    # the mean of cos x + cos^2 x over a turn of `rate` about x = 0.3
    first = np.cos(0.3) * np.sin(0.5 * rate) / (0.5 * rate)
    square = 0.5 + 0.5 * np.cos(0.6) * np.sin(rate) / rate
    assert reading == pytest.approx(first + square, abs=1e-5)
    assert abs(reading - first - first**2) > 1e-2
