from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import parts
from acalx.criteria import A, Criterion, D, E, Inequality, Objectives, Product, Target, concave_of
from acalx.errors import ArgumentError, PluginError
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.testing import check_criterion

PARAMETERS = parts.MODELS[0].parameters
SEEDS = st.integers(0, 2**32 - 1)


def information(seed: int, stack: tuple[int, ...] = (), n: int = 18) -> Information:
    """Of random programs."""
    rng = np.random.default_rng(seed)
    return parts.problem(n=n).information(parts.FULL.axes.random(rng, (*stack, n)))


@pytest.mark.parametrize("criterion", parts.CRITERIA, ids=repr)
@pytest.mark.parametrize("seed", range(2))
def test_contract(criterion: Criterion, seed: int) -> None:
    check_criterion(criterion, PARAMETERS, monotone=criterion in parts.MONOTONE, seed=seed)


def test_values_follow_their_definitions() -> None:
    at = information(0, (2, 3))
    covariance = np.linalg.inv(at.matrix)
    np.testing.assert_allclose(D().loss(at), np.log(np.linalg.det(covariance)), rtol=1e-9)
    np.testing.assert_allclose(A().loss(at), np.log(np.trace(covariance, axis1=-2, axis2=-1)), rtol=1e-9)
    np.testing.assert_allclose(E().loss(at), np.log(np.linalg.eigvalsh(covariance)[..., -1]), rtol=1e-9)
    deviations = np.sqrt(covariance.diagonal(axis1=-2, axis2=-1)[..., 3:6])
    spread = 1.0 - deviations.min(axis=-1) / deviations.max(axis=-1)
    np.testing.assert_allclose(Inequality("scale").loss(at), np.log(spread), rtol=1e-9)


@pytest.mark.parametrize("criterion", parts.MONOTONE, ids=repr)
@given(seed=SEEDS)
def test_a_further_position_never_hurts(criterion: Criterion, seed: int) -> None:
    positions = parts.FULL.axes.random(np.random.default_rng(seed), (14,))
    fewer, more = (parts.problem(criterion, n=n).loss(positions[:n]) for n in (13, 14))
    assert more <= fewer + 1e-9


