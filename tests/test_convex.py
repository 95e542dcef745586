"""optimizer=convex: approximate designs by cvxpy and Newton's method, roundings, fallbacks, what it leaves."""

from __future__ import annotations

import csv
import json
import math
import sys
from dataclasses import dataclass
from functools import cache
from typing import final

import numpy as np
import pytest

import parts
from acalx.bounds import bound
from acalx.criteria import A, Ceiling, Concave, Criterion, D, E, Inequality
from acalx.errors import AcalxError, ArgumentError, CompatibilityError
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.optimizers import Convex, Gradient
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.recording import RunDirectory
from acalx.reporting.tables import weights_table
from acalx.search.result import Result
from acalx.stands import Stand, TwoAxis
from acalx.testing import check_optimizer
from command import execute

NARROW = TwoAxis(alpha1_deg=(-30, 30), alpha2_deg=(-60, 60))
QUICK = Convex(candidates=3000, roundings=8)
every = pytest.mark.parametrize("criterion", [D(), A(), E()], ids=lambda criterion: criterion.label)


@cache
def solve(optimizer: Convex, problem: Problem) -> Result:
    return optimizer.solve(problem, np.random.default_rng(0))


def gap_of(problem: Problem, result: Result) -> float:
    """The gap of the weights by Kiefer and Wolfowitz, over a grid of the same size anew; for D."""
    design = result.design
    assert design is not None
    rows = problem.response.regressors(design.settings)[:, 0]
    covariance = np.linalg.inv((rows * design.weights[:, None]).T @ rows)
    grid = problem.stand.axes.candidates(design.candidates, "structured", np.random.default_rng(0))[:]
    others = problem.response.regressors(grid)[:, 0]
    return float(np.einsum("ka,ab,kb->k", others, covariance, others).max() / 9 - 1)


# --- weights and roundings ---


@pytest.mark.parametrize("stand", [*parts.CONTINUOUS, parts.TABLE_15], ids=repr)
def test_contract(stand: Stand) -> None:
    check_optimizer(QUICK, parts.problem(D(), 10, stand))


@every
@pytest.mark.parametrize("stand", [parts.BAND, NARROW], ids=repr)
def test_programs_are_as_good_as_those_of_many_starts(criterion: Criterion, stand: Stand) -> None:
    problem = parts.problem(criterion, 12, stand)
    result = solve(Convex(), problem)
    assert result.status == "ok"
    assert result.design is not None
    assert result.design.gap <= 1e-6
    best = Gradient(starts=60).solve(problem, np.random.default_rng(1)).best.loss
    assert result.best.loss <= best + 1e-6


@pytest.mark.parametrize("solver", ["CLARABEL", "SCS"])
def test_each_solver_leads_to_the_same_weights(solver: str) -> None:
    problem = parts.problem(D(), 12, NARROW)
    result = solve(Convex(candidates=3000, roundings=8, solver=solver), problem)
    assert solver in result.message
    assert gap_of(problem, result) <= 1.01e-6
    assert result.design is not None
    reference = solve(QUICK, problem).design
    assert reference is not None
    assert result.design.loss == pytest.approx(reference.loss, abs=2e-5)


def test_the_bound_of_the_design_is_that_of_the_certificate() -> None:
    problem = parts.problem(D(), 12)
    design = solve(QUICK, problem).design
    assert design is not None
    assert design.loss - 9 * math.log(12) == pytest.approx(bound(problem).loss, abs=1e-4)
    assert len(design.weights) <= 46


def test_neighbors_on_the_grid_are_one_support_point() -> None:
    design = solve(Convex(), parts.problem(D(), 12, TwoAxis(alpha1_deg=(-90, 90), alpha2_deg=(-45, 45)))).design
    assert design is not None
    settings, weights = design.merged()
    assert len(settings) == len(weights) == design.count == 12
    assert weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(np.sort(weights)[-2:], 0.10735, atol=1e-4)


def test_random_candidates_and_a_loose_tolerance() -> None:
    problem = parts.problem(A(), 12, parts.BAND)
    result = solve(Convex(candidates=2000, kind="random", tolerance=1e-3, roundings=4), problem)
    assert result.status == "ok"
    assert result.design is not None
    assert result.design.candidates == 2000
    assert "Newton" not in result.message


