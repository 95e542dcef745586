"""Optimal weights on candidates: optimality conditions over all of them, known optima, hard cases."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parts
from acalx.bounds.relaxation import relax
from acalx.criteria import A, Ceiling, Concave, Criterion, D, E, Inequality
from acalx.errors import AcalxError, ArgumentError, CompatibilityError
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.stands import TwoAxis
from acalx.weights import (
    Positions,
    Rows,
    Weights,
    alike,
    efficient_rounding,
    optimal_weights,
    random_roundings,
    thinned,
)

CRITERIA = [D(), A(), E()]
every = pytest.mark.parametrize("criterion", CRITERIA, ids=lambda criterion: criterion.label)
D1 = 61509375 / 4  # det of the inverse information of one measurement, uniform on the sphere
NARROW = TwoAxis(alpha1_deg=(-30, 30), alpha2_deg=(-60, 60))


def named(p: int) -> tuple[Parameter, ...]:
    return tuple(Parameter(f"x{k}", "x", "1") for k in range(p))


def candidates(rows: Array) -> Rows:
    return Rows(rows, named(rows.shape[-1]))


def exact_gap(rows: Array, criterion: Criterion, found: Weights, base: Array | float = 0.0) -> float:
    """How far the value is above its bound, from the definition and for every candidate."""
    chosen = rows[found.index]
    matrix = np.einsum("k,kma,kmb->ab", found.weights, chosen, chosen) + base
    covariance = np.linalg.inv(matrix)
    p = len(matrix)
    if isinstance(criterion, Ceiling):  # E: any S bounds 1 / largest eigenvalue by trace S over the peak
        support = found.support
        value, least = np.linalg.eigvalsh(covariance)[-1], np.trace(support)
    else:
        support = covariance / p if criterion == D() else covariance @ covariance / np.trace(covariance)
        value = least = 1.0
    peak = np.einsum("kma,ab,kmb->k", rows, support, rows).max() + (support * base).sum()
    return float(value / least * peak - 1.0)


def check(rows: Array, criterion: Criterion, base: Array | None = None, tolerance: float = 1e-6) -> Weights:
    found = optimal_weights(candidates(rows), criterion, base=base)
    assert found.weights.min() > 0
    assert found.weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert len(set(found.index)) == len(found.index)
    assert found.gap <= tolerance
    assert exact_gap(rows, criterion, found, 0.0 if base is None else base) == pytest.approx(found.gap, abs=2e-7)
    p = rows.shape[-1]
    assert len(found.index) <= p * (p + 1) // 2 + 1
    return found


# --- optimality ---


@every
@pytest.mark.parametrize("p", [3, 9, 12])
def test_gaussian_regressors(criterion: Criterion, p: int) -> None:
    check(np.random.default_rng(p).standard_normal((30_000, 1, p)), criterion)


@every
@pytest.mark.parametrize("kind", ["structured", "random"])
@pytest.mark.parametrize("stand", [parts.FULL, parts.BAND, NARROW], ids=repr)
def test_positions_of_a_table(criterion: Criterion, kind: str, stand: TwoAxis) -> None:
    positions = Positions(stand, ScalarAccel(), stand.axes.candidates(30_000, kind, np.random.default_rng(0)))
    found = optimal_weights(positions, criterion)
    rows = positions.regressors(slice(None))
    assert exact_gap(rows, criterion, found) == pytest.approx(found.gap, abs=2e-7)
    assert found.efficiency >= 0.999999
    assert len(found.index) <= 46


def hard_cases() -> dict[str, Array]:
    rng = np.random.default_rng(5)
    few = rng.standard_normal((40, 1, 5))
    rare = rng.standard_normal((20_000, 1, 5))
    rare[..., 4] = 0.0
    rare[777, 0, 4] = 1e-2
    dominated = np.concatenate([10 * np.eye(6), 0.1 * rng.standard_normal((20_000, 6))])[:, None]
    return {
        "equal candidates": np.repeat(few, 500, axis=0),
        "nearly equal candidates": np.repeat(few, 500, axis=0) * (1 + 1e-6 * rng.standard_normal((20_000, 1, 5))),
        "two outputs and more": rng.standard_normal((20_000, 3, 6)),
        "one candidate shows a parameter": rare,
        "exactly p support points": dominated,
        "units of all sizes": rng.standard_normal((20_000, 1, 5)) * [1, 1e4, 1e-4, 10, 0.1],
        "heavy tails": rng.standard_cauchy((20_000, 1, 5)),
        "corners of a cube": rng.choice([-1.0, 1.0], (20_000, 1, 6)),
        "hardly more candidates than parameters": rng.standard_normal((7, 1, 5)),
        "a polynomial": (np.linspace(-1, 1, 20_001)[:, None] ** np.arange(6))[:, None],
    }


HARD = hard_cases()


@every
@pytest.mark.parametrize("name", HARD)
def test_hard_cases(criterion: Criterion, name: str) -> None:
    check(HARD[name], criterion)


@every
def test_measurements_already_made_count(criterion: Criterion) -> None:
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((20_000, 1, 5))
    check(rows, criterion, np.diag([30.0, 5.0, 0.0, 0.0, 0.0]))
    rows[..., 0] = 0.0  # seen by those alone
    found = check(rows, criterion, np.diag([0.5, 0.0, 0.0, 0.0, 0.0]))
    assert found.information.matrix[0, 0] == pytest.approx(0.5)


@settings(max_examples=15, deadline=None)
@given(
    p=st.integers(2, 6),
    m=st.integers(1, 2),
    size=st.integers(20, 400),
    seed=st.integers(0, 2**32 - 1),
    criterion=st.sampled_from(CRITERIA),
)
def test_no_other_weights_are_better(p: int, m: int, size: int, seed: int, criterion: Criterion) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((size, m, p))
    found = optimal_weights(candidates(rows), criterion)
    others = rng.dirichlet(np.ones(size), 20)
    losses = criterion.loss(Information(np.einsum("sk,kma,kmb->sab", others, rows, rows), named(p)))
    degree = criterion.degree(p)
    assert degree is not None
    assert (losses >= found.loss - degree * math.log1p(found.gap) - 1e-12).all()


# --- known optima ---


def test_the_whole_sphere_has_the_known_optimum() -> None:
    positions = Positions(parts.FULL, ScalarAccel(), parts.FULL.axes.candidates(100_000, "structured", rng_of(0)))
    found = optimal_weights(positions, D())
    assert math.exp(found.loss) == pytest.approx(D1, rel=2e-6 * 9)
    # the only optimal information: that of directions uniform on the sphere
    expected = np.diag([1 / 3] * 3 + [1 / 5] * 3 + [1 / 15] * 3)
    expected[3:6, 3:6] += np.full((3, 3), 1 / 15) - np.eye(3) / 15
    np.testing.assert_allclose(found.information.matrix, expected, atol=2e-3)


def test_vertices_are_found_exactly() -> None:
    found = check(HARD["exactly p support points"], D())
    assert sorted(found.index) == list(range(6))
    np.testing.assert_allclose(found.weights, 1 / 6, atol=1e-7)


def test_a_polynomial_has_its_known_support() -> None:
    """D-optimal for a cubic: ends, and roots of the derivative of Legendre's polynomial (Guest 1958)."""
    grid = np.linspace(-1, 1, 20_001)
    found = check((grid[:, None] ** np.arange(4))[:, None], D())
    near = np.abs(grid[found.index][:, None] - [-1, -(5**-0.5), 5**-0.5, 1])
    assert found.weights @ near.min(axis=1) < 1e-3
    np.testing.assert_allclose(np.bincount(near.argmin(axis=1), found.weights), 0.25, atol=1e-3)