@given(seed=SEEDS)
def test_d_does_not_change_when_the_program_is_turned(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    directions = rng.standard_normal((12, 3))
    before, after = (parts.problem(n=12).loss(parts.program(d)) for d in (directions, directions @ turn.T))
    assert after == pytest.approx(before, abs=1e-7)


@pytest.mark.parametrize("criterion", parts.CRITERIA, ids=repr)
@given(seed=SEEDS)
def test_order_of_positions_and_half_turns_do_not_matter(criterion: Criterion, seed: int) -> None:
    rng = np.random.default_rng(seed)
    positions = parts.FULL.axes.random(rng, (12,))
    same = rng.permutation(positions)
    same[:5] = np.stack([math.pi - same[:5, 0], same[:5, 1] + math.pi], axis=-1)
    before, after = (parts.problem(criterion, n=12).loss(x) for x in (positions, same))
    assert after == pytest.approx(before, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("criterion", parts.CRITERIA, ids=repr)
def test_stack_on_two_levels(criterion: Criterion) -> None:
    problem = parts.problem(criterion, n=13)
    programs = problem.restrictions.random(np.random.default_rng(5), 24).reshape(4, 6, 13, 2)
    loss, gradient = problem.loss_and_gradient(programs)
    for index in np.ndindex(4, 6):
        one, slope = problem.loss_and_gradient(programs[index])
        assert loss[index] == pytest.approx(float(one), abs=1e-9)
        np.testing.assert_allclose(gradient[index], slope, atol=1e-7 * (1 + np.abs(slope).max()))
    np.testing.assert_allclose(problem.loss(programs), loss, atol=1e-9)


def test_inequality_counts_no_less_than_its_floor() -> None:
    at = Information(np.diag([4.0] * 3 + [1.0, 2.0, 3.0] + [1.0] * 3), PARAMETERS)
    assert Inequality("bias", floor=0.01).loss(at) == pytest.approx(math.log(0.01))
    assert not Inequality("bias", floor=0.01).gradient(at).any()
    assert Inequality("scale").loss(at) == pytest.approx(math.log(1 - 3**-0.5))


def test_product_is_a_weighted_sum_of_losses() -> None:
    at = information(7, (3,))
    expected = D().loss(at) + 0.1 * sum(Inequality(group).loss(at) for group in parts.GROUPS)
    np.testing.assert_allclose(parts.D_FAIR.loss(at), expected, rtol=1e-12)
    by_operators = D() * Inequality("bias") ** 0.1 * Inequality("scale") ** 0.1 * Inequality("nonorthogonality") ** 0.1
    np.testing.assert_allclose(by_operators.loss(at), expected, rtol=1e-12)
    weights = [weight for weight, _ in by_operators.terms().ceilings]
    assert weights == pytest.approx([0.1] * 3)
    assert by_operators.terms().smooth == ((1.0, D()),)


@dataclass(frozen=True)
class OnlyLoss(Criterion):
    """log of the bias variances times those of the rest, as a plug-in author would write it."""

    def loss(self, information: Information) -> Array:
        variances = information.variances
        return np.log(variances[..., :3].sum(axis=-1)) + 0.5 * np.log(variances[..., 3:]).sum(axis=-1)


def only_loss_gradient(at: Information) -> Array:
    """-K W K with W the diagonal derivative of OnlyLoss with respect to the variances."""
    variances = at.variances
    weights = np.concatenate(
        [np.repeat(1 / variances[..., :3].sum(-1)[..., None], 3, -1), 0.5 / variances[..., 3:]], -1
    )
    return -(at.covariance * weights[..., None, :]) @ at.covariance


@pytest.mark.parametrize("seed", range(5))
def test_default_gradient_is_right_whatever_the_scales(seed: int) -> None:
    scale = 10.0 ** np.random.default_rng(seed).uniform(-4, 4, 9)
    matrix = information(seed, (2, 4)).matrix * np.outer(scale, scale)
    at = Information(matrix, PARAMETERS)
    exact, numerical = only_loss_gradient(at), OnlyLoss().gradient(at)
    units = np.outer(scale, scale)
    np.testing.assert_allclose(numerical * units, exact * units, atol=1e-7 * np.abs(exact * units).max())
    check_criterion(OnlyLoss(), PARAMETERS)


def test_default_gradient_is_finite_next_to_singular_matrices() -> None:
    stand = parts.TwoAxis(alpha1_deg=(0, 10), alpha2_deg=(0, 10))
    problem = parts.problem(OnlyLoss(), n=12, stand=stand)
    programs = problem.restrictions.random(np.random.default_rng(0), 300)
    loss, gradient = problem.loss_and_gradient(programs)
    assert 50 < np.isinf(loss).sum() < 250
    assert np.isfinite(gradient).all()
    assert (np.abs(gradient).max(axis=(1, 2)) > 0).sum() > 50


def test_messages_speak_of_arguments() -> None:
    with pytest.raises(ArgumentError, match=r"as in target=\{'bias': 0\.5, 'scale': 0\.8\}$"):
        Target(None)
    with pytest.raises(ArgumentError, match=r"as in objectives=\[D\(\), A\(\)\]; for one use criterion=D\(\)$"):
        Objectives([D()])
    with pytest.raises(ArgumentError, match=r"such as criterion=D\(\)$"):
        parts.problem(Inequality("sacle"))


def test_a_degree_without_its_bound_is_refused() -> None:
    with pytest.raises(PluginError, match=r"Halfway has a degree.* derive it from acalx\.criteria\.Concave"):

        class Halfway(Criterion):
            def loss(self, information: Information) -> Array:
                return -information.log_det

            def degree(self, p: int) -> float:
                return float(p)


def test_products_of_concave_criteria_are_concave() -> None:
    both = concave_of(A() * D() ** 0.5)
    assert both is not None
    assert both.degree(9) == pytest.approx(1.0 + 4.5)
    assert concave_of(D()) == D()
    assert concave_of(D() * OnlyLoss()) is None
    assert concave_of(D() * E()) is None  # a kink together with others is no smooth product
    assert concave_of(Inequality("bias")) is None


@pytest.mark.parametrize("floor", [0, 1, -1, 2, math.nan, "x", None, True])
def test_bad_floors(floor: object) -> None:
    with pytest.raises(ArgumentError, match=f"floor={floor!r}: the floor of an inequality is a number between 0 and 1"):
        Inequality("bias", floor)  # type: ignore[arg-type]


@pytest.mark.parametrize("group", ["bais", "", None, 3])
@pytest.mark.parametrize("wrap", [lambda c: c, lambda c: D() * c**0.1], ids=["alone", "in a product"])
def test_group_that_the_model_lacks(group: str, wrap: Callable[[Criterion], Criterion]) -> None:
    with pytest.raises(ArgumentError, match=f"group {group!r}; its groups are bias, scale, nonorthogonality"):
        parts.problem(wrap(Inequality(group)))


@pytest.mark.parametrize("criteria", [[], None, D(), "D", [D], [D(), 3]], ids=str)
def test_products_of_something_else(criteria: object) -> None:
    with pytest.raises(ArgumentError) as caught:
        Product(criteria)  # type: ignore[arg-type]
    assert str(caught.value) == f"criteria={criteria!r}: a product takes a list of one or more criteria"


@pytest.mark.parametrize(
    ("exponents", "quoted"),
    [
        ([1, 2], "exponents=[1, 2]: a product takes a positive exponent for each criterion, 1 of them here"),
        ([], "exponents=[]: "),
        (0.5, "exponents=0.5: "),
        ("x", "exponents='x': "),
        *(([bad], f"exponents=[{bad!r}]: ") for bad in (0, -1, math.nan, math.inf, "x", None)),
    ],
    ids=str,
)
def test_bad_exponents(exponents: object, quoted: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        Product([D()], exponents)  # type: ignore[arg-type]
    assert quoted in str(caught.value)