def test_rounds_that_run_out_are_a_limit() -> None:
    result = solve(Convex(rounds=1, roundings=4), parts.problem(D(), 12, NARROW))
    assert result.status == "limit"
    assert "instead of 1e-06" in result.message
    assert result.design is not None
    assert result.design.gap > 1e-6


def test_stepped_stands_are_obeyed() -> None:
    problem = parts.problem(D(), 9, parts.TABLE_15)
    result = solve(Convex(roundings=12), problem)
    assert problem.stand.axes.allows(result.best.settings).all()
    assert result.design is not None
    assert problem.stand.axes.allows(result.design.settings).all()
    assert math.exp(result.best.loss) < 0.06


# --- criteria of others, fallbacks ---


@dataclass(frozen=True)
class LogDet(Concave):
    """D with no more than what makes it convex."""

    def loss(self, information: Information) -> Array:
        return -information.log_det

    def degree(self, p: int) -> float:
        return float(p)


def test_without_an_expression_newton_does_it_alone() -> None:
    problem = parts.problem(LogDet(), 12, NARROW)
    result = solve(Convex(candidates=500, roundings=2), problem)
    assert "LogDet gives cvxpy no expression; Newton's method alone" in result.message
    assert gap_of(problem, result) <= 1.1e-6


@dataclass(frozen=True)
class Wrong(Concave):
    """D whose expression breaks cvxpy's rules."""

    def loss(self, information: Information) -> Array:
        return -information.log_det

    def gradient(self, information: Information) -> Array:
        return -information.covariance

    def degree(self, p: int) -> float:
        return float(p)

    def convex(self, matrix: object, factor: Array) -> object:
        import cvxpy

        return cvxpy.log_det(matrix)


@final
@dataclass(frozen=True)
class Worst(Ceiling, Concave):
    """E with nothing for Newton's method."""

    def loss(self, information: Information) -> Array:
        return E().loss(information)

    def degree(self, p: int) -> float:
        return 1.0

    def support(self, information: Information, multiplier: Array | None) -> Array:
        return E().support(information, multiplier)

    def least_loss(self, support: Array, at: Information) -> Array:
        return E().least_loss(support, at)

    def convex(self, matrix: object, factor: Array) -> object:
        return E().convex(matrix, factor)

    @property
    def log_floor(self) -> float:
        return -math.inf

    def start(self, parameters: tuple[Parameter, ...], stack: tuple[int, ...]) -> Array:
        return E().start(parameters, stack)

    def hold(
        self, information: Information, log_t: Array, multiplier: Array, penalty: Array
    ) -> tuple[Array, Array, Array, Array]:
        return E().hold(information, log_t, multiplier, penalty)


def test_kinks_that_newton_does_not_know_are_left_to_cvxpy() -> None:
    result = solve(Convex(candidates=1000, roundings=2), parts.problem(Worst(), 12, NARROW))
    assert "Newton" not in result.message
    assert result.design is not None
    assert result.design.gap < 1e-4


def test_solvers_that_fail_are_named_and_followed_by_the_next() -> None:
    result = solve(Convex(candidates=500, roundings=2), parts.problem(Wrong(), 12, NARROW))
    assert "CLARABEL failed" in result.message
    assert "SCS failed" in result.message
    assert "Newton's method alone" in result.message
    assert result.status == "ok"
    with pytest.raises(AcalxError, match=r"solver=SCS: SCS failed: .*; installed are .*CLARABEL"):
        solve(Convex(solver="SCS"), parts.problem(Wrong(), 12, NARROW))


def test_a_solver_for_other_problems_is_an_error() -> None:
    with pytest.raises(AcalxError, match=r"solver=OSQP: OSQP failed: .*installed are .*CLARABEL.*SCS"):
        solve(Convex(solver="OSQP"), parts.problem())


