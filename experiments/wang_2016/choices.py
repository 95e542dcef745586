"""What had to be inferred of Wang et al. (2016), as choices, and what the traversal gives by each of them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from acalx.numerics.arrays import Array
from acalx.stands import PlatformGimbals

# What the paper prints: positions of the parallel and of the serial program.
PARALLEL, SERIAL = 13, 9
MOST, LEAST_GYROS, LEAST_ACCELS = 16, 8, 4
# Eigenvalues of an information per measurement in unit inputs: below it a coefficient is not seen.
SINGULAR = 1e-8
# Logarithms of determinants that differ by less are equal; so are components of the vertical, in g.
EQUAL = 1e-9
SAME_VERTICAL = 1e-6

PRODUCTS = ("II", "OO", "SS", "IO", "IS", "OS")
PAIRS = tuple(itertools.combinations(PRODUCTS, 2))
AZIMUTHS = (90, 75, 60, 45, 30, 15, 0)
JUDGES = ("all", "X", "Y", "Z")

# How often the outer and the inner angle have stepped before the positions k, given the stops of a whole turn of each.
Rule = Callable[[np.ndarray, int, int], tuple[np.ndarray, np.ndarray]]


def _back_and_forth(k: np.ndarray, stops: int) -> np.ndarray:
    """Of the faster angle: a whole turn forth, then back."""
    return np.where(k // stops % 2 == 0, k % stops, stops - 1 - k % stops)


RULES: dict[str, Rule] = {
    "both": lambda k, outer, inner: (k, k),
    "turn, outer first": lambda k, outer, inner: ((k + 1) // 2, k // 2),
    "turn, inner first": lambda k, outer, inner: (k // 2, (k + 1) // 2),
    "lines of the inner": lambda k, outer, inner: (k // inner, k % inner),
    "lines of the outer": lambda k, outer, inner: (k % outer, k // outer),
    "back and forth, inner": lambda k, outer, inner: (k // inner, _back_and_forth(k, inner)),
    "back and forth, outer": lambda k, outer, inner: (_back_and_forth(k, outer), k // outer),
}


class Way(NamedTuple):
    """How the platform is turned: a rule, its sense, and whether the attitude at the start counts.

    Parameters
    ----------
    rule : str
        A key of `RULES`.
    against : bool
        Whether the inner angle turns in the other sense than the outer one.
    home : bool
        Whether east, north, up (both angles zero) is the first position of every sequence.
    """

    rule: str
    against: bool
    home: bool


WAYS = tuple(Way(rule, against, home) for rule in RULES for against in (False, True) for home in (False, True))


def sequences(way: Way) -> Array:
    """The 144 sequences of the paper, settings (144, 16, 2) in rad."""
    out = []
    for start, outer, inner in itertools.product(range(0, 180, 5), (45, 90), (45, 90)):
        steps = RULES[way.rule](np.arange(MOST - way.home), 360 // outer, 360 // inner)
        alpha = start + (-1 if way.against else 1) * inner * steps[1]
        angles = np.stack([start + outer * steps[0], alpha], axis=-1)
        out.append(np.concatenate([np.zeros((int(way.home), 2)), angles]))
    return np.radians(np.array(out, dtype=float) % 360.0)


def swapped(pair: tuple[str, str]) -> tuple[str, str]:
    """The second-order terms of a pair where output and spin axis change their names."""
    named = {"".join(sorted(term.translate(str.maketrans("OS", "SO")), key="IOS".index)) for term in pair}
    return next(each for each in PAIRS if set(each) == named)


def gyro_models() -> list[tuple[tuple[str, str], ...]]:
    """Pairs of second-order terms of the X, Y and Z gyro, by the cyclic naming of their axes, each model once.

    All gyros have the same pair; output and spin axis of each may be named either way.
    """
    models = {
        tuple(swapped(pair) if swap else pair for swap in swaps)
        for pair in PAIRS
        for swaps in itertools.product((False, True), repeat=3)
    }
    return sorted(models, key=lambda model: [PAIRS.index(pair) for pair in model])


def felt(settings: Array, azimuth_deg: float, latitude_deg: float = 34.25) -> tuple[Array, Array]:
    """Gravity in g and the Earth's rate in units of itself, (..., 3) each, in platform axes."""
    stimulus = PlatformGimbals(azimuth_deg=azimuth_deg, latitude_deg=latitude_deg).stimulus(settings)
    force, rate = stimulus["specific_force"], stimulus["angular_rate"]
    assert force is not None  # gimbals always give both
    assert rate is not None
    return force, rate


def gyro_rows(force: Array, rate: Array, axis: int) -> Array:
    """All that a gyro may have, (..., 12): 1, aI, aO, aS, the six products of `PRODUCTS`, wO, wS."""
    named = {letter: force[..., (axis + k) % 3] for k, letter in enumerate("IOS")}
    products = [named[one] * named[other] for one, other in PRODUCTS]
    rates = [rate[..., (axis + k) % 3] for k in (1, 2)]
    return np.stack([np.ones_like(named["I"]), *named.values(), *products, *rates], axis=-1)


def accel_rows(force: Array) -> Array:
    """What an accelerometer has, (..., 4): 1 and the three components of gravity, whichever way it lies."""
    return np.concatenate([np.ones_like(force[..., :1]), force], axis=-1)


def per_measurement(rows: Array, least: int) -> Array:
    """Information per measurement (s, k, p, p) of the first `least` to 16 positions, from rows (s, 16, p)."""
    sums = np.cumsum(rows[..., :, None] * rows[..., None, :], axis=1)
    return np.asarray(sums[:, least - 1 :] / np.arange(least, MOST + 1)[:, None, None])


