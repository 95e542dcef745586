from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import parts
from acalx.criteria import A, Criterion, D, E
from acalx.errors import AcalxError, ArgumentError, CompatibilityError
from acalx.numerics.arrays import Array
from acalx.optimizers import DifferentialEvolution, Gradient, Optimizer
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.search.account import Account
from acalx.search.agreement import distinct_solutions, judge
from acalx.search.descent import descend
from acalx.search.result import Result
from acalx.stands import Stand, TwoAxis
from acalx.testing import check_optimizer

GRADIENT, DE, EXCHANGE = parts.OPTIMIZERS
NAN, INF = math.nan, math.inf
both = pytest.mark.parametrize("optimizer", [GRADIENT, DE], ids=["gradient", "de"])


@cache
def solve(optimizer: Optimizer, problem: Problem, seed: int = 0) -> Result:
    return optimizer.solve(problem, np.random.default_rng(seed))


# --- the contract ---


@pytest.mark.parametrize("stand", parts.CONTINUOUS, ids=repr)
@pytest.mark.parametrize("optimizer", [GRADIENT, DifferentialEvolution(restarts=1)], ids=["gradient", "de"])
def test_contract(optimizer: Optimizer, stand: Stand) -> None:
    check_optimizer(optimizer, parts.problem(D(), 9, stand))


@pytest.mark.parametrize("criterion", [A(), E(), parts.D_FAIR], ids=repr)
@pytest.mark.parametrize(
    "optimizer",
    [Gradient(starts=10, batch=4), DifferentialEvolution(restarts=1, maxiter=40, companions=3)],
    ids=["gradient", "de"],
)
def test_contract_for_other_criteria(optimizer: Optimizer, criterion: Criterion) -> None:
    check_optimizer(optimizer, parts.problem(criterion, 10, parts.BAND), seed=1)


@pytest.mark.parametrize("stand", parts.STEPPED, ids=repr)
def test_contract_for_steps(stand: Stand) -> None:
    check_optimizer(DifferentialEvolution(restarts=1, maxiter=50, companions=2), parts.problem(D(), 9, stand))


# --- known optima ---


def bound(n: int) -> float:
    """Least D of n positions: det of (n M1)^-1, with M1 the information of the uniform measure on the sphere."""
    second, fourth, mixed = Fraction(1, 3), Fraction(1, 5), Fraction(1, 15)
    scale = (fourth - mixed) ** 2 * (fourth + 2 * mixed)  # determinant of the block of x^2, y^2, z^2
    return float(1 / (second**3 * scale * mixed**3 * n**9))


def test_bound_is_that_of_the_facts() -> None:
    assert bound(1) == pytest.approx(1.5377e7, rel=1e-4)
    assert [bound(9), bound(12), bound(18)] == pytest.approx([0.0396916, 0.00298023, 7.75227e-5], rel=1e-5)


def test_icosahedron_attains_the_bound() -> None:
    loss = parts.problem(n=12).loss(parts.program(parts.icosahedron()))
    assert math.exp(loss) == pytest.approx(bound(12), rel=1e-12)


def test_published_symmetric_programs() -> None:
    cube = parts.program(np.concatenate([parts.FACES, parts.EDGES]))
    assert math.exp(parts.problem(n=18).loss(cube)) == pytest.approx(8.6e-5, rel=6e-3)
    vertices = [(1, 1, 1), (1, -1, -1), (-1, 1, -1)]
    nine = parts.program(np.concatenate([parts.FACES, vertices]))
    assert math.exp(parts.problem(n=9).loss(nine)) == pytest.approx(0.7119, abs=5e-5)


@given(st.integers(0, 2**32 - 1), st.integers(9, 40))
def test_no_program_is_better_than_the_bound(seed: int, n: int) -> None:
    loss = parts.problem(n=n).loss(parts.FULL.axes.random(np.random.default_rng(seed), (n,)))
    assert loss >= math.log(bound(n)) - 1e-9


@pytest.mark.parametrize("seed", range(5))
@both
def test_best_known_d(optimizer: Optimizer, seed: int) -> None:
    for n, best in ((9, 0.04893153), (18, 7.752269e-5)):
        result = solve(optimizer, parts.problem(D(), n), seed)
        assert math.exp(result.best.loss) <= best
        assert math.exp(result.best.loss) >= bound(n) * (1 - 1e-9)
        assert result.status == "ok"


@pytest.mark.parametrize("n", [12, 14, 16, 20, 24, 36])
def test_gradient_attains_the_bound(n: int) -> None:
    result = solve(GRADIENT, parts.problem(D(), n))
    assert bound(n) * (1 - 1e-9) <= math.exp(result.best.loss) <= bound(n) * (1 + 1e-6)