def test_a_solver_that_is_not_installed_is_an_error() -> None:
    with pytest.raises(ArgumentError, match=r"solver='NOSUCH': .* installed are .*CLARABEL.*SCS.*take solver=None"):
        solve(Convex(solver="NOSUCH"), parts.problem())


def test_without_cvxpy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    result = QUICK.solve(parts.problem(E(), 12, NARROW), np.random.default_rng(0))
    assert "(Newton's method alone)" in result.message
    assert result.status == "ok"
    with pytest.raises(ArgumentError, match="cvxpy is not installed at all"):
        Convex(solver="CLARABEL").check(parts.problem())


@pytest.mark.parametrize("criterion", [parts.D_FAIR, Inequality("bias")], ids=repr)
def test_criteria_that_are_not_convex_are_refused(criterion: Criterion) -> None:
    with pytest.raises(CompatibilityError, match=r"a convex criterion, and (D \* \(Inequality bias\)|Inequality)"):
        solve(Convex(), parts.problem(criterion))


def test_candidates_that_do_not_show_a_parameter() -> None:
    with pytest.raises(AcalxError, match=r"no weights on these \d+ candidates can estimate .*bias_x"):
        solve(Convex(), parts.problem(D(), 12, TwoAxis(alpha1_deg=(0, 1e-13))))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"candidates": 0}, "candidates=0: must be a whole number"),
        ({"rounds": 1.5}, r"rounds=1\.5"),
        ({"roundings": -1}, "roundings=-1"),
        ({"tolerance": 0.0}, r"tolerance=0\.0: must be a positive number"),
        ({"kind": "grid"}, "kind='grid': must be structured or random"),
        ({"solver": 3}, "solver=3: must be the name of a solver"),
    ],
)
def test_bad_options(options: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Convex(**options)  # type: ignore[arg-type]


# --- what is left behind ---


def test_weights_csv(tmp_path) -> None:
    problem = parts.problem(D(), 12, NARROW)
    design = solve(QUICK, problem).design
    assert design is not None
    RunDirectory(tmp_path / "run", []).write_weights(problem.stand, design)
    with (tmp_path / "run" / "weights.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["point", "alpha1_deg", "alpha2_deg", "eta_x", "eta_y", "eta_z", "weight", "dwell_share"]
    weights = np.array([float(row["weight"]) for row in rows])
    assert weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose([float(row["dwell_share"]) for row in rows], 100 * weights)
    angles = np.radians([[float(row["alpha1_deg"]), float(row["alpha2_deg"])] for row in rows])
    information = ScalarAccel().regressors(problem.stand.stimulus(angles))[:, 0]
    loss = -np.linalg.slogdet((information * weights[:, None]).T @ information)[1]
    assert loss == pytest.approx(design.loss, abs=1e-7)
    points = [int(row["point"]) for row in rows]
    assert points == sorted(points)
    totals = np.bincount(points, weights)[1:]
    assert (np.diff(totals) <= 1e-12).all()


def test_weights_table_says_what_it_leaves_out() -> None:
    settings, weights = parts.FULL.axes.random(np.random.default_rng(0), (30,)), np.full(30, 1 / 30)
    lines = weights_table(parts.FULL, settings, weights).splitlines()
    assert " ".join(lines[0].split()) == "support point alpha1 deg alpha2 deg eta x eta y eta z dwell share"
    assert lines[1].endswith("3.333 %")
    assert lines[-1] == "... 10 more with 33.333 % in weights.csv"


def test_the_command(tmp_path) -> None:
    job = ["python", "-m", "acalx.run", "criterion=d", "optimizer=convex", "n=12", "figures=false"]
    outcome = execute(tmp_path, *job, "stand.alpha2_deg=[-45,45]")
    assert outcome.status == 0, outcome.err
    result = json.loads(next(tmp_path.glob("runs/*/result.json")).read_text())
    assert result["design"]["gap"] <= 1e-6
    assert result["design"]["efficiency"] >= 0.999999
    assert result["design"]["value"] == pytest.approx(math.exp(result["design"]["loss"]))
    assert next(tmp_path.glob("runs/*/weights.csv")).exists()
    assert "dwell share" in outcome.out
    assert outcome.out.count("%") > 12
