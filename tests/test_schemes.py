"""Schemes for several kinds of sensors, and the smallest number of positions for a target."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from acalx.bounds import bound
from acalx.criteria import A, D, Inequality, Objectives, Target
from acalx.errors import AcalxError, ArgumentError, CompatibilityError, NoProgramError
from acalx.estimation import Iterated
from acalx.models import Compared, Joined, Platform, ScalarAccel, VectorAccel, as_model, parts_of
from acalx.optimizers import Gradient, Optimizer, Traversal
from acalx.planning.smallest import Smallest, smallest_program
from acalx.problem import Problem
from acalx.programs.sequences import regular_sequences
from acalx.quantities.information import Information
from acalx.schemes import Composed, Joint, Parallel, Scheme, Serial
from acalx.schemes.base import kinds_of
from acalx.search.account import Account
from acalx.search.result import Result, Solution
from acalx.sensors import IMU, MagnetometerTriad, PlatformGyro
from acalx.stands import PlatformGimbals, TwoAxis, TwoAxisRateTable
from acalx.testing import check_optimizer
from command import assert_refused, run, together

GIMBALS, PLATFORM = PlatformGimbals(), Platform()
FAST = Gradient(starts=8)
GYROS, ACCELS = Platform(sensors=["gyros"]), Platform(sensors=["accels"])


def platform(n: int, **options: object) -> Problem:
    return Problem(GIMBALS, PLATFORM, D(), n, **options)


def solve(scheme: Scheme, problem: Problem, optimizer: Optimizer = FAST) -> Composed:
    return scheme.solve(problem, optimizer, np.random.default_rng(0))


def same_verticals(settings: np.ndarray) -> np.ndarray:
    """The other attitudes with the same verticals."""
    return settings * [-1.0, 1.0] + [0.0, math.pi]


# ---------------------------------------------------------------- schemes


def test_a_model_is_taken_apart_by_kinds():
    kinds = kinds_of(Parallel(), platform(16))
    assert {name: model.parameters for name, model in kinds.items()} == {
        "gyros": GYROS.parameters,
        "accels": ACCELS.parameters,
    }
    pair = Joined([Joined([PlatformGyro("y")]), VectorAccel()])
    assert list(kinds_of(Serial(), Problem(GIMBALS, pair, D(), 20))) == ["gyros", "accels"]


@pytest.mark.parametrize("optimizer", [FAST, Traversal()], ids=["gradient", "traversal"])
@pytest.mark.parametrize("scheme", [Joint(), Parallel(), Serial(), Serial(order=["accels", "gyros"])], ids=repr)
def test_every_scheme_designs_for_the_whole_model(scheme, optimizer):
    problem = platform(20)
    designed = solve(scheme, problem, optimizer)
    best = designed.result.best
    assert len(best.settings) <= 20
    assert best.loss == pytest.approx(float(problem.loss(best.settings)), abs=1e-9)
    assert GIMBALS.axes.allows(best.settings).all()
    if designed.parts:
        together = np.concatenate([part.settings for part in designed.parts])
        np.testing.assert_array_equal(together, best.settings)
        assert designed.result.evaluations == sum(part.result.evaluations for part in designed.parts)
    again = solve(scheme, problem, optimizer)
    np.testing.assert_array_equal(again.result.best.settings, best.settings)


def test_joint_is_the_best_and_the_parts_are_as_good_as_alone():
    joint, parallel = (solve(scheme, platform(18)) for scheme in (Joint(), Parallel()))
    serial = solve(Serial(), platform(18))
    assert joint.result.best.loss <= min(parallel.result.best.loss, serial.result.best.loss)
    gyros = FAST.solve(Problem(GIMBALS, GYROS, D(), 12), np.random.default_rng(0)).best
    for designed in (parallel, serial):
        assert designed.parts[0].name == "gyros"
        np.testing.assert_array_equal(designed.parts[0].settings, gyros.settings)
    # what is added in series knows of the positions before
    assert -Problem(GIMBALS, ACCELS, D(), 18).loss(serial.result.best.settings) >= -Problem(
        GIMBALS, ACCELS, D(), 18
    ).loss(parallel.result.best.settings)


class _Fixed(Optimizer):
    """Gives a program of its own to each model."""

    def __init__(self, **programs: np.ndarray) -> None:
        self.programs = programs

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        name = "gyros" if "gyro_x_bias" in {parameter.name for parameter in problem.parameters} else "accels"
        settings = self.programs[name]
        solution = Solution(settings, float(problem.loss(settings)))
        return Result("ok", "fixed", 1, 0.0, [], (solution,))


def test_positions_that_serve_both_are_dropped():
    """An accelerometer does not feel the Earth's rate; each position serves one other."""
    rng = np.random.default_rng(1)
    gyros, own = GIMBALS.axes.random(rng, (10,)), GIMBALS.axes.random(rng, (2,))
    accels = np.concatenate([same_verticals(gyros[[3, 5, 5]]), own])
    designed = solve(Parallel({"gyros": 10}), platform(15), _Fixed(gyros=gyros, accels=accels))
    first, second = designed.parts
    assert (len(first.settings), first.dropped) == (10, 0)
    assert (len(second.settings), second.dropped) == (3, 2)
    np.testing.assert_array_equal(second.settings, accels[2:])
    assert "that others serve" in designed.result.message
    different = solve(
        Parallel({"gyros": 10}), platform(15, replicates=False), _Fixed(gyros=gyros, accels=accels[[0, 1, 3, 4]])
    )
    np.testing.assert_array_equal(different.parts[1].settings, own)