@pytest.mark.parametrize("seed", range(5))
@both
def test_fair_compromise_costs_nothing_at_nine_positions(optimizer: Optimizer, seed: int) -> None:
    problem = parts.problem(parts.D_FAIR)
    information = problem.information(solve(optimizer, problem, seed).best.settings)
    assert math.exp(-information.log_det) <= 0.048932
    assert max(float(information.inequality(group)) for group in parts.GROUPS) <= 6e-4


@cache
def best_of_200(problem: Problem) -> float:
    starts = problem.restrictions.random(np.random.default_rng(77), 200)
    return float(descend(problem, starts, account=Account()).loss.min())


@pytest.mark.parametrize(
    ("criterion", "n", "stand"),
    [
        *((criterion, 9, parts.BAND) for criterion in (D(), A(), E(), parts.D_FAIR)),
        *((criterion, 12, parts.BAND) for criterion in (D(), A(), parts.D_FAIR)),
        (E(), 10, parts.BAND),
        *((criterion, 9, parts.PATCH) for criterion in (D(), A(), parts.D_FAIR)),
    ],
    ids=lambda value: value.alpha2_deg if isinstance(value, TwoAxis) else None,
)
@both
def test_limited_stands(optimizer: Optimizer, criterion: Criterion, n: int, stand: Stand) -> None:
    problem = parts.problem(criterion, n, stand)
    result = solve(optimizer, problem)
    assert result.best.loss <= best_of_200(problem) + 1e-4
    assert stand.axes.allows(result.best.settings).all()


@both
def test_limits_can_only_hurt(optimizer: Optimizer) -> None:
    free, band = (solve(optimizer, parts.problem(D(), 9, stand)).best.loss for stand in (parts.FULL, parts.BAND))
    assert band > free + 0.1


# --- descent ---


@pytest.mark.parametrize("criterion", [D(), A(), E(), parts.D_FAIR], ids=repr)
@pytest.mark.parametrize("stand", [parts.FULL, parts.PATCH], ids=repr)
def test_descent_never_ends_above_its_start_or_outside(criterion: Criterion, stand: Stand) -> None:
    problem = parts.problem(criterion, 10, stand)
    starts = problem.restrictions.random(np.random.default_rng(0), 6)
    account = Account()
    ends = descend(problem, starts, account=account)
    assert (ends.loss <= problem.loss(starts)).all()
    np.testing.assert_allclose(problem.loss(ends.settings), ends.loss, atol=1e-9)
    assert stand.axes.allows(ends.settings).all()
    assert account.best is not None
    assert account.best.loss == pytest.approx(ends.loss.min(), abs=1e-9)


def test_smooth_minima_have_no_slope_left() -> None:
    problem = parts.problem(A(), 11)
    ends = descend(problem, problem.restrictions.random(np.random.default_rng(0), 8), account=Account())
    assert ends.converged.all()
    assert np.abs(problem.loss_and_gradient(ends.settings)[1]).max() < 1e-4


# --- steps ---


def test_steps_are_obeyed_and_worth_it() -> None:
    problem = parts.problem(D(), 9, parts.TABLE_15)
    result = solve(DifferentialEvolution(restarts=3), problem)
    degrees = np.degrees(result.best.settings)
    np.testing.assert_allclose(degrees, 15 * np.round(degrees / 15), atol=1e-9)
    assert 0.04893152 < math.exp(result.best.loss) < 0.07
    stops = [setting.stops() for setting in problem.stand.settings]
    grid = np.stack(np.meshgrid(*stops), axis=-1).reshape(-1, 2)
    for position in range(9):
        exchanged = np.repeat(result.best.settings[None], len(grid), axis=0)
        exchanged[:, position] = grid
        assert problem.loss(exchanged).min() >= result.best.loss - 1e-9


@pytest.mark.parametrize("stand", parts.STEPPED, ids=repr)
def test_gradient_refuses_steps_naming_both(stand: Stand) -> None:
    problem = parts.problem(D(), 9, stand)
    with pytest.raises(
        CompatibilityError, match=r"optimizer Gradient .* stand TwoAxis stops at steps .* optimizer=Exchange\(\)"
    ):
        solve(GRADIENT, problem)


# --- criteria of others ---


@dataclass(frozen=True)
class LogDet(Criterion):
    """D without its gradient."""

    def loss(self, information: Information) -> Array:
        return -information.log_det


@both
def test_criterion_with_a_loss_only(optimizer: Optimizer) -> None:
    problem = parts.problem(LogDet())
    programs = problem.restrictions.random(np.random.default_rng(0), 5)
    exact, numerical = (p.loss_and_gradient(programs)[1] for p in (parts.problem(), problem))
    np.testing.assert_allclose(numerical, exact, atol=1e-6 * np.abs(exact).max())
    assert math.exp(solve(optimizer, problem).best.loss) <= 0.04893153


