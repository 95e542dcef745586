from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import parts
from acalx.errors import ArgumentError
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter, parameter_groups

PARAMETERS = parts.MODELS[0].parameters
SEEDS = st.integers(0, 2**32 - 1)


def of(directions: object) -> Information:
    return parts.problem(n=9).information(parts.program(directions))


def random(seed: int, stack: tuple[int, ...] = (), n: int = 12) -> Information:
    return parts.problem(n=n).information(parts.FULL.axes.random(np.random.default_rng(seed), (*stack, n)))


@given(seed=SEEDS, stack=st.sampled_from([(), (4,), (40,), (2, 20)]))
def test_everything_agrees_with_plain_numpy(seed: int, stack: tuple[int, ...]) -> None:
    at = random(seed, stack, n=15)
    covariance = np.linalg.inv(at.matrix)
    eigenvalues = np.linalg.eigvalsh(at.matrix)
    error = 1e-12 * (eigenvalues[..., -1] / eigenvalues[..., 0]).max()
    np.testing.assert_allclose(at.log_det, np.linalg.slogdet(at.matrix)[1], atol=error + 1e-9)
    np.testing.assert_allclose(at.covariance, covariance, atol=error * np.abs(covariance).max())
    np.testing.assert_allclose(at.condition_number, eigenvalues[..., -1] / eigenvalues[..., 0], rtol=1e-9)
    deviations = np.sqrt(covariance.diagonal(axis1=-2, axis2=-1))
    np.testing.assert_allclose(at.standard_deviations, deviations, rtol=error)
    np.testing.assert_allclose(at.theta("scale"), deviations[..., 3:6].max(axis=-1), rtol=error)
    np.testing.assert_allclose(at.correlations.diagonal(axis1=-2, axis2=-1), 1.0, rtol=1e-12)
    assert (np.abs(at.correlations) <= 1 + 1e-12).all()
    assert ((at.inequality("bias") >= 0) & (at.inequality("bias") < 1)).all()


def test_outputs_of_a_position_add_up() -> None:
    rows = np.random.default_rng(0).standard_normal((5, 6, 2, 9))
    matrix = Information.from_regressors(rows, PARAMETERS).matrix
    np.testing.assert_allclose(matrix, sum(rows[:, :, m].swapaxes(-1, -2) @ rows[:, :, m] for m in range(2)))
    large = np.asfortranarray(np.random.default_rng(0).standard_normal((70, 6, 2, 9)))
    matrix = Information.from_regressors(large, PARAMETERS).matrix
    np.testing.assert_allclose(matrix, np.einsum("snmi,snmj->sij", large, large), atol=1e-12)


def test_six_faces_hide_the_nonorthogonality() -> None:
    faces = of(np.concatenate([parts.FACES, parts.FACES]))
    assert faces.singular
    assert np.isneginf(faces.log_det)
    assert sorted(faces.inestimable()) == ["nonorthogonality_xy", "nonorthogonality_xz", "nonorthogonality_zy"]


def test_positions_around_an_axis_hide_what_is_along_it() -> None:
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    around_x = np.stack([np.zeros(12), np.cos(angles), np.sin(angles)], axis=-1)
    assert sorted(of(around_x).inestimable()) == ["bias_x", "nonorthogonality_xy", "nonorthogonality_xz", "scale_x"]


def test_combinations_are_named_as_sums() -> None:
    # positions on two circles x = +1/2 and x = -1/2: x^2 is 1/4 and y^2 + z^2 is 3/4 everywhere
    positions = parts.FULL.axes.random(np.random.default_rng(1), (14,))
    positions[:, 0] = np.radians(30.0) * np.where(np.arange(14) % 2, 1.0, -1.0)
    assert parts.problem(n=14).information(positions).inestimable() == ["scale_x - 0.3333 scale_y - 0.3333 scale_z"]


@given(seed=SEEDS, rank=st.integers(1, 9))
def test_what_can_not_be_estimated_changes_no_measurement(seed: int, rank: int) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((rank, 9))
    at = Information(rows.T @ rows, PARAMETERS)
    assert len(at.inestimable()) == 9 - rank
    assert bool(at.singular) == (rank < 9)


@pytest.mark.parametrize("limit", [3, 8, 10, 12, 20])
def test_singular_and_inestimable_are_the_same_verdict(limit: float) -> None:
    stand = parts.TwoAxis(alpha1_deg=(0, limit), alpha2_deg=(0, limit))
    problem = parts.problem(n=12, stand=stand)
    stack = problem.information(problem.restrictions.random(np.random.default_rng(0), 200))
    for matrix, singular in zip(stack.matrix, stack.singular, strict=True):
        one = Information(matrix, PARAMETERS)
        assert bool(one.singular) == bool(singular)
        assert bool(one.inestimable()) == bool(singular)


@pytest.mark.parametrize("count", [3, 40])
def test_singular_members_leave_the_others_as_they_are(count: int) -> None:
    matrices = random(3, (count,)).matrix
    matrices[1] = of(np.concatenate([parts.FACES, parts.FACES])).matrix
    mixed, alone = Information(matrices, PARAMETERS), Information(matrices[0], PARAMETERS)
    assert mixed.singular.tolist() == [k == 1 for k in range(count)]
    np.testing.assert_allclose(mixed.covariance[0], alone.covariance, rtol=1e-9)
    assert np.isinf(mixed.covariance[1]).all()
    assert np.isinf(mixed.condition_number[1])
    assert np.isnan(mixed.inequality("bias")[1])
    assert np.isnan(mixed.correlations[1]).all()
    assert np.isinf(mixed.theta("bias")[1])
    chosen = mixed.select(~mixed.singular)
    np.testing.assert_array_equal(chosen.matrix, np.delete(matrices, 1, axis=0))
    np.testing.assert_allclose(chosen.log_det, np.delete(mixed.log_det, 1), rtol=1e-12)


def test_units_do_not_decide_what_is_singular() -> None:
    scale = 10.0 ** np.linspace(-6, 6, 9)
    at = Information(random(4).matrix * np.outer(scale, scale), PARAMETERS)
    assert not at.singular
    assert not at.inestimable()
    assert at.log_det == pytest.approx(float(random(4).log_det) + 2 * np.log(scale).sum(), abs=1e-6)


def test_groups() -> None:
    parameters = (Parameter("a", "one", "g"), Parameter("b", "two", "g"), Parameter("c", "one", "g"))
    assert parameter_groups(parameters) == {"one": [0, 2], "two": [1]}
    at = Information(np.diag([1.0, 4.0, 16.0]), parameters)
    assert at.theta("one") == pytest.approx(1.0)
    assert at.inequality("one") == pytest.approx(0.75)
    with pytest.raises(ArgumentError, match="no parameter group 'three'; the groups are one, two"):
        at.theta("three")


@pytest.mark.parametrize("count", [3, 60])
def test_solve_is_the_covariance_times_vectors(count: int) -> None:
    rng = np.random.default_rng(8)
    rows = rng.standard_normal((count, 30, 1, 9))
    rows[1, ..., 4] = rows[1, ..., 5]  # singular
    information = Information.from_regressors(rows, PARAMETERS)
    vectors = rng.standard_normal((count, 9))
    found = information.solve(vectors)
    regular = np.arange(count) != 1
    expected = np.einsum("tij,tj->ti", information.covariance[regular], vectors[regular])
    np.testing.assert_allclose(found[regular], expected, rtol=1e-10)
    assert np.isnan(found[1]).all()
    one = Information(information.matrix[0], information.parameters)
    np.testing.assert_allclose(one.solve(vectors), vectors @ one.covariance, rtol=1e-9)
