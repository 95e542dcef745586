"""Free rotations of programs, chosen by a second criterion."""

from __future__ import annotations

import numpy as np
import pytest

from acalx.criteria import A, D, E
from acalx.errors import CompatibilityError
from acalx.models import ScalarAccel
from acalx.optimizers import Gradient
from acalx.planning.orientation import Rotations, orient
from acalx.problem import Problem
from acalx.stands import TwoAxis
from command import run
from parts import D_FAIR


def best(criterion, n=9, **stand):
    problem = Problem(TwoAxis(**stand), ScalarAccel(), criterion, n)
    return problem, Gradient().solve(problem, np.random.default_rng(0)).solutions


@pytest.mark.parametrize("second", [A(), E(), D_FAIR], ids=["A", "E", "D_FAIR"])
@pytest.mark.parametrize("n", [9])
def test_the_second_criterion_gets_better_and_the_first_stays(n, second):
    problem, solutions = best(D(), n)
    turned = orient(problem, solutions, second, np.random.default_rng(0))
    assert turned.solution.loss == pytest.approx(solutions[0].loss, abs=1e-9)
    assert problem.with_criterion(second).loss(turned.solution.settings) == pytest.approx(turned.after, abs=1e-9)
    assert turned.after <= turned.before
    rng = np.random.default_rng(1)
    for solution in solutions[:3]:  # no random rotation is better
        directions = problem.stand.stimulus(solution.settings)["specific_force"]
        turns = np.linalg.qr(rng.normal(size=(500, 3, 3)))[0]
        turns = turns * np.sign(np.linalg.det(turns))[:, None, None]
        settings = problem.stand.aim(directions @ turns)
        assert turned.after <= problem.with_criterion(second).loss(settings).min() + 1e-6


def test_the_gradient_with_respect_to_the_rotation_is_exact():
    problem, solutions = best(D())
    rotations = Rotations(problem, problem.stand.stimulus(solutions[0].settings)["specific_force"], A())
    vectors = np.random.default_rng(0).normal(0, 1, (6, 1, 3))
    vectors[0] = 0.0
    _, gradient = rotations.loss_and_gradient(vectors)
    for k in range(3):
        step = 1e-6 * np.eye(3)[k]
        numerical = (rotations.loss(vectors + step) - rotations.loss(vectors - step)) / 2e-6
        np.testing.assert_allclose(gradient[:, 0, k], numerical, atol=1e-6)


def test_what_can_not_be_rotated_is_refused():
    problem, solutions = best(A())
    with pytest.raises(CompatibilityError, match="criterion A changes by"):
        orient(problem, solutions, D(), np.random.default_rng(0))
    table = Problem(TwoAxis(step_deg=15), ScalarAccel(), D(), 9)
    with pytest.raises(CompatibilityError, match="steps only"):
        orient(table, solutions, A(), np.random.default_rng(0))
    held = Problem(TwoAxis(), ScalarAccel(), D(), 9, solutions[0].settings[:3])
    with pytest.raises(CompatibilityError, match="fixed positions"):
        orient(held, solutions, A(), np.random.default_rng(0))


def test_limits_of_the_stand_are_obeyed():
    problem, solutions = best(D(), alpha1_deg=(-90, 80))
    turned = orient(problem, solutions, A(), np.random.default_rng(0))
    assert problem.stand.axes.allows(turned.solution.settings, tolerance=1e-6).all()
    assert turned.after <= turned.before


def test_orient_on_the_command_line_runs_again_from_its_record(tmp_path):
    first = run(tmp_path, "criterion=d", "orient=d_fair", "n=9", "figures=false", into="first")
    assert first.status == 0, first.err
    assert "turned at no cost" in first.result["message"]
    assert first.metrics["inequality"]["bias"] < 1e-3
    again = run(tmp_path, f"--config-dir={first.directory}", "--config-name=resolved", into="again")
    assert (again.directory / "program.csv").read_text() == (first.directory / "program.csv").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("criterion=a", "orient=d"), "criterion A changes by"),
        (("criterion=d", "orient=dfair"), "orient: there is no criterion dfair; did you mean d_fair"),
        (("objectives=[d,a]", "optimizer=scalarized", "orient=e"), "not several"),
        (("criterion=d", "orient=a", "stand.step_deg=15"), "steps only"),
    ],
)
def test_orient_is_refused_before_the_search(tmp_path, arguments, words):
    outcome = run(tmp_path, *arguments, "figures=false")
    assert outcome.status == 1
    assert words in outcome.err
    assert outcome.result["evaluations"] == 0
