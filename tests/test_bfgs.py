from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acalx.numerics.arrays import Array
from acalx.numerics.bfgs import Minima, Objective, minimize_stack

FREE = np.inf


def quadratics(hessians: Array, centers: Array) -> Objective:
    """(x - c)' H (x - c) / 2 for each member of a stack."""

    def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
        gradient = np.einsum("skl,sl->sk", hessians[index], x - centers[index])
        return 0.5 * np.einsum("sk,sk->s", x - centers[index], gradient), gradient

    return objective


def rosenbrock(x: Array, index: np.ndarray) -> tuple[Array, Array]:
    """Chained over the variables, with another steepness for each member of the stack."""
    steep = (10.0 ** (1 + index % 2))[:, None]
    rise, left = x[:, 1:] - x[:, :-1] ** 2, 1.0 - x[:, :-1]
    gradient = np.zeros(x.shape)
    gradient[:, 1:] = 2 * steep * rise
    gradient[:, :-1] -= 4 * steep * rise * x[:, :-1] + 2 * left
    return (steep * rise**2 + left**2).sum(axis=1), gradient


def bounds(k: int, lower: float = -FREE, upper: float = FREE) -> tuple[Array, Array]:
    return np.full(k, lower), np.full(k, upper)


def random_quadratics(seed: int, s: int, k: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    roots = rng.standard_normal((s, k, 2 * k))
    return roots @ roots.swapaxes(-1, -2) / k, rng.standard_normal((s, k)), rng.standard_normal((s, k))


@pytest.mark.parametrize("k", [1, 5, 128, 129, 300])
def test_quadratics(k: int) -> None:
    hessians, centers, starts = random_quadratics(0, 4, k)
    minima = minimize_stack(quadratics(hessians, centers), starts, *bounds(k))
    assert minima.converged.all()
    np.testing.assert_allclose(minima.x, centers, atol=1e-5)
    np.testing.assert_allclose(minima.loss, 0.0, atol=1e-9)


@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 6), s=st.integers(1, 5))
def test_bounded_quadratics_end_where_no_allowed_step_goes_down(seed: int, k: int, s: int) -> None:
    hessians, centers, starts = random_quadratics(seed, s, k)
    lower, upper = -0.4 * np.ones(k), np.linspace(0.1, 0.8, k)
    objective = quadratics(hessians, centers)
    minima = minimize_stack(objective, starts, lower, upper, loss_tolerance=0.0)
    value, gradient = objective(minima.x, np.arange(s))
    np.testing.assert_array_equal(value, minima.loss)
    assert ((minima.x >= lower) & (minima.x <= upper)).all()
    projected = minima.x - np.clip(minima.x - gradient, lower, upper)
    assert np.abs(projected).max() < 1e-5


def test_separable_bounded_quadratic_has_the_clipped_center() -> None:
    centers = np.array([[-2.0, 0.3, 5.0, 0.0]])
    hessians = np.diag([1.0, 10.0, 0.1, 3.0])[None]
    minima = minimize_stack(quadratics(hessians, centers), np.zeros((1, 4)), *bounds(4, -1.0, 1.0))
    np.testing.assert_allclose(minima.x, [[-1.0, 0.3, 1.0, 0.0]], atol=1e-7)


@pytest.mark.parametrize("k", [2, 10, 150])
def test_rosenbrock(k: int) -> None:
    starts = 1.0 + 0.3 * np.random.default_rng(0).standard_normal((6, k))
    minima = minimize_stack(rosenbrock, starts, *bounds(k), iterations=5000)
    assert minima.converged.all()
    np.testing.assert_allclose(minima.x, 1.0, atol=1e-4)


@pytest.mark.parametrize("k", [3, 140])
def test_a_stack_takes_each_member_where_it_goes_alone(k: int) -> None:
    starts = 1.0 + 0.2 * np.random.default_rng(1).standard_normal((5, k))
    together = minimize_stack(rosenbrock, starts, *bounds(k, 0.0, 1.5), iterations=5000)
    for member in range(5):

        def alone(x: Array, index: np.ndarray, member: int = member) -> tuple[Array, Array]:
            return rosenbrock(x, np.full(len(x), member))

        one = minimize_stack(alone, starts[member : member + 1], *bounds(k, 0.0, 1.5), iterations=5000)
        np.testing.assert_allclose(one.x[0], together.x[member], atol=1e-4)


def test_no_end_is_higher_than_its_start_and_starts_outside_are_moved_in() -> None:
    starts = np.array([[5.0, 5.0], [0.2, 0.1]])
    minima = minimize_stack(rosenbrock, starts, *bounds(2, -1.0, 0.5))
    first, _ = rosenbrock(np.clip(starts, -1.0, 0.5), np.arange(2))
    assert (minima.loss <= first).all()
    assert (minima.x <= 0.5).all()


def walled(x: Array, index: np.ndarray) -> tuple[Array, Array]:
    """x - log x, infinite for x <= 0."""
    inside = x[:, 0] > 0
    safe = np.where(inside, x[:, 0], 1.0)
    return np.where(inside, safe - np.log(safe), np.inf), np.where(inside[:, None], 1 - 1 / safe[:, None], 0.0)


def test_steps_into_an_infinite_region_are_taken_back() -> None:
    minima = minimize_stack(walled, np.array([[20.0], [1e-3], [0.5]]), *bounds(1))
    assert minima.converged.all()
    np.testing.assert_allclose(minima.x, 1.0, atol=1e-5)


def test_a_start_in_an_infinite_region_stays_and_has_not_converged() -> None:
    minima = minimize_stack(walled, np.array([[-1.0], [3.0]]), *bounds(1))
    assert minima.converged.tolist() == [False, True]
    assert minima.x[0] == -1.0
    assert np.isposinf(minima.loss[0])


@pytest.mark.parametrize("iterations", [0, 1, 3])
def test_running_out_of_iterations_is_told(iterations: int) -> None:
    starts = np.array([[-1.2, 1.0], [1.0, 1.0]])
    minima: Minima = minimize_stack(rosenbrock, starts, *bounds(2), iterations=iterations)
    assert minima.converged.tolist() == [False, iterations > 0]
    value, _ = rosenbrock(minima.x, np.arange(2))
    np.testing.assert_array_equal(value, minima.loss)