@every
def test_a_fine_grid_comes_close_to_the_whole_range(criterion: Criterion) -> None:
    continuous = relax(parts.problem(criterion, 12, parts.PATCH))
    bound = criterion.least_loss(continuous.support, continuous.information)
    grid = parts.PATCH.axes.candidates(200_000, "structured", rng_of(0))
    found = optimal_weights(Positions(parts.PATCH, ScalarAccel(), grid), criterion)
    assert bound - 1e-4 <= found.loss <= bound + 3e-3


# --- size ---


def test_candidates_are_not_kept_in_memory() -> None:
    grid = NARROW.axes.candidates(1_000_000, "structured", rng_of(0))
    assert 900_000 < len(grid) < 1_100_000
    tracemalloc.start()
    found = optimal_weights(Positions(NARROW, ScalarAccel(), grid), D())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.efficiency >= 0.999999
    assert peak < 50e6  # the regressors would take 72 MB


# --- refusals ---


def test_candidates_without_full_rank_are_refused_by_what_they_do_not_show() -> None:
    rows = np.random.default_rng(0).standard_normal((1000, 1, 4))
    rows[..., 3] = 2.0 * rows[..., 1]
    with pytest.raises(AcalxError, match=r"1000 candidates can estimate x1 - 0.5 x3"):
        optimal_weights(candidates(rows), D())


