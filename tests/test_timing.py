"""Noise that depends on the time in a position, readings on that since the start, noise that positions share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pytest

from acalx.bounds import bound
from acalx.criteria import D
from acalx.errors import ArgumentError, CompatibilityError
from acalx.estimation import Iterated, Readings, calibrate
from acalx.models import Compared, Joined, VectorAccel
from acalx.numerics.arrays import Array
from acalx.optimizers import Convex, DifferentialEvolution, Exchange, Gradient, Traversal
from acalx.planning.design import design
from acalx.planning.evaluation import evaluate
from acalx.problem import Problem
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.quantities.units import SECOND
from acalx.sensors import AccelTriad, Channel, Polynomial, Sensor, Term
from acalx.sensors.triads import axis_terms
from acalx.simulation import ErrorSources, simulate
from acalx.stands import Setting, Stand, TwoAxis
from acalx.testing import check_model

TABLE = TwoAxis()
USUAL = ErrorSources({}, noise=1.0, setting_rad=0.0, gravity=0.0)


@dataclass(frozen=True)
class Averaging(Polynomial):
    """A triad whose noise falls with the square root of the time in a position."""

    senses = ("specific_force",)
    channels = AccelTriad("full", noise_g=1e-3).channels
    terms = AccelTriad("full", noise_g=1e-3).terms

    @property
    def needs(self) -> Mapping[str, str]:
        return {"specific_force": "g", "dwell": "s"}

    def deviations(self, stimulus: Stimulus) -> Array:
        return np.asarray(1e-3 / np.sqrt(stimulus["dwell"]) * np.ones(3))


@dataclass(frozen=True)
class Drifting(Polynomial):
    """One accelerometer whose bias goes on with time, in g per 1000 s."""

    noise = 1e-4
    channels = (Channel("ax", "g", 1e-4),)
    terms = (
        *axis_terms("f", "g", "x", 0),
        Term(Parameter("drift", "drift", "g/1000s", scatter=1e-3), (("time", 0),), 1e-3),
    )


@dataclass(frozen=True)
class Wandering(Polynomial):
    """A triad whose noise positions share, the more the nearer they are in time."""

    senses = ("specific_force",)
    channels = AccelTriad("full", noise_g=1e-3).channels
    terms = AccelTriad("full", noise_g=1e-3).terms

    def correlation(self, times: Array) -> Array:
        return np.exp(-np.abs(times[..., :, None] - times[..., None, :]) / 300.0)


def test_noise_by_the_time_in_a_position() -> None:
    short, long = (Problem(TABLE, Averaging(), D(), 8, dwell_s=dwell) for dwell in (10.0, 1000.0))
    found = Gradient(starts=8).solve(short, np.random.default_rng(0))
    # a hundred times as long is a tenth of the standard deviations, of twelve parameters
    assert float(long.loss(found.program) - short.loss(found.program)) == pytest.approx(-12 * np.log(100.0))
    assert bound(long).loss - bound(short).loss == pytest.approx(-12 * np.log(100.0), abs=1e-6)
    assert found.best.loss >= bound(short).loss - 1e-9
    assert short != long
    check_model(Compared(AccelTriad("full")), TABLE)
    for dwell in (10.0, 1000.0):
        simulated = simulate(found.program, TABLE, Averaging(), USUAL, trials=2000, dwell_s=dwell)
        assert simulated.agrees == {"program": True}
    with pytest.raises(ArgumentError, match=r"dwell_s=0"):
        Problem(TABLE, Averaging(), D(), 8, dwell_s=0)
    with pytest.raises(ArgumentError, match=r"dwell_s=0"):
        design(short, Gradient(starts=2), dwell_s=0)


@pytest.mark.parametrize("sensor", [Drifting(), Wandering()], ids=lambda s: type(s).__name__)
def test_where_the_order_matters_nothing_contradicts_itself(sensor: Sensor) -> None:
    problem = Problem(TABLE, sensor, D(), 10)
    designed = design(problem, Gradient(starts=8))
    assert designed.contradiction(designed.program) == ""
    assert designed.certificate is not None
    assert "order of the positions" in designed.certificate.reason
    evaluation = evaluate(designed.program, TABLE, sensor, D())
    assert evaluation.loss == pytest.approx(designed.result.best.loss, abs=1e-9)  # type: ignore[union-attr]
    turned = float(problem.loss(designed.program[::-1].copy()))
    others = [float(problem.loss(np.random.default_rng(k).permutation(designed.program))) for k in range(8)]
    assert max(np.abs(np.array([turned, *others]) - evaluation.loss)) > 1e-3
    for optimizer in (Exchange(), Convex(), Traversal()):
        with pytest.raises(CompatibilityError, match="depends on their order"):
            optimizer.solve(problem, np.random.default_rng(0))
    with pytest.raises(CompatibilityError, match="depends on their order"):
        DifferentialEvolution().solve(replace(problem, stand=TwoAxis(step_deg=30)), np.random.default_rng(0))
    with pytest.raises(ArgumentError, match="the order of the positions, which must be given"):
        design(problem, Gradient(starts=2), order="random")
    with pytest.raises(CompatibilityError, match="nothing bounds that"):
        bound(problem)


@pytest.mark.parametrize("sensor", [Drifting(), Wandering()], ids=lambda s: type(s).__name__)
def test_gradients_with_times_are_right(sensor: Sensor) -> None:
    problem = Problem(TABLE, sensor, D(), 9)
    x = problem.restrictions.random(np.random.default_rng(1), 3)
    _, gradient = problem.loss_and_gradient(x)
    step = 1e-6
    for place in ((0, 0), (4, 1), (8, 0)):
        shift = np.zeros_like(x)
        shift[:, *place] = step
        numerical = (problem.loss(x + shift) - problem.loss(x - shift)) / (2 * step)
        np.testing.assert_allclose(gradient[:, *place], numerical, rtol=1e-5, atol=1e-7)


def test_shared_noise_is_whitened_as_by_generalized_least_squares() -> None:
    model, rng = Compared(Wandering()), np.random.default_rng(2)
    settings = TABLE.axes.random(rng, (9,))
    known = TABLE.stimulus(settings).timed(model.needs, 60.0)
    rows = Compared(AccelTriad("full", noise_g=1e-3)).regressors(known)
    times = 60.0 * (np.arange(9) + 0.5)
    inverse = np.linalg.inv(Wandering().correlation(times))
    expected = np.einsum("imp,ij,jmq->pq", rows, inverse, rows)
    np.testing.assert_allclose(model.information(known).matrix, expected, rtol=1e-9)
    assert simulate(settings, TABLE, Wandering(), USUAL, trials=3000).agrees == {"program": True}
    truth = 0.01 * rng.standard_normal(12)
    found = Iterated().estimate(model, model.readings(truth, known), known)
    np.testing.assert_allclose(found.parameters, truth, atol=1e-12)


def test_a_drift_is_estimated_from_readings_with_their_times() -> None:
    model, rng = Compared(Drifting()), np.random.default_rng(3)
    known = TABLE.stimulus(TABLE.axes.random(rng, (12,))).timed(model.needs, 60.0)
    truth = np.array([0.01, -0.02, 0.003, 0.001, 0.002])
    means = model.readings(truth, known) + 1e-4 * rng.standard_normal((12, 1))
    calibration = calibrate(Readings("drifting", means, stimulus=known), model)
    off = np.abs(calibration.estimate.parameters - truth) / calibration.estimate.standard_errors
    assert off.max() < 4.0


# ---------------------------------------------------------------- what is known before


PRIOR = {"bias": 0.5, "misalignment_xy": 0.2}


def test_a_prior_is_information_that_is_there_already() -> None:
    plain, informed = VectorAccel(), VectorAccel(noise_g=1.0, prior=PRIOR)
    felt = TABLE.stimulus(TABLE.axes.random(np.random.default_rng(0), (6,)))
    difference = informed.information(felt).matrix - plain.information(felt).matrix
    expected = np.array([{"bias": 4.0}.get(p.group, 25.0 * (p.name == "misalignment_xy")) for p in plain.parameters])
    np.testing.assert_allclose(difference, np.diag(expected), atol=1e-12)
    joined = Joined({"a": informed, "b": VectorAccel()})
    np.testing.assert_allclose(joined.prior_information[:12], expected)
    assert not joined.prior_information[12:].any()


def test_with_a_prior_fewer_positions_than_parameters_do() -> None:
    model = Compared(AccelTriad(noise_g=1e-3), prior={"bias": 0.02, "scale": 0.01, "nonorthogonality": 0.01})
    assert model.smallest_n == 1
    problem = Problem(TABLE, model, D(), 3)
    designed = design(problem, Gradient(starts=16))
    certificate = designed.certificate
    assert certificate is not None
    assert certificate.bound is not None
    assert certificate.bound.proved
    assert certificate.gap >= -1e-9
    for n in (2, 3, 5):
        grown = Gradient(starts=8).solve(replace(problem, n=n), np.random.default_rng(0))
        assert grown.best.loss >= bound(replace(problem, n=n)).loss - 1e-9
    simulated = simulate(designed.program, TABLE, model, USUAL, trials=3000)
    deviations = simulated.outcomes["program"].deviations / simulated.outcomes["program"].predicted
    np.testing.assert_allclose(deviations, 1.0, atol=0.06)


def test_the_estimate_weighs_readings_and_prior() -> None:
    sensor, rng = AccelTriad("full", noise_g=1e-2), np.random.default_rng(4)
    model = Compared(sensor, prior={"bias": 0.01, "scale": 0.01, "misalignment": 0.01})
    known = TABLE.stimulus(TABLE.axes.random(rng, (5,)))
    means = model.readings(0.01 * rng.standard_normal(12), known) + 0.01 * rng.standard_normal((5, 3))
    found = Iterated().estimate(model, means, known, noise=np.ones(15))
    rows = model.regressors(known).reshape(15, 12)
    residual = (means - sensor.readings(np.zeros(12), known)).reshape(15) / 1e-2
    expected = np.linalg.solve(rows.T @ rows + 1e4 * np.eye(12), rows.T @ residual)
    np.testing.assert_allclose(found.parameters, expected, rtol=1e-9)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(rows.T @ rows + 1e4 * np.eye(12)), rtol=1e-9)
    assert 3.0 < Iterated().estimate(model, means, known).freedom < 15.0


@pytest.mark.parametrize(
    ("prior", "message"),
    [
        ({"bias": -1.0}, "prior={'bias': -1.0}: a standard deviation is a positive number"),
        ({"bias": 0}, "a standard deviation is a positive number"),
        ({"drift": 1.0}, "give parameters or groups, bias, scale, misalignment"),
        ({"bias": float("nan")}, "a standard deviation is a positive number"),
        (0.1, "give standard deviations by parameter or group"),
    ],
)
def test_priors_that_are_none_are_refused(prior: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        VectorAccel(noise_g=1.0, prior=prior)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Timer(TwoAxis):
    """A table whose time in a position is a setting, given in minutes."""

    @property
    def settings(self) -> tuple[Setting, ...]:  # type: ignore[override]
        return (*super().settings, Setting.in_unit("dwell", (20.0, 600.0), None, False, SECOND))

    def stimulus(self, settings: Array) -> Stimulus:
        felt = super().stimulus(settings[..., :2])
        return Stimulus({**felt, "dwell": settings[..., 2:] / 60.0}, units={"dwell": "min"})

    def derivative(self, settings: Array) -> Stimulus:
        return Stand.derivative(self, settings)

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        return Stand.pull(self, settings, gradient)

    frequencies = None  # type: ignore[assignment]


def test_times_that_a_stand_sets_count_in_its_unit_and_in_the_gradient() -> None:
    stand, rng = Timer(), np.random.default_rng(4)
    problem = Problem(stand, Compared(Drifting()), D(), 8)
    program = stand.axes.random(rng, (8,))
    felt = problem.response.stimulus(program)
    np.testing.assert_allclose(felt["time"][..., 0], np.cumsum(program[:, 2]) - 0.5 * program[:, 2])
    _, gradient = problem.loss_and_gradient(program)
    step = 1e-4 * rng.standard_normal(program.shape) * np.array([1.0, 1.0, 100.0])
    above, below = problem.losses(np.stack([program + step, program - step]))[..., 0]
    assert (above - below) / 2 == pytest.approx((gradient * step).sum(), rel=1e-4)


def test_a_time_that_the_stand_sets_goes_with_no_noise_that_positions_share() -> None:
    with pytest.raises(CompatibilityError, match="dwell_s"):
        Problem(Timer(), Compared(Wandering()), D(), 8)
