"""Bounds that no program beats, and the proof of the largest value of a trigonometric polynomial."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acalx.bounds import bound, certify
from acalx.bounds.relaxation import relax, sensitivity
from acalx.criteria import A, Concave, Criterion, D, E
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.numerics.supremum import cells_between, cells_of, supremum
from acalx.optimizers import Gradient
from acalx.problem import Problem
from acalx.programs import published
from acalx.quantities.information import Information
from acalx.search.account import Account
from acalx.search.descent import descend
from acalx.stands import TwoAxis
from acalx.testing import check_criterion
from parts import D_FAIR

# published programs that are D-optimal, the last one but for the rounding of its printed angles
OPTIMAL = ("icosahedron_12", "dodecahedron_20", "egorov_2021_table_2")
D1 = 61509375 / 4  # det of the inverse information of one measurement, uniform on the sphere


def problem(criterion: Criterion, n: int, **limits: object) -> Problem:
    return Problem(TwoAxis(**limits), ScalarAccel(), criterion, n)


@pytest.mark.parametrize("n", [12, 14, 16, 18, 20, 24, 36])
def test_programs_on_the_sphere_are_proved_optimal_for_d(n):
    asked = problem(D(), n)
    certificate = certify(asked, Gradient().solve(asked, np.random.default_rng(0)).program)
    assert certificate.optimal
    assert 1 - 1e-6 <= certificate.efficiency <= 1.0


def test_nine_positions_have_the_known_efficiency():
    asked = problem(D(), 9)
    certificate = certify(asked, Gradient().solve(asked, np.random.default_rng(0)).program)
    least = math.exp(certificate.bound.loss)
    assert certificate.efficiency == pytest.approx(0.97701, abs=1e-5)
    assert least == pytest.approx(D1 / 9**9, rel=2e-6)
    assert least <= D1 / 9**9
    assert certificate.bound.proved
    assert not certificate.optimal


def test_the_bounds_of_a_and_e_on_the_sphere():
    assert math.exp(bound(problem(A(), 12)).loss) == pytest.approx(relaxed_trace() / 12, rel=1e-6)
    assert math.exp(bound(problem(E(), 12)).loss) == pytest.approx(1.0, rel=3e-5)


def relaxed_trace() -> float:
    """Least trace of K over measures on the sphere, by descent from a random measure of many points."""
    relaxation = relax(problem(A(), 12))
    values = np.linalg.eigvalsh(relaxation.information.matrix)
    return float((1.0 / values).sum())


def test_every_published_program_gets_a_certificate():
    stand, model = TwoAxis(), ScalarAccel()
    for program in published().values():
        if program.name.startswith("platform_"):
            continue
        angles = program.settings_for(stand)
        if model.information(stand.stimulus(angles)).inestimable():
            continue
        certificate = certify(Problem(stand, model, D(), program.n), angles)
        assert 0.69 <= certificate.efficiency <= 1.0
        assert certificate.optimal == (program.name in OPTIMAL)


def test_a_product_is_bounded_with_its_floors():
    asked = problem(D_FAIR, 12)
    certificate = certify(asked, Gradient().solve(asked, np.random.default_rng(0)).program)
    assert certificate.optimal
    parts = certificate.entries()["parts"]
    assert parts["D"] == pytest.approx(D1 / 12**9, rel=1e-5)
    assert parts["Inequality bias"] == pytest.approx(5e-4)


@settings(max_examples=12, deadline=None)
@given(
    low=st.tuples(st.integers(-180, 100), st.integers(-180, 100)),
    width=st.tuples(st.integers(50, 200), st.integers(50, 200)),
    n=st.integers(9, 20),
    criterion=st.sampled_from([D(), A()]),
    step=st.sampled_from([None, None, 10.0]),
)
def test_no_program_beats_its_bound(low, width, n, criterion, step):
    limits = {f"alpha{k + 1}_deg": (low[k], low[k] + width[k]) for k in range(2)}
    asked = problem(criterion, n, step_deg=step, **limits)
    programs = asked.restrictions.random(np.random.default_rng(n), 16)
    if step is None:
        programs = descend(asked, programs, account=Account()).settings
    certificate = certify(asked, programs[asked.loss(programs).argmin()])
    assert certificate.gap >= 0
    assert 0 < certificate.efficiency <= 1


def test_stepped_stands_are_bounded_at_their_stops():
    continuous = bound(problem(D(), 9, alpha2_deg=(-40, 40)))
    stepped = bound(problem(D(), 9, alpha2_deg=(-40, 40), step_deg=20))
    assert stepped.loss >= continuous.loss - 1e-5
    assert "every stop" in stepped.method
    assert stepped.status == "proved at every stop"
    assert continuous.status == "proved"


@dataclass(frozen=True)
class Unbounded(Criterion):
    def loss(self, information: Information) -> np.ndarray:
        return np.log(information.variances.max(axis=-1))


def test_a_criterion_that_cannot_be_bounded_says_so():
    asked = problem(Unbounded(), 9)
    certificate = certify(asked, asked.restrictions.random(np.random.default_rng(0), 1)[0])
    assert certificate.bound is None
    assert "Unbounded" in str(certificate)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), degree=st.integers(1, 5))
def test_the_proved_supremum_is_above_dense_samples_and_close(seed, degree):
    rng = np.random.default_rng(seed)
    orders = np.arange(-degree, degree + 1)
    weights = rng.normal(size=(2, len(orders), len(orders)))
    lower = rng.uniform(-3, 0, 2)
    upper = lower + rng.uniform(0.3, 3, 2)

    def function(points: np.ndarray) -> np.ndarray:
        phase = points[:, :1, None] * orders[:, None] + points[:, 1:, None] * orders
        return (weights[0] * np.cos(phase) + weights[1] * np.sin(phase)).sum(axis=(1, 2))

    axes = [np.linspace(a, b, 200) for a, b in zip(lower, upper, strict=True)]
    samples = function(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2))
    target = float(samples.max()) + 1e-3 * float(np.ptp(samples))
    cells = cells_of([cells_between(np.linspace(a, b, 12)) for a, b in zip(lower, upper, strict=True)])
    proof = supremum(function, (degree, degree), cells, target)
    assert proof.value >= samples.max()
    assert proof.value <= target + 0.05 * float(np.ptp(samples))


def test_the_sensitivity_of_a_relaxation_is_one_on_its_support():
    asked = problem(D(), 9, alpha2_deg=(-45, 45))
    relaxation = relax(asked)
    values, _ = sensitivity(asked, relaxation.support, relaxation.settings)
    np.testing.assert_allclose(values, 1.0, atol=1e-4)
    assert math.isclose(relaxation.weights.sum(), 1.0, rel_tol=1e-12)
    assert relaxation.peak <= 1 + 2e-7


def test_an_interrupt_while_bounding_loses_nothing(tmp_path):
    code = "import sys, acalx.planning.design as design\nfrom acalx.commands.run import main\n"
    code += "def stop(*_): raise KeyboardInterrupt\n"
    code += "design.certify = stop\nsys.exit(main())"
    command = [sys.executable, "-c", code, "criterion=d", "optimizer=gradient", "figures=false", "hydra.run.dir=here"]
    outcome = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    result = json.loads((tmp_path / "here" / "result.json").read_text())
    assert outcome.returncode == 130
    assert result["status"] == "interrupted"
    assert result["metrics"]["D"] <= 0.04893153
    assert (tmp_path / "here" / "program.csv").exists()


def test_a_program_that_beats_its_bound_refutes_it() -> None:
    """A criterion that says a wrong degree is not believed."""

    @dataclass(frozen=True)
    class Hasty(Concave):
        def degree(self, p: int) -> float:
            return 1.0  # and it is 2

        def loss(self, information: Information) -> Array:
            return 2.0 * A().loss(information)

        def gradient(self, information: Information) -> Array:
            return 2.0 * A().gradient(information)

    asked = problem(Hasty(), 12)
    found = certify(asked, Gradient().solve(asked, np.random.default_rng(0)).best.settings)
    assert found.bound is None
    assert "is the degree of one of them wrong" in found.reason
    with pytest.raises(AssertionError, match="four times the information takes degree 1 times log 4"):
        check_criterion(Hasty(), ScalarAccel().parameters)