@pytest.mark.parametrize("optimizer", [GRADIENT, DifferentialEvolution(restarts=1, maxiter=20)], ids=["gradient", "de"])
def test_positions_that_can_not_show_a_parameter(optimizer: Optimizer) -> None:
    problem = parts.problem(D(), 12, TwoAxis(alpha1_deg=(0, 1e-13)))
    with pytest.raises(AcalxError, match=r"no program of 12 positions within alpha1_deg=\[0, 1e-13\]") as caught:
        solve(optimizer, problem)
    shown = str(caught.value).rpartition("no position there shows ")[2].split("; ")
    assert sorted(shown) == ["bias_x", "nonorthogonality_xy", "nonorthogonality_xz", "scale_x"]


# --- the account: interrupts, history ---


@pytest.mark.parametrize("criterion", [D(), parts.D_FAIR], ids=["d", "d_fair"])
@pytest.mark.parametrize("calls", [1, 4])
@both
def test_interrupt_leaves_the_best_so_far(optimizer: Optimizer, calls: int, criterion: Criterion) -> None:
    problem = parts.problem(criterion, 9, parts.BAND)
    best: list[float] = []

    def watch(account: Account) -> None:
        assert account.best is not None
        best.append(account.best.loss)
        if len(best) == calls:
            raise KeyboardInterrupt

    result = optimizer.solve(problem, np.random.default_rng(0), watch)
    assert len(best) == calls
    assert result.status == "interrupted"
    assert "interrupted after" in result.message
    assert result.best.loss == min(best)
    assert problem.loss(result.best.settings) == pytest.approx(result.best.loss, abs=1e-9)
    assert problem.stand.axes.allows(result.best.settings).all()
    assert result.best.loss > solve(optimizer, problem).best.loss


@both
def test_interrupt_before_any_program_is_an_interrupt(optimizer: Optimizer) -> None:
    class Stopped(Criterion):
        def loss(self, information: Information) -> Array:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(optimizer, parts.problem(Stopped()))


@both
def test_watching_changes_nothing_and_shows_progress(optimizer: Optimizer) -> None:
    problem = parts.problem(D(), 10, parts.BAND)
    fractions: list[float] = []
    watched = optimizer.solve(problem, np.random.default_rng(4), lambda account: fractions.append(account.fraction))
    alone = solve(optimizer, problem, 4)
    assert watched.best.settings.tobytes() == alone.best.settings.tobytes()
    assert all(0.0 <= fraction <= 1.0 for fraction in fractions)
    assert fractions == sorted(fractions)
    evaluations = [count for count, _, _ in watched.history]
    assert evaluations == sorted(evaluations)
    assert evaluations[-1] <= watched.evaluations


def test_limits_on_the_search_are_a_status_of_their_own() -> None:
    problem = parts.problem(D(), 13, TwoAxis(alpha1_deg=(0, 90), alpha2_deg=(0, 90)))
    assert solve(Gradient(starts=4, batch=4, iterations=2), problem).status == "limit"
    assert solve(DifferentialEvolution(restarts=2, maxiter=3, polish=False), problem).status == "limit"


def test_polish_gains() -> None:
    problem = parts.problem(D(), 9)
    rough = solve(DifferentialEvolution(restarts=1, maxiter=30, polish=False), problem)
    polished = solve(DifferentialEvolution(restarts=1, maxiter=30, companions=0), problem)
    assert rough.gain is None
    assert polished.gain is not None
    assert polished.best.loss + polished.gain == pytest.approx(rough.best.loss, abs=1e-9)
    assert polished.gain > 0.1


# --- agreement ---


@given(st.integers(1, 60), st.integers(1, 60))
def test_verdict_follows_the_rule(starts: int, minima: int) -> None:
    minima = min(starts, minima)
    losses = np.concatenate([np.zeros(starts - minima), np.arange(float(minima))])
    verdict = judge(losses, 1e-5)
    assert (verdict.starts, verdict.minima, verdict.best) == (starts, minima, starts - minima + 1)
    expected = minima * (starts - 1) / (starts - minima - 2) if starts > minima + 2 else INF
    assert verdict.settled == (verdict.best >= 3 and expected < minima + 0.5)


def test_starts_that_ended_nowhere_are_no_agreement() -> None:
    verdict = judge(np.full(10, INF), 1e-5)
    assert (verdict.starts, verdict.best, verdict.settled) == (10, 0, False)
    assert judge(np.array([0.0, 0.0, INF]), 1e-5).minima == 2


