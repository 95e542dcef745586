from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import parts
from acalx.criteria import Criterion, D
from acalx.errors import ArgumentError, PluginError
from acalx.models import GyroRateTable, ScalarAccel
from acalx.optimizers import Optimizer
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.search.encoding import Encoding
from acalx.stands import RateTable, Setting, Stand, TwoAxis

SEEDS = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize(
    ("n", "quoted"),
    [
        (8, "n=8: the 9 parameters of ScalarAccel need 9 positions"),
        (0, "n=0: the 9 parameters"),
        (-3, "n=-3: the 9 parameters"),
        (10**9, "n=1000000000: would take about"),
        (2.5, "n=2.5: the number of positions must be a whole number"),
        (9.0, "n=9.0: the number of positions must be a whole number"),
        (math.nan, "n=nan: "),
        ("9", "n='9': the number of positions must be a whole number"),
        (True, "n=True: "),
        (None, "n=None: "),
    ],
    ids=str,
)
def test_bad_numbers_of_positions(n: object, quoted: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        Problem(parts.FULL, parts.MODELS[0], D(), n)  # type: ignore[arg-type]
    assert str(caught.value).startswith(quoted)


def test_numpy_integers_are_whole_numbers() -> None:
    assert parts.problem(n=np.int64(9)).n == 9  # type: ignore[arg-type]


def exact_gradient_error(problem: Problem, seed: int) -> float:
    """Largest error of the gradient with respect to the settings, relative to the largest entry."""
    settings = problem.restrictions.random(np.random.default_rng(seed), 1)[0]
    _, gradient = problem.loss_and_gradient(settings)
    moves = 1e-4 * np.eye(settings.size).reshape(-1, *settings.shape)
    steps = {h: problem.loss(settings + h * moves) - problem.loss(settings - h * moves) for h in (1, 2)}
    numerical = (8 * steps[1] - steps[2]) / 12e-4
    return float(np.abs(gradient - numerical.reshape(settings.shape)).max() / np.abs(gradient).max())


@pytest.mark.parametrize("stand", parts.STANDS, ids=repr)
@pytest.mark.parametrize("criterion", parts.CRITERIA, ids=repr)
def test_gradient_with_respect_to_the_settings(criterion: Criterion, stand: Stand) -> None:
    problem = parts.problem(criterion, 12, stand)
    if stand.axes.stepped:  # the gradient does not know of steps
        settings = tuple(Setting(s.name, s.lower, s.upper, None, s.periodic) for s in stand.settings)
        assert problem.loss_and_gradient(problem.restrictions.random(np.random.default_rng(0), 1))[1].shape == (
            1,
            12,
            len(settings),
        )
    else:
        assert exact_gradient_error(problem, 1) < 1e-6


@dataclass(frozen=True)
class Tilted(Stand):
    """A plug-in stand with three settings, no derivative of its own."""

    @property
    def settings(self) -> tuple[Setting, ...]:
        return tuple(Setting(name, 0.0, 2 * math.pi) for name in ("roll", "pitch", "yaw"))

    def stimulus(self, settings):  # type: ignore[no-untyped-def]
        tilted = settings[..., :2] + 0.1 * np.sin(settings[..., 2:])
        return TwoAxis().stimulus(tilted)


def test_gradient_of_a_stand_with_a_numerical_derivative() -> None:
    assert exact_gradient_error(parts.problem(parts.D_FAIR, 11, Tilted()), 0) < 1e-6


@pytest.mark.parametrize("count", [1, 5, 700])
def test_loss_of_a_population_is_that_of_its_members(count: int) -> None:
    problem = parts.problem(n=30)
    programs = problem.restrictions.random(np.random.default_rng(1), count)
    assert (count > problem.response.chunk(problem.n)) == (count == 700)
    each = [float(problem.loss(program)) for program in programs]
    np.testing.assert_allclose(problem.loss(programs), each, atol=1e-9)


@given(seed=SEEDS)
def test_canonical_program_is_the_same_program(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = parts.problem(n=10)
    settings = problem.restrictions.random(rng, 1)[0]
    moved = rng.permutation(settings) + 2 * math.pi * rng.integers(-2, 3, (10, 2))
    canonical = problem.restrictions.canonical(moved)
    np.testing.assert_allclose(canonical, problem.restrictions.canonical(settings), atol=1e-9)
    np.testing.assert_array_equal(problem.restrictions.canonical(canonical), canonical)
    assert (np.diff(canonical[:, 0]) > -1e-7).all()
    assert problem.stand.axes.allows(canonical).all()


def test_singular_programs_have_an_infinite_loss_and_no_gradient() -> None:
    problem = parts.problem(n=12)
    faces = parts.program(np.concatenate([parts.FACES, parts.FACES]))
    programs = np.stack([faces, parts.program(parts.icosahedron())])
    for criterion in parts.CRITERIA:
        loss, gradient = parts.problem(criterion, 12).loss_and_gradient(programs)
        assert np.isposinf(loss[0])
        assert np.isfinite(loss[1])
        assert not gradient[0].any()
        assert np.isposinf(parts.problem(criterion, 12).loss(faces))
    assert not np.isfinite(problem.loss(np.stack([faces] * 50))).any()


class Broken(Criterion):
    """A criterion with a mistake."""

    def __init__(self, mistake: Callable[[Information], object]) -> None:
        self.mistake = mistake

    def loss(self, information: Information):  # type: ignore[no-untyped-def]
        return self.mistake(information)


def divide(information: Information) -> float:
    return 1 / 0


MISTAKES: dict[str, tuple[Callable[[Information], object], str]] = {
    "wrong shape": (
        lambda at: at.variances,
        r"Broken.loss returned shape \(.*9\) for matrices of shape \(.*9, 9\)",
    ),
    "one for all": (lambda at: at.log_det.sum() if at.log_det.ndim else np.zeros(3), "Broken.loss returned shape"),
    "nothing": (lambda at: None, "Broken.loss returned"),
    "words": (lambda at: "good", "Broken.loss returned 'good'; expected numbers"),
    "raises": (divide, r"Broken.loss raised ZeroDivisionError: division by zero \(.*test_problem.py, line \d+\)"),
    "nan": (
        lambda at: at.log_det * math.nan,
        "Broken.loss returned nan for an information matrix",
    ),
}


@pytest.mark.parametrize("optimizer", parts.OPTIMIZERS, ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("kind", MISTAKES)
def test_mistakes_of_a_plugin_are_told_plainly(optimizer: Optimizer, kind: str) -> None:
    mistake, message = MISTAKES[kind]
    problem = parts.problem(Broken(mistake))
    with pytest.raises(PluginError, match=message):
        problem.loss(problem.restrictions.random(np.random.default_rng(0), 4))
    with pytest.raises(PluginError, match=r"Broken\.loss"):
        optimizer.solve(problem, np.random.default_rng(0))


def test_mistake_in_a_gradient() -> None:
    class Steep(Broken):
        def gradient(self, information: Information):  # type: ignore[no-untyped-def]
            return np.ones(3)

    problem = parts.problem(Steep(lambda at: -at.log_det))
    with pytest.raises(PluginError, match=r"Steep.gradient returned shape \(3,\)"):
        problem.loss_and_gradient(problem.restrictions.random(np.random.default_rng(0), 4))


def test_errors_of_acalx_pass_through_a_plugin() -> None:
    problem = parts.problem(Broken(lambda at: at.theta("drift")))
    with pytest.raises(ArgumentError, match="no parameter group 'drift'"):
        problem.loss(problem.restrictions.random(np.random.default_rng(0), 4))


# --- fixed positions ---

FIXED = parts.program(parts.icosahedron())[:3]


def held(fixed: object, n: int = 9) -> Problem:
    return Problem(parts.FULL, ScalarAccel(), D(), n, fixed)  # type: ignore[arg-type]


def test_equal_problems_have_equal_fixed_positions() -> None:
    assert held(FIXED) == held(FIXED.copy()) == held(FIXED.tolist())
    assert len({held(FIXED), held(FIXED.copy()), held(None)}) == 2
    different = (None, FIXED + 1e-12, FIXED[:2], FIXED[::-1])
    for other in different:
        assert held(FIXED) != held(other)
    assert held(None) == held(None)
    assert held(FIXED) != Problem(parts.FULL, ScalarAccel(), D(), 9, FIXED, replicates=False)
    assert held(FIXED) != held(FIXED, 10)
    assert held(FIXED) != "a problem"


def test_what_a_caller_does_with_their_array_changes_no_problem() -> None:
    mine = FIXED.copy()
    problem, same = held(mine), held(FIXED)
    before, loss = hash(problem), problem.loss(parts.program(parts.icosahedron())[:9])
    mine[:] = 0.0
    assert problem == same
    assert hash(problem) == before
    assert problem.fixed is not None
    np.testing.assert_array_equal(problem.fixed, FIXED)
    np.testing.assert_array_equal(problem.base_share, same.base_share)
    assert problem.loss(parts.program(parts.icosahedron())[:9]) == loss
    with pytest.raises(ValueError, match="read-only"):
        problem.fixed[:] = 0.0


def test_searches_leave_fixed_positions_alone() -> None:
    mine = FIXED.copy()
    for optimizer in parts.OPTIMIZERS[:1]:
        found = optimizer.solve(held(mine), np.random.default_rng(0))
        np.testing.assert_array_equal(mine, FIXED)
        np.testing.assert_array_equal(found.program[:3], FIXED)


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        (FIXED[0], r"fixed: positions of shape \(2,\); the stand takes \(f, 2\), in rad"),
        (FIXED[None], r"fixed: positions of shape \(1, 3, 2\)"),
        (np.zeros((3, 3)), r"fixed: positions of shape \(3, 3\); the stand takes \(f, 2\)"),
        (np.empty((0, 2)), r"fixed: positions of shape \(0, 2\)"),
        ([[0.0, math.nan]], "fixed: positions must be finite numbers"),
        ([[0.0, math.inf]], "fixed: positions must be finite numbers"),
        ("here", "fixed='here': give an array of positions"),
        ([[0.0], [0.0, 1.0]], "give an array of positions"),
        (np.zeros((9, 2)), r"n=9 with 9 fixed positions leaves nothing to choose: .* give n=10 or more"),
        (np.zeros((12, 2)), r"n=9 with 12 fixed positions .* give n=13 or more"),
    ],
)
def test_bad_fixed_positions(fixed: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        held(fixed)


# --- vectors for populations ---

MIXED = RateTable(step_deg=30)


@pytest.mark.parametrize("stand", [*parts.STANDS, MIXED], ids=repr)
@pytest.mark.parametrize("fixed", [0, 2])
def test_vectors_lead_back_to_their_programs(stand: Stand, fixed: int) -> None:
    model = ScalarAccel() if stand is not MIXED else GyroRateTable()
    rng = np.random.default_rng(0)
    problem = Problem(stand, model, D(), 12, stand.axes.random(rng, (fixed,)) if fixed else None)
    encoding, programs = Encoding(problem.restrictions), problem.restrictions.random(rng, 20)
    vectors = encoding.vectors(programs)
    assert vectors.shape == (20, (12 - fixed) * problem.d)
    assert (vectors >= encoding.bounds[:, 0]).all()
    assert (vectors <= encoding.bounds[:, 1]).all()
    np.testing.assert_allclose(encoding.settings(vectors), programs, atol=1e-12)
    stepped = [setting.step is not None for setting in stand.settings]
    assert list(encoding.integral) == stepped * (12 - fixed)
    moved = np.clip(vectors + 0.4 * encoding.integral, *encoding.bounds.T)  # rounded back to the stop
    np.testing.assert_allclose(encoding.settings(moved), programs, atol=1e-12)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda given: pickle.loads(pickle.dumps(given))])
def test_copies_are_equal_and_as_safe(copied: Callable[[Problem], Problem]) -> None:
    given = Problem(parts.FULL, ScalarAccel(), D(), 12, np.array([[0.1, 0.2], [0.3, 0.4]]))
    again = copied(given)
    assert again == given
    assert hash(again) == hash(given)
    assert again.fixed is not None
    with pytest.raises(ValueError, match="read-only"):
        again.fixed[0, 0] = 1.0


def test_lists_are_as_tuples_and_stay_what_they_were() -> None:
    box: dict[str, list[float]] = {"alpha1_deg": [80, 100]}
    boxes, steps = [box], [15.0, 1.0]
    stand = TwoAxis(step_deg=steps, forbidden=boxes, speed_deg_s=[5, 10])  # type: ignore[arg-type]
    same = TwoAxis(step_deg=(15.0, 1.0), forbidden=({"alpha1_deg": (80, 100)},), speed_deg_s=(5, 10))
    assert stand == same
    box["alpha1_deg"][0] = 0
    steps[0] = 30.0
    boxes.clear()
    assert stand == same
