"""Noise from 1e-12 to 1e6: nothing that is designed, bounded, judged or shown depends on the size of a double."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parts
from acalx.bounds import Certificate, certify
from acalx.criteria import A, Criterion, D, E, Target
from acalx.models import GyroRateTable, Joined, Model, Platform, VectorAccel
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient
from acalx.planning.metrics import figures_of_merit
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.quantities.information import Information
from acalx.search.agreement import distinct_solutions
from acalx.search.swaps import Candidates
from acalx.sensors import PlatformAccel, PlatformGyro
from acalx.stands import PlatformGimbals, RateTable, Stand, TwoAxis
from acalx.weights import Positions, optimal_weights
from acalx.weights.conic import Conic

# Stands, models of a noise, and a number of positions.
KINDS: dict[str, tuple[Stand, Callable[[float], Model], int]] = {
    "platform": (PlatformGimbals(), lambda noise: Platform(gyro_noise_deg_h=noise, accel_noise_g=noise), 13),
    "vector_accel": (parts.FULL, lambda noise: VectorAccel(noise_g=noise), 6),
    "gyro_rate_table": (RateTable(), lambda noise: GyroRateTable(noise_deg_s=noise), 10),
}
# Powers of two, so that every digit can be asked for, and the noise of real sensors.
EXACT = [2.0**-40, 2.0**20]
NOISES = [1e-12, 1e-7, 1e6]
REAL = Platform(gyro_noise_deg_h=0.001, accel_noise_g=1.02e-7)
# As different as sensors can be.
PAIRS = [(1e-3, 1.02e-7), (1e-12, 1e6), (1e6, 1e-12)]

every_kind = pytest.mark.parametrize("kind", KINDS)
decibels = st.floats(-12.0, 6.0)


def asked(kind: str, noise: float, criterion: Criterion | None = None) -> Problem:
    stand, model, n = KINDS[kind]
    return Problem(stand, model(noise), criterion or D(), n)


@cache
def program_of(kind: str) -> Array:
    problem = asked(kind, 1.0)
    return problem.restrictions.random(np.random.default_rng(3), 1)[0]


@cache
def certificate_of(kind: str, noise: float, criterion: Criterion) -> Certificate:
    return certify(asked(kind, noise, criterion), program_of(kind))


# ---------------------------------------------------------------- designs and bounds


@every_kind
@pytest.mark.parametrize("noise", EXACT)
def test_the_same_seed_gives_the_same_program(kind: str, noise: float) -> None:
    found = [Gradient(starts=2).solve(asked(kind, size), np.random.default_rng(0)) for size in (1.0, noise)]
    p = len(asked(kind, 1.0).parameters)
    shift = found[1].best.loss - found[0].best.loss
    assert shift == pytest.approx(2 * p * math.log(noise), abs=1e-9 * p)
    np.testing.assert_allclose(np.exp(1j * found[1].program), np.exp(1j * found[0].program), atol=1e-4)


@pytest.mark.parametrize(
    ("kind", "noise", "criterion"),
    [
        ("platform", 1e-12, D()),
        ("platform", 1e6, D()),
        *(("vector_accel", noise, criterion) for noise in NOISES for criterion in (D(), A(), E())),
        *(("gyro_rate_table", noise, criterion) for noise in NOISES for criterion in (D(), A())),
    ],
)
def test_efficiencies_do_not_depend_on_the_noise(kind: str, noise: float, criterion: Criterion) -> None:
    plain, scaled = certificate_of(kind, 1.0, criterion), certificate_of(kind, noise, criterion)
    assert plain.bound is not None
    assert scaled.bound is not None
    assert scaled.efficiency == pytest.approx(plain.efficiency, abs=1e-6)
    assert scaled.bound.status == plain.bound.status
    moved = 2 * plain.bound.scale * math.log(noise)
    assert scaled.bound.loss - plain.bound.loss == pytest.approx(moved, abs=1e-6 * plain.bound.scale)


@pytest.mark.parametrize("pair", PAIRS[:2])
def test_sensors_of_any_noise_have_the_same_d(pair: tuple[float, float]) -> None:
    plain = certificate_of("platform", 1.0, D())
    mixed = Platform(gyro_noise_deg_h=pair[0], accel_noise_g=pair[1])
    certificate = certify(Problem(PlatformGimbals(), mixed, D(), 13), program_of("platform"))
    assert certificate.efficiency == pytest.approx(plain.efficiency, abs=1e-6)
    moved = 48 * math.log(pair[0]) + 24 * math.log(pair[1])
    assert certificate.loss - plain.loss == pytest.approx(moved, abs=1e-6)


@pytest.mark.parametrize(
    ("pair", "criterion"),
    [(pair, criterion) for pair in PAIRS for criterion in (A(), E())]
    + [(PAIRS[2], Target({"gyro_bias": 1.0, "accel_bias": 1.0}))],
)
def test_bounds_hold_for_sensors_of_any_noise(pair: tuple[float, float], criterion: Criterion) -> None:
    model = Joined([PlatformGyro(noise_deg_h=pair[0]), PlatformAccel(noise_g=pair[1])])
    problem = Problem(PlatformGimbals(), model, criterion, 10)
    programs = problem.restrictions.random(np.random.default_rng(0), 200)
    certificate = certify(problem, programs[problem.loss(programs).argmin()])
    assert certificate.bound is not None, certificate.reason
    assert certificate.bound.proved
    assert certificate.efficiency is not None
    assert 0.2 < certificate.efficiency <= 1.0
    # with one sensor so much worse only that one counts, and its own bound is nearly that of both
    if pair == (1e6, 1e-12):
        alone = Problem(PlatformGimbals(), PlatformGyro(noise_deg_h=pair[0]), _without_accels(criterion), 10)
        other = certify(alone, program_of("platform")[:10]).bound
        assert other is not None
        assert certificate.bound.loss == pytest.approx(other.loss, abs=1e-4)


def _without_accels(criterion: Criterion) -> Criterion:
    return Target({"gyro_bias": 1.0}) if isinstance(criterion, Target) else criterion


@pytest.mark.parametrize("criterion", [D(), A(), E()], ids=repr)
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("solver", ["CLARABEL", None])
def test_weights_do_not_depend_on_the_noise(criterion: D | A | E, noise: float, solver: str | None) -> None:
    losses = []
    for size in (1.0, noise):
        model = VectorAccel(noise_g=size)
        grid = parts.BAND.axes.candidates(1000, "structured", np.random.default_rng(0))
        master = None if solver is None else Conic(criterion, model.parameters, solver)
        candidates = Positions(parts.BAND, model, grid)
        found = optimal_weights(candidates, criterion, tolerance=1e-6 if solver is None else 1e-4, master=master)
        assert found.gap <= (1e-6 if solver is None else 1e-4)
        losses.append(found.loss)
    degree = criterion.degree(12)
    assert losses[1] - losses[0] == pytest.approx(2 * degree * math.log(noise), abs=2e-4 * degree)


# ---------------------------------------------------------------- what can be estimated


@given(seed=st.integers(0, 2**32 - 1), noise=st.lists(decibels, min_size=6, max_size=6), stack=st.sampled_from([1, 40]))
@settings(max_examples=30, deadline=None)
def test_what_is_seen_does_not_depend_on_the_noise(seed: int, noise: list[float], stack: int) -> None:
    sizes = 10.0 ** np.array(noise)
    stand = PlatformGimbals()
    right = np.radians(np.random.default_rng(seed).integers(0, 4, (stack, 14, 2)) * 90.0)  # few see everything
    right[::2] = stand.axes.random(np.random.default_rng(seed), right[::2].shape[:-1])
    model = Platform(gyro_noise_deg_h=list(sizes[:3]), accel_noise_g=list(sizes[3:]))
    plain, scaled = (each.information(stand.stimulus(right)) for each in (Platform(), model))
    np.testing.assert_array_equal(scaled.singular, plain.singular)
    regular = ~plain.singular
    moved = 2 * (8 * np.log(sizes[:3]).sum() + 4 * np.log(sizes[3:]).sum())
    np.testing.assert_allclose(plain.log_det[regular] - scaled.log_det[regular], moved, atol=1e-6)
    np.testing.assert_allclose(
        scaled.correlations[regular],
        plain.correlations[regular],
        atol=1e-6 * plain.condition_number[regular].max(initial=1),
    )
    for k in range(min(stack, 4)):
        one, other = (Information(each.matrix[k], each.parameters) for each in (plain, scaled))
        assert len(one.inestimable()) == len(other.inestimable())


def test_worst_combinations_are_read_where_eigenvalues_are_far_apart() -> None:
    rows = np.random.default_rng(0).standard_normal((30, 12))
    model = Joined([PlatformGyro(noise_deg_h=1e-9), PlatformAccel(noise_g=1e6)])
    scale = np.array([1e9] * 8 + [1e-6] * 4)
    matrix = np.zeros((12, 12))
    matrix[:8, :8], matrix[8:, 8:] = rows[:, :8].T @ rows[:, :8], rows[:, 8:].T @ rows[:, 8:]
    scaled = Information(matrix * np.outer(scale, scale), model.parameters)
    assert not scaled.singular
    values, vectors = np.linalg.eigh(matrix[8:, 8:] * 1e-12)
    assert float(scaled.smallest_eigenvalue) == pytest.approx(values[0], rel=1e-9)
    assert abs(scaled.weakest[8:] @ vectors[:, 0]) == pytest.approx(1.0, abs=1e-9)
    assert float(E().loss(scaled)) == pytest.approx(-math.log(values[0]), abs=1e-9)
    largest = np.linalg.eigvalsh(matrix[:8, :8] * 1e18)[-1]
    assert float(scaled.condition_number) == pytest.approx(largest / values[0], rel=1e-9)


# ---------------------------------------------------------------- figures


def test_figures_of_the_real_platform() -> None:
    stand = PlatformGimbals()
    stimulus = stand.stimulus(find_program("platform_reference_16").settings_for(stand))
    plain, real = (figures_of_merit(model.information(stimulus)) for model in (Platform(), REAL))
    moved = 48 * math.log(0.001) + 24 * math.log(1.02e-7)
    assert real["log_D"] == pytest.approx(plain["log_D"] + moved, abs=1e-9)
    assert real["D"] == 0.0
    assert real["log_A"] == pytest.approx(math.log(real["A"]))
    assert real["log_E"] == pytest.approx(math.log(real["E"]))
    for group, theta in real["theta"].items():
        noise = 0.001 if group.startswith("gyro") else 1.02e-7
        assert theta == pytest.approx(noise * plain["theta"][group], rel=1e-9)
        if group in real["inequality"]:
            assert real["inequality"][group] == pytest.approx(plain["inequality"][group], abs=1e-9)


@pytest.mark.parametrize("noise", [1e-12, 1e6])
def test_certificates_say_what_no_double_holds(noise: float) -> None:
    certificate = certificate_of("platform", noise, D())
    entries = certificate.entries()
    assert certificate.bound is not None
    assert entries["bound"] is None  # neither 0 nor inf would be true
    assert entries["log_bound"] == certificate.bound.loss
    assert entries["gap"] == pytest.approx(certificate.loss - certificate.bound.loss)
    exponent = math.floor(certificate.bound.loss / math.log(10))
    assert f"e{exponent:+d}" in str(certificate)


@pytest.mark.parametrize("noise", [*EXACT, *NOISES, 1.02e-7])
def test_positions_that_are_felt_alike_do_not_depend_on_the_noise(noise: float) -> None:
    """A table reaches most directions by two pairs of angles: once among candidates, and one program in all."""
    stand = TwoAxis(step_deg=30)
    for kind in (lambda size: VectorAccel(noise_g=size), lambda size: Joined([VectorAccel(noise_g=size)])):
        plain, small = (Problem(stand, kind(size), D(), 9) for size in (1.0, noise))
        stops = np.array(list(itertools.product(*(setting.stops() for setting in stand.settings))))
        assert len(Candidates.of(small.response, stops).settings) == len(Candidates.of(plain.response, stops).settings)
        program = small.restrictions.random(np.random.default_rng(0), 1)[0]
        other = TwoAxis().equivalents(program)[1]
        loss = float(small.loss(program))
        assert len(distinct_solutions(small, [program, other], [loss, loss], 1e-6)) == 1
        moved = program + np.array([math.radians(30.0), 0.0]) * (np.arange(9) == 0)[:, None]
        assert len(distinct_solutions(small, [program, moved], [loss, loss], 1e-6)) == 2
