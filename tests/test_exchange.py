"""Exchange: rank-one formulas against plain ones, known programs of coarse tables, fine steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from acalx.criteria import A, D, E
from acalx.errors import ArgumentError
from acalx.models import ScalarAccel
from acalx.optimizers import Exchange
from acalx.problem import Problem
from acalx.quantities.exchanged import Exchanged
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.search.account import Account
from acalx.search.descent import descend
from acalx.search.starts import regular_starts
from acalx.search.swaps import candidates_of, descend_swaps, nearest
from acalx.stands import TwoAxis
from parts import CRITERIA, D_FAIR


def problem(criterion=None, n=9, **stand):
    return Problem(TwoAxis(**stand), ScalarAccel(), criterion or D(), n)


@pytest.mark.parametrize("outputs", [1, 3])
@pytest.mark.parametrize("each", [False, True], ids=["the same candidates", "candidates of each"])
@pytest.mark.parametrize("criterion", CRITERIA, ids=repr)
def test_losses_after_an_exchange_are_those_of_the_new_matrices(criterion, outputs, each):
    rng = np.random.default_rng(0)
    parameters = ScalarAccel().parameters
    rows = rng.normal(size=(4, 12, outputs, 9))
    added = rng.normal(size=(4, 30, outputs, 9) if each else (30, outputs, 9))
    before = Information.from_regressors(rows, parameters)
    exchanged = Exchanged(before, rows[:, 2], added)
    assert not exchanged.lost.any()
    without = before.matrix - rows[:, 2].swapaxes(-1, -2) @ rows[:, 2]
    plain = Information(without[:, None] + added.swapaxes(-1, -2) @ added, parameters)
    np.testing.assert_allclose(criterion.loss(exchanged), criterion.loss(plain), rtol=1e-9, atol=1e-9)


def test_an_exchange_that_makes_a_program_singular_is_lost():
    parameters = tuple(Parameter(name, "all", "g") for name in "xyz")
    rows = np.eye(3)[None, :, None, :]
    exchanged = Exchanged(
        Information.from_regressors(rows, parameters), rows[:, 0], np.array([[[0.0, 1, 1]], [[2.0, 1, 0]]])
    )
    np.testing.assert_array_equal(exchanged.lost, [[True, False]])
    assert exchanged.log_det[0, 1] == pytest.approx(math.log(4))
    assert np.isfinite(exchanged.variances).all()


def test_a_table_of_45_degrees_has_26_directions():
    assert len(candidates_of(problem(step_deg=45), 1).settings) == 26


@pytest.mark.parametrize(("n", "best"), [(9, 0.110919), (12, 0.00390626)])
@pytest.mark.parametrize("seed", range(3))
def test_the_best_programs_of_a_45_degree_table(n, best, seed):
    result = Exchange().solve(problem(n=n, step_deg=45), np.random.default_rng(seed))
    assert math.exp(result.best.loss) <= best
    assert result.status == "ok"


@pytest.mark.parametrize(("criterion", "step"), [(D(), 10), (D_FAIR, 15), (A(), 20), (E(), 30), (D_FAIR, 30)])
def test_as_good_as_the_best_of_a_hundred_starts(criterion, step):
    bound = problem(criterion, 10, step_deg=step)
    starts = regular_starts(bound, np.random.default_rng(5), 100)
    best = descend_swaps(bound, starts, candidates_of(bound, 1), account=Account()).loss.min()
    assert Exchange().solve(bound, np.random.default_rng(0)).best.loss <= best + 1e-9


def test_fine_steps_come_within_their_square_of_no_steps():
    free = problem(n=12)
    best = descend(free, free.restrictions.random(np.random.default_rng(0), 8), account=Account()).loss.min()
    for step in (0.1, 1.0):
        bound = problem(n=12, step_deg=step)
        result = Exchange(chains=1, patience=1, starts=8).solve(bound, np.random.default_rng(0))
        assert bound.stand.axes.allows(result.best.settings).all()
        assert result.best.loss <= best + 5 * math.radians(step) ** 2


def test_no_exchange_of_one_position_is_better():
    bound = problem(E(), 10, step_deg=30)
    candidates = candidates_of(bound, 1)
    ends = descend_swaps(bound, regular_starts(bound, np.random.default_rng(0), 5), candidates, account=Account())
    for program, loss in zip(ends.settings, ends.loss, strict=True):
        for position in range(bound.n):
            changed = np.repeat(program[None], len(candidates.settings), axis=0)
            changed[:, position] = candidates.settings
            assert bound.loss(changed).min() >= loss - 1e-9


def test_rounding_takes_the_nearest_stop():
    bound = problem(step_deg=10, alpha1_deg=(-90, 90), alpha2_deg=(0, 340))
    programs = TwoAxis(alpha1_deg=(-90, 90), alpha2_deg=(0, 340)).axes.random(np.random.default_rng(0), (3, 9))
    stops = nearest(bound, programs, None)
    assert bound.stand.axes.allows(stops).all()
    assert np.abs(np.degrees(stops - programs)).max() <= 5 + 1e-9
    every = candidates_of(bound, 1)
    assert bound.stand.axes.allows(nearest(bound, programs, every)).all()


@pytest.mark.parametrize("name", ["chains", "agree", "starts", "elite", "copies", "patience", "candidates"])
def test_counts_are_whole_numbers(name):
    with pytest.raises(ArgumentError, match=f"{name}=0"):
        Exchange(**{name: 0})