def test_what_a_model_does_not_read_its_sensor_does_not_feel():
    position = np.radians([[30.0, 70.0]])
    accels, gyros = (Problem(GIMBALS, model, D(), 9) for model in (ACCELS, GYROS))
    assert accels.restrictions.alike(position, same_verticals(position)).all()
    assert not gyros.restrictions.alike(position, same_verticals(position)).any()


@pytest.mark.parametrize("scheme", [Parallel(), Serial()], ids=repr)
def test_fixed_positions_come_first_and_serve_all(scheme):
    fixed = GIMBALS.axes.random(np.random.default_rng(2), (5,))
    designed = solve(scheme, platform(16, fixed=fixed))
    np.testing.assert_array_equal(designed.result.best.settings[:5], fixed)
    assert sum(len(part.settings) for part in designed.parts) == 11


def test_positions_of_each_part():
    designed = solve(Parallel({"accels": 6}), platform(20))
    assert [len(part.settings) for part in designed.parts] == [14, 6]
    designed = solve(Serial(positions={"gyros": 13, "accels": 0}), platform(13))
    assert [len(part.settings) for part in designed.parts] == [13, 0]
    assert "the positions before serve them" in designed.result.message
    assert np.isfinite(designed.result.best.loss)


def test_a_sequence_in_series_goes_on():
    problem = platform(20)
    designed = solve(Serial(positions={"gyros": 16}), problem, Traversal(extends=True))
    angles = np.degrees(designed.result.best.settings)
    sequence = regular_sequences("turn", np.array([110.0, 110.0]), np.array([90.0, 45.0]), len(angles))
    np.testing.assert_allclose(angles, sequence % 360.0, atol=1e-9)
    assert 16 < len(angles) <= 20


@pytest.mark.parametrize(
    ("scheme", "n", "message"),
    [
        (Parallel(), 11, r"n=11: the parts have 12 positions together \(gyros 8, accels 4\); give n=12 or more"),
        (Serial(), 8, r"n=8: the parts have 9 positions together \(gyros 8, accels 1\)"),
        (Parallel({"gyros": 9, "accels": 5}), 16, "give n=14, or leave one of them out"),
        (Parallel({"gyro": 9}), 16, "no part 'gyro'; its parts are gyros, accels"),
        (Parallel({"gyros": 7}), 16, r"positions={'gyros': 7}: the gyros need 8 or more"),
        (Serial(order=["gyros"]), 16, r"order=\['gyros'\]: give each kind of the model once: gyros, accels"),
        (Serial(["accels", "gyros"], {"accels": 5, "gyros": 2}), 7, "n=7: the 36 parameters of Platform need 8"),
        (Serial(["accels", "gyros"], {"accels": 9, "gyros": 0}), 9, "gyros=0, but the 9 positions before can't see"),
    ],
)
def test_positions_that_do_not_fit(scheme, n, message):
    with pytest.raises(AcalxError, match=message):
        solve(scheme, platform(n), Traversal("both", n_from=9) if n == 9 else FAST)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Parallel(5), "positions=5: give numbers by kind"),
        (lambda: Parallel({}), "positions={}: give numbers by kind"),
        (lambda: Serial(positions={"gyros": 2.5}), r"positions={'gyros': 2.5}: must be a whole number"),
        (lambda: Serial(order="gyros"), "order='gyros': give a list of kinds"),
    ],
)
def test_bad_options(make, message):
    with pytest.raises(ArgumentError, match=message):
        make()