def test_what_is_not_convex_is_refused() -> None:
    rows = np.random.default_rng(0).standard_normal((50, 1, 9))
    with pytest.raises(CompatibilityError, match=r"Inequality bias.* does not say that it is convex"):
        optimal_weights(Rows(rows, ScalarAccel().parameters), Inequality("bias"))


@pytest.mark.parametrize("rows", [np.ones((5, 3)), np.ones((5, 1, 4)), np.ones((0, 1, 3)), np.full((5, 1, 3), np.nan)])
def test_bad_rows_are_refused(rows: Array) -> None:
    with pytest.raises(ArgumentError, match="candidate regressors"):
        Rows(rows, named(3))


# --- derivatives ---


@pytest.mark.parametrize("criterion", [D(), A()], ids=["d", "a"])
def test_second_derivatives(criterion: Concave) -> None:
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((20, 5))
    information = Information(rows.T @ rows, named(5))
    directions = rng.standard_normal((6, 5, 5))
    directions = directions + directions.swapaxes(-1, -2)
    exact = criterion.curvature(information, directions)
    numerical = Concave.curvature(criterion, information, directions)
    np.testing.assert_allclose(exact, numerical, atol=1e-6 * np.abs(exact).max())


# --- grids ---


@pytest.mark.parametrize("size", [1, 7, 100, 12_345])
@pytest.mark.parametrize("stand", parts.STANDS, ids=repr)
def test_grids_are_within_the_limits(stand: TwoAxis, size: int) -> None:
    grid = stand.axes.candidates(size, "structured", rng_of(0))
    everything = grid[:]
    assert everything.shape == (len(grid), 2)
    assert stand.axes.allows(everything).all()
    assert len(np.unique(np.round(everything, 9), axis=0)) == len(grid)
    some = np.random.default_rng(0).integers(0, len(grid), 5)
    np.testing.assert_array_equal(grid[some], everything[some])
    if not stand.axes.stepped and size >= 100:
        assert 0.8 * size < len(grid) < 1.25 * size


def test_a_table_with_few_stops_has_them_all() -> None:
    grid = parts.TABLE_15.axes.candidates(10_000, "structured", rng_of(0))
    assert len(grid) == 24**2
    assert len(parts.TABLE_15.axes.candidates(150, "structured", rng_of(0))) == 144


def test_kinds_of_candidates() -> None:
    drawn = parts.BAND.axes.candidates(50, "random", rng_of(3))
    np.testing.assert_array_equal(drawn[:], parts.BAND.axes.random(rng_of(3), (50,)))
    with pytest.raises(ArgumentError, match="kind='sobol'"):
        parts.BAND.axes.candidates(50, "sobol", rng_of(3))


# --- support and rounding ---


def test_thinning_keeps_the_information() -> None:
    rng = np.random.default_rng(1)
    rows, weights = rng.standard_normal((300, 2, 4)), rng.dirichlet(np.ones(300))
    fewer = thinned(rows, weights)
    assert (fewer > 0).sum() <= 11
    assert fewer.min() >= 0
    before, after = (np.einsum("k,kma,kmb->ab", w, rows, rows) for w in (weights, fewer))
    np.testing.assert_allclose(after, before, atol=1e-10)


def test_neighbors_are_one_point() -> None:
    rows = np.repeat(np.eye(3), 4, axis=0)[:, None] + 1e-3 * np.random.default_rng(0).standard_normal((12, 1, 3))
    points = alike(rows, np.full(12, 1 / 12), np.eye(3))
    assert sorted(np.bincount(points)) == [4, 4, 4]
    assert all(len(set(points[4 * k : 4 * k + 4])) == 1 for k in range(3))


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.integers(1, 60))
def test_roundings_sum_to_n(seed: int, k: int, n: int) -> None:
    weights = np.random.default_rng(seed).dirichlet(np.ones(k))
    counts = efficient_rounding(weights, n)
    assert counts.sum() == n
    assert counts.min() >= (1 if n >= k else 0)
    if n >= k:  # no measurement can be moved to make the least ratio of share to weight larger
        assert (counts / weights).min() >= ((counts - 1) / weights).max() - 1e-9
    drawn = random_roundings(np.random.default_rng(seed), weights, n, 20)
    assert (drawn.sum(axis=1) == n).all()
    assert (np.abs(drawn - n * weights) < 1 + 1e-9).all()


def rng_of(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)