def log_det(information: Array) -> Array:
    """Logarithms of the determinants of matrices (..., p, p); -inf where a coefficient is not seen."""
    values = np.linalg.eigvalsh(information)
    return np.where(values[..., 0] > SINGULAR, np.log(np.maximum(values, SINGULAR)).sum(axis=-1), -np.inf)


def members(pair: Sequence[str]) -> list[int]:
    """Where the eight terms of a gyro with these two products are in `gyro_rows`."""
    return [0, 1, 2, 3, *(4 + PRODUCTS.index(product) for product in pair), 10, 11]


def best_of(values: Array) -> tuple[int, np.ndarray]:
    """The fewest positions (their index) with the largest value of (s, k), and the sequences that have it."""
    equal = values > values.max() - EQUAL
    column = int(np.argmax(equal.any(axis=0)))
    return column, np.flatnonzero(equal[:, column])


@dataclass(frozen=True)
class Landscape:
    """Determinants of all sequences of a way of turning, with the outer axis at an azimuth in degrees."""

    way: Way
    azimuth: int

    @cached_property
    def settings(self) -> Array:
        """Settings (144, 16, 2) in rad."""
        return sequences(self.way)

    @cached_property
    def force(self) -> Array:
        """Gravity in platform axes, (144, 16, 3) in g."""
        return felt(self.settings, self.azimuth)[0]

    @cached_property
    def accels(self) -> Array:
        """log det of an accelerometer per measurement, (144, 13), with 4 to 16 positions."""
        return log_det(per_measurement(accel_rows(self.force), LEAST_ACCELS))

    @cached_property
    def gyros(self) -> dict[tuple[str, str], Array]:
        """log det of the X, Y and Z gyro per measurement by pair, (3, 144, 9), with 8 to 16 positions."""
        rows = [gyro_rows(*felt(self.settings, self.azimuth), axis) for axis in range(3)]
        information = np.stack([per_measurement(each, LEAST_GYROS) for each in rows])
        return {pair: log_det(information[..., members(pair), :][..., members(pair)]) for pair in PAIRS}

    def values(self, pairs: tuple[tuple[str, str], ...], judge: str) -> Array:
        """log det (144, 9) of the gyro by which programs are judged, or of all three."""
        each = self.each(pairs)
        return np.asarray(each.sum(axis=0) if judge == "all" else each["XYZ".index(judge)])

    def each(self, pairs: tuple[tuple[str, str], ...]) -> Array:
        """log det (3, 144, 9) of the X, Y and Z gyro with these pairs."""
        return np.stack([self.gyros[pair][axis] for axis, pair in enumerate(pairs)])

    @staticmethod
    def served(gyros: Array, accels: Array) -> np.ndarray:
        """Which of the verticals (k, 3) of an accelerometers' program a gyros' one (l, 3) has, too: (k,)."""
        return np.asarray((np.abs(accels[:, None] - gyros).max(axis=-1) < SAME_VERTICAL).any(axis=1))


class Found(NamedTuple):
    """A combination of choices and what the traversal gives by it.

    Parameters
    ----------
    way, azimuth, judge
        How the platform is turned, the azimuth of the outer axis in degrees, and the gyro whose determinant decides.
    pairs : three pairs of str
        Second-order terms of the X, Y and Z gyro.
    gyros, accels : int
        Positions of the best sequence for each.
    parallel, serial : int
        Positions of the programs. The parallel one leaves out the accelerometers' positions that the gyros' ones
        serve; the serial one is the gyros' sequence, with as many more as the accelerometers lack.
    apart : float
        Largest difference of log det between two gyros, of the gyros' program.
    """

    way: Way
    azimuth: int
    judge: str
    pairs: tuple[tuple[str, str], ...]
    gyros: int
    accels: int
    parallel: int
    serial: int
    apart: float

    @property
    def distance(self) -> int:
        """By how many positions the two programs differ from the printed ones."""
        return abs(self.parallel - PARALLEL) + abs(self.serial - SERIAL)


def found(landscape: Landscape, pairs: tuple[tuple[str, str], ...], judge: str) -> Found | None:
    """What the traversal gives for some choices; None where no sequence shows all that decides."""
    each, values = landscape.each(pairs), landscape.values(pairs, judge)
    if not np.isfinite(values).any():
        return None
    column, gyros = best_of(values)
    accel_column, accels = best_of(landscape.accels)
    n, k = LEAST_GYROS + column, LEAST_ACCELS + accel_column
    force = landscape.force
    most = max(int(landscape.served(force[i, :n], force[j, :k]).sum()) for i in gyros for j in accels)
    seen = int(np.linalg.matrix_rank(accel_rows(force[gyros[0], :n]), tol=np.sqrt(SINGULAR)))
    with np.errstate(invalid="ignore"):  # all of them singular, as where only one decides
        apart = float(np.ptp(each[:, gyros, column], axis=0).min())
    serial = n + LEAST_ACCELS - seen
    apart = apart if np.isfinite(apart) else np.inf
    return Found(landscape.way, landscape.azimuth, judge, pairs, n, k, n + k - most, serial, apart)


def search(ways: Sequence[Way] = WAYS, azimuths: Sequence[int] = AZIMUTHS) -> Iterator[Found]:
    """All combinations by which there is a program."""
    for way, azimuth in itertools.product(ways, azimuths):
        landscape = Landscape(way, azimuth)
        for pairs, judge in itertools.product(gyro_models(), JUDGES):
            if each := found(landscape, pairs, judge):
                yield each