@pytest.mark.parametrize("scheme", [Parallel(), Serial()], ids=repr)
def test_a_scheme_that_does_not_fit_is_refused_with_the_remedy(scheme):
    for problem in (Problem(TwoAxis(), ScalarAccel(), D(), 12), Problem(GIMBALS, GYROS, D(), 12)):
        with pytest.raises(CompatibilityError, match=r"has one kind only; use scheme=Joint\(\), .*model=Platform\(\)"):
            solve(scheme, problem)
    fair = D() * Inequality("gyro_bias") ** 0.1
    with pytest.raises(CompatibilityError, match=r"accels alone, which the criterion does not fit.*scheme=Joint\(\)"):
        solve(scheme, Problem(GIMBALS, PLATFORM, fair, 16))
    with pytest.raises(CompatibilityError, match="takes one criterion"):
        solve(scheme, Problem(GIMBALS, PLATFORM, Objectives([D(), A()], ["d", "a"]), 16))


# ---------------------------------------------------------------- traversal with fixed positions


def test_sequences_after_fixed_positions():
    fixed = GIMBALS.axes.random(np.random.default_rng(3), (4,))
    problem = Problem(GIMBALS, GYROS, D(), 14, fixed)
    check_optimizer(Traversal().exact(), problem)
    result = Traversal().solve(problem, np.random.default_rng(0))
    np.testing.assert_array_equal(result.best.settings[:4], fixed)
    n = len(result.best.settings)
    per_measurement = Information(problem.information(result.best.settings).matrix / n, problem.parameters)
    assert result.survey.losses.min() == pytest.approx(-float(per_measurement.log_det), abs=1e-8)
    with pytest.raises(AcalxError, match="none of the 144 sequences by rule='turn' begins with the 4 fixed positions"):
        Traversal(extends=True).solve(problem, np.random.default_rng(0))
    many = replace(problem, fixed=GIMBALS.axes.random(np.random.default_rng(3), (10,)))
    with pytest.raises(ArgumentError, match="n_from=9: must be from 11, one more than the 10 fixed positions, to n=14"):
        Traversal(n_from=9).solve(many, np.random.default_rng(0))


def test_exactly_n_and_no_repetitions():
    problem = Problem(GIMBALS, ACCELS, D(), 14)
    assert len(Traversal().exact().solve(problem, np.random.default_rng(0)).best.settings) == 14
    assert FAST.exact() == FAST
    with pytest.raises(ArgumentError, match="n_from=9 with shorter=False"):
        Traversal(n_from=9, shorter=False)
    apart = replace(problem, replicates=False)
    result = Traversal().solve(apart, np.random.default_rng(0))
    assert apart.restrictions.permits(result.best.settings)
    with pytest.raises(NoProgramError):
        Traversal("both").exact().solve(apart, np.random.default_rng(0))


# ---------------------------------------------------------------- the smallest number of positions


def smallest(
    problem: Problem, target: Target, scheme: Scheme | None = None, optimizer: Optimizer = FAST, most: int = 500
) -> Smallest:
    by = scheme or Joint()
    return smallest_program(problem, target, by, lambda at: solve(by, at, optimizer.exact()), most)


def sphere(criterion: object = None, n: int = 9, **limits: object) -> Problem:
    return Problem(TwoAxis(**limits), ScalarAccel(), criterion or D(), n)


@pytest.mark.parametrize(("times", "n"), [(1.0, 12), (0.5, 48), (1.001, 12), (0.999, 13)])
def test_the_smallest_number_on_the_sphere_is_known_and_proved(times, n):
    """On the whole sphere K_bb = 3/n, K_ss = 6/n: an icosahedron has 0.5 for a bias, exactly."""
    target = Target({"bias": 0.5 * times, "scale": math.sqrt(0.5) * times})
    found = smallest(sphere(), target)
    assert (found.n, found.bound) == (n, n)
    assert found.problem.n == n
    assert "no program of fewer can meet it" in str(found)
    assert all(trial.met == (trial.share <= 1 + 1e-6) for trial in found.trials)


def test_every_trial_says_what_it_reached():
    target = Target({"gyro_misalignment": 0.75})
    found = smallest(platform(16), target, optimizer=Traversal())
    tried = {trial.n: trial for trial in found.trials}
    assert tried[found.n].met
    assert not tried[found.n - 1].met
    assert found.bound <= found.n
    problem = platform(found.n)
    again = Traversal().exact().solve(problem, np.random.default_rng(0)).best
    reached = float(problem.information(again.settings).theta("gyro_misalignment"))
    assert tried[found.n].standard_errors == {"gyro_misalignment": pytest.approx(reached)}
    assert tried[found.n].share == pytest.approx(reached / 0.75)
    assert [trial["n"] for trial in found.recorded["tried"]] == sorted(tried)