def test_solutions_are_distinct_sets_of_positions_and_equally_good() -> None:
    problem = parts.problem(n=12)
    rng = np.random.default_rng(0)
    icosahedron = parts.program(parts.icosahedron())
    turned = parts.program(parts.icosahedron() @ np.linalg.qr(rng.standard_normal((3, 3)))[0])
    worse = problem.restrictions.random(rng, 1)[0]
    programs = [worse, icosahedron, rng.permutation(icosahedron) + 2 * math.pi, turned]
    kept = distinct_solutions(problem, programs, [float(problem.loss(p)) for p in programs], 1e-6)
    assert len(kept) == 2
    assert [solution.loss for solution in kept] == sorted(solution.loss for solution in kept)
    assert all(abs(solution.loss - math.log(bound(12))) < 1e-9 for solution in kept)


# --- other processes ---

CHILD = """
import numpy as np, parts, resource, sys
name, n = sys.argv[1], int(sys.argv[2])
optimizer = dict(gradient=parts.OPTIMIZERS[0], de=parts.OPTIMIZERS[1])[name]
result = optimizer.solve(parts.problem(parts.D(), n, parts.BAND), np.random.default_rng(5))
print(result.best.settings.tobytes().hex(), result.best.loss, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def child(*arguments: str, **environment: str) -> list[str]:
    surroundings = {**os.environ, "PYTHONPATH": str(Path(__file__).parent), **environment}
    command = [sys.executable, "-c", CHILD, *arguments]
    return subprocess.run(command, env=surroundings, capture_output=True, text=True, check=True).stdout.split()


@both
def test_same_seed_in_another_process_gives_the_same_bytes(optimizer: Optimizer) -> None:
    name = "gradient" if optimizer == GRADIENT else "de"
    here = solve(optimizer, parts.problem(D(), 9, parts.BAND), 5).best.settings.tobytes().hex()
    assert child(name, "9", PYTHONHASHSEED="1", OPENBLAS_NUM_THREADS="1")[0] == here


@both
def test_another_seed_gives_another_program(optimizer: Optimizer) -> None:
    one, other = (solve(optimizer, parts.problem(D(), 9, parts.FULL), seed).best.settings for seed in (1, 2))
    assert not np.allclose(one, other)


def test_a_thousand_positions_take_little_memory() -> None:
    _, loss, kilobytes = child("gradient", "1000")
    assert int(kilobytes) < 2**20
    problem = parts.problem(n=1000, stand=parts.BAND)
    assert float(loss) < problem.loss(problem.restrictions.random(np.random.default_rng(0), 50)).min() - 0.5
    full = solve(GRADIENT, parts.problem(D(), 1000))
    assert math.log(bound(1000)) - 1e-9 <= full.best.loss <= math.log(bound(1000)) + 1e-6


# --- options ---

NO_COUNTS = (0, -1, 2.5, "many", None, True, NAN)
NOT_POSITIVE = (0, -1, INF, NAN, "x", None)
BAD: list[tuple[type[Optimizer], str, object]] = [
    *((Gradient, name, bad) for name in ("starts", "batch", "iterations") for bad in NO_COUNTS),
    *((Gradient, name, bad) for name in ("agreement", "tolerance") for bad in NOT_POSITIVE),
    *((DifferentialEvolution, name, b) for name in ("restarts", "agree", "popsize", "maxiter") for b in NO_COUNTS),
    *((DifferentialEvolution, name, bad) for name in ("agreement", "spread") for bad in NOT_POSITIVE),
    *((DifferentialEvolution, "strategy", bad) for bad in ("best", "", 3, None)),
    *((DifferentialEvolution, "mutation", bad) for bad in (-1, 2, NAN, "x", None, (), (0.1, 0.2, 0.3), (0.1, 3))),
    *((DifferentialEvolution, "recombination", bad) for bad in (-0.1, 1.1, NAN, "x", None)),
    *((DifferentialEvolution, "companions", bad) for bad in (-1, 1.5, "x", None)),
    *((DifferentialEvolution, "polish", bad) for bad in ("yes", 1, None)),
]


@pytest.mark.parametrize(("kind", "name", "bad"), BAD)
def test_bad_options(kind: type[Optimizer], name: str, bad: object) -> None:
    with pytest.raises(ArgumentError) as caught:
        kind(**{name: bad})
    assert str(caught.value).startswith(f"{name}={bad!r}: must be ")


@pytest.mark.parametrize("strategy", ["best1exp", "rand1bin", "randtobest1bin", "currenttobest1exp", "rand2exp"])
def test_strategies_of_scipy(strategy: str) -> None:
    optimizer = DifferentialEvolution(restarts=1, maxiter=3, strategy=strategy, mutation=0.5, companions=0)
    result = solve(optimizer, parts.problem(D(), 9))
    assert math.exp(result.best.loss) < 0.06