def test_a_criterion_for_the_target_needs_fewest():
    target = Target({"nonorthogonality": 0.7})
    narrow = sphere(alpha2_deg=(-60, 60))
    by_d, by_target = smallest(narrow, target), smallest(replace(narrow, criterion=target), target)
    assert by_target.bound == by_d.bound
    assert by_d.bound <= by_target.n < by_d.n


@pytest.mark.parametrize("scheme", [Parallel(), Serial()], ids=repr)
def test_schemes_find_it_too(scheme):
    target = Target({"gyro_bias": 0.5, "accel_bias": 0.4})
    found = smallest(platform(16), target, scheme)
    information = platform(found.n).information(found.composed.result.best.settings)
    assert all(float(information.theta(group)) <= wanted + 1e-6 for group, wanted in target.wanted.items())
    assert found.composed.parts


def test_numbers_too_small_for_any_sequence_count_as_tried():
    found = smallest(platform(16), Target({"gyro_bias": 2.0}), Parallel(), Traversal("raster"))
    assert found.trials[0].positions == 0
    assert math.isinf(found.trials[0].share)


def test_fixed_positions_have_no_bound():
    fixed = TwoAxis().axes.random(np.random.default_rng(0), (6,))
    found = smallest(replace(sphere(), n=9, fixed=fixed), Target({"bias": 0.5}))
    assert found.bound is None
    np.testing.assert_array_equal(found.composed.result.best.settings[:6], fixed)


def test_targets_that_can_not_be_met():
    with pytest.raises(ArgumentError, match=r"takes 30,000 positions or more to meet it, more than n_most=500"):
        smallest(sphere(), Target({"bias": 0.01}))
    with pytest.raises(ArgumentError, match=r"not met with n_most=14 .* criterion=Target\("):
        smallest(platform(16), Target({"gyro_misalignment": 0.7}), most=14)
    with pytest.raises(ArgumentError, match=r"no parameter group 'drift'; its groups are bias, scale"):
        smallest(sphere(), Target({"drift": 1.0}))
    with pytest.raises(ArgumentError, match="n_most=8: must be a whole number, 9 or more"):
        smallest(sphere(), Target({"bias": 1.0}), most=8)
    north = Problem(PlatformGimbals(azimuth_deg=0), PLATFORM, D(), 16)
    with pytest.raises(NoProgramError, match="gyro_x_misalignment_S"):
        smallest(north, Target({"gyro_bias": 1.0}))


def test_the_bound_of_a_target_is_exact_where_it_is_known():
    found = bound(sphere(Target({"bias": 0.5})))
    assert math.exp(found.loss) == pytest.approx(12 / 9, rel=1e-6)


@pytest.mark.parametrize(("limits", "n"), [({}, 12), ({"alpha2_deg": (-45, 45)}, 14), ({"step_deg": 30}, 11)])
def test_the_bound_of_a_target_is_below_every_program(limits, n):
    target = Target({"bias": 0.5, "scale": 0.7, "nonorthogonality": 1.1})
    problem = sphere(target, n, **limits)
    programs = problem.restrictions.random(np.random.default_rng(0), 2000)
    assert bound(problem).loss <= problem.loss(programs).min()


@pytest.mark.parametrize("given", [None, {}, 3, {"bias": 0.0}, {"bias": "x"}, {"bias": math.inf}])
def test_bad_targets(given):
    with pytest.raises(ArgumentError, match="target"):
        Target(given)


# ---------------------------------------------------------------- the command


def test_commands(tmp_path):
    base = ("model=platform", "stand=platform_gimbals", "criterion=d", "optimizer=traversal")
    auto = ("n=auto", "target={bias: 0.5}", "criterion=d", "optimizer=gradient", "figures=false")
    parallel, found = together(
        [
            lambda: run(tmp_path, *base, "scheme=parallel", "n=20", into="parallel"),
            lambda: run(tmp_path, *auto, into="auto"),
        ]
    )
    assert parallel.status == 0, parallel.err
    parts = parallel.result["parts"]
    assert [part["part"] for part in parts] == ["gyros", "accels"]
    assert sum(part["positions"] for part in parts) == parallel.result["n"]
    assert {"landscape_gyros.csv", "landscape_accels.csv", "landscape_gyros.png"} <= parallel.files
    assert found.status == 0, found.err
    assert (found.result["n"], found.result["least_n"]) == (12, 12)
    assert found.result["tried"][0]["standard_errors"]["bias"] == pytest.approx(0.5)
    assert "12 positions meet the target" in found.out
    again = run(tmp_path, "--config-dir=auto", "--config-name=resolved", into="again")
    assert again.text() == found.text()


@pytest.mark.parametrize(
    ("arguments", "phrases"),
    [
        (("n=auto",), ("n=auto", "target={bias: 0.5}")),
        (("target={bias: 1}",), ("a target is for n=auto",)),
        (("criterion=target",), ("target=null: give the largest standard error",)),
        (("n=auto", "target={drift: 1}"), ("drift", "bias, scale, nonorthogonality")),
        (("scheme=parallel",), ("ScalarAccel", "scheme=joint", "model=platform")),
    ],
)
def test_bad_command_lines(tmp_path, arguments, phrases):
    assert_refused(run(tmp_path, *arguments, "figures=false"), *phrases)


# ---------------------------------------------------------------- any model of several sensors


TWO = Joined({"accel": VectorAccel(), "field": Compared(MagnetometerTriad("full"))})


@pytest.mark.parametrize(
    ("model", "stand", "kinds", "n"),
    [
        (as_model(IMU()), TwoAxisRateTable(), ("accels", "gyros"), 24),
        (TWO, TwoAxis(dip_deg=60, field_azimuth_deg=90), ("accels", "magnetometers"), 12),
    ],
    ids=["imu", "joined"],
)
@pytest.mark.parametrize("scheme", [Parallel(), Serial()], ids=lambda scheme: type(scheme).__name__)
def test_any_model_of_several_sensors_is_designed_for_in_parts(model, stand, kinds, n, scheme):
    problem = Problem(stand, model, D(), n)
    composed = scheme.solve(problem, Gradient(starts=4), np.random.default_rng(0))
    assert tuple(part.name for part in composed.parts) == kinds
    assert np.isfinite(composed.result.best.loss)
    joint = Gradient(starts=4).solve(problem, np.random.default_rng(0))
    assert len(composed.result.program) <= n
    if len(composed.result.program) == n:
        assert joint.best.loss <= composed.result.best.loss + 1e-9
    names = [parameter.name for part in parts_of(problem.model) for parameter in part.parameters]
    assert names == [parameter.name for parameter in model.parameters]


def test_models_with_the_same_names_join_by_names_of_their_own():
    names = [parameter.name for parameter in TWO.parameters]
    assert names[:2] == ["accel_bias_x", "accel_scale_x"]
    assert {parameter.group for parameter in TWO.parameters} >= {"accel_bias", "field_bias"}
    assert [channel.name for channel in TWO.channels] == [f"accel_a{a}" for a in "xyz"] + [f"field_m{a}" for a in "xyz"]
    with pytest.raises(ArgumentError, match=r"joined models have the same parameters: bias_x, .*give names"):
        Joined([VectorAccel(), Compared(MagnetometerTriad("full"))])
    with pytest.raises(ArgumentError, match=r"common=.*none of the parts has a parameter lean"):
        Joined({"a": VectorAccel(), "b": VectorAccel()}, common=["lean"])


def test_a_parameter_that_parts_share_is_one():
    both = Joined({"a": VectorAccel(), "b": VectorAccel()}, common=["bias_x", "bias_y", "bias_z"])
    assert len(both.parameters) == 21
    rng, table = np.random.default_rng(0), TwoAxis()
    felt = table.stimulus(table.axes.random(rng, (5,)))
    rows = VectorAccel().regressors(felt)
    assert both.regressors(felt).shape == (5, 6, 21)
    information = both.information(felt)
    whole = both.regressors(felt).reshape(30, 21)
    np.testing.assert_allclose(information.matrix, whole.T @ whole, atol=1e-12)
    truth = 0.01 * rng.standard_normal(21)
    readings = both.readings(truth, felt)
    np.testing.assert_allclose(Iterated().estimate(both, readings, felt).parameters, truth, atol=1e-12)
    assert float(information.variances[0]) == pytest.approx(float(np.linalg.inv(whole.T @ whole)[0, 0]))
    assert rows.shape == (5, 3, 12)
    with pytest.raises(CompatibilityError, match="they share bias_x, bias_y, bias_z"):
        Parallel().solve(Problem(table, both, D(), 8), Gradient(starts=2), np.random.default_rng(0))
