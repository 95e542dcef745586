"""Forbidden zones, steps of each angle, positions that must stay, and replicates: obeyed by all, and by the bound."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acalx.bounds import bound as lower_bound
from acalx.bounds import certify
from acalx.bounds.relaxation import relax, sensitivity
from acalx.criteria import A, Criterion, D, E
from acalx.errors import AcalxError, ArgumentError, CompatibilityError, PluginError
from acalx.models import GyroRateTable, ScalarAccel
from acalx.numerics.cosine import Cosines
from acalx.numerics.supremum import Cells
from acalx.optimizers import DifferentialEvolution, Exchange, Gradient
from acalx.problem import Problem
from acalx.programs import published
from acalx.search.account import Account
from acalx.search.descent import descend
from acalx.stands import RateTable, TwoAxis
from acalx.stands.zones import Box
from command import evaluate, run
from zones import cap

HALF = {"alpha1_deg": (-90, 90)}
BOX = {"alpha1_deg": (-40, 60), "alpha2_deg": (-30, 120)}
STANDS = {
    "box": TwoAxis(**HALF, forbidden=[BOX]),
    "two boxes, one without limits of the second angle": TwoAxis(
        **HALF, forbidden=[BOX, {"alpha1_deg": (-90, -70)}, {"alpha2_deg": (200, 230)}]
    ),
    "function": TwoAxis(**HALF, forbidden_if=cap),
    "steps and a box": TwoAxis(step_deg=15, forbidden=[BOX]),
    "steps of one angle": TwoAxis(step_deg=(30, None)),
    "steps of one angle and a box": TwoAxis(step_deg=(None, 30), forbidden=[BOX]),
    "steps and a function": TwoAxis(step_deg=20, forbidden_if="zones.cap"),
}
FIXED = published()["egorov_2021_table_1"]


def problem(stand: TwoAxis, criterion: Criterion | None = None, n: int = 10, **kwargs: object) -> Problem:
    return Problem(stand, ScalarAccel(), criterion or D(), n, **kwargs)


def quick(stand: TwoAxis) -> list[object]:
    rough = DifferentialEvolution(restarts=1, maxiter=60)
    return [rough, Exchange(chains=1, patience=1, starts=8)] + ([] if stand.axes.stepped else [Gradient(starts=24)])


@pytest.mark.parametrize("name", STANDS)
@pytest.mark.parametrize("replicates", [True, False])
def test_every_optimizer_obeys_and_no_program_beats_the_bound(name, replicates):
    bound = problem(STANDS[name], replicates=replicates)
    least = lower_bound(bound).loss
    for optimizer in quick(bound.stand):
        result = optimizer.solve(bound, np.random.default_rng(0))
        for solution in result.solutions:
            assert bound.stand.axes.allows(solution.settings, tolerance=1e-7).all(), type(optimizer).__name__
            assert bound.restrictions.permits(solution.settings)
            assert bound.loss(solution.settings) == pytest.approx(solution.loss, abs=1e-9)
            assert solution.loss >= least - 1e-9
        assert result.best.loss <= least + 0.6


@pytest.mark.parametrize("name", ["box", "function"])
def test_gradient_ends_close_to_the_bound_at_the_edge_of_a_zone(name):
    for criterion, efficiency in ((D(), 0.975), (A(), 0.96)):
        bound = problem(STANDS[name], criterion, 12)
        certificate = certify(bound, Gradient().solve(bound, np.random.default_rng(1)).best.settings)
        assert efficiency <= certificate.efficiency <= 1.0


def test_a_zone_that_can_be_gone_around_costs_nothing():
    free = problem(TwoAxis(), n=12)
    zoned = problem(TwoAxis(forbidden=[{"alpha1_deg": (91, 269)}]), n=12)  # each direction has another pair
    first, second = (Gradient().solve(p, np.random.default_rng(0)).best for p in (free, zoned))
    assert second.loss == pytest.approx(first.loss, abs=1e-6)
    assert certify(zoned, second.settings).optimal


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_a_box_holds_what_is_inside_and_limits_around_a_point_leave_it_out(seed):
    rng = np.random.default_rng(seed)
    lower = rng.uniform(-400, 400, (3, 2))
    upper = lower + rng.uniform(5, 170, (3, 2))
    zones = [Box(tuple(np.radians(a)), tuple(np.radians(b)), (True, True)) for a, b in zip(lower, upper, strict=True)]
    points = rng.uniform(-np.pi, np.pi, (200, 2))
    inside = np.zeros(len(points), dtype=bool)
    for a, b in zip(lower, upper, strict=True):
        past = np.mod(np.degrees(points) - a, 360)
        inside |= ((past > 0) & (past < b - a)).all(axis=1)
    held = np.logical_or.reduce([zone.holds(points) for zone in zones])
    np.testing.assert_array_equal(held, inside)
    free = points[~held]
    low, high = free - np.pi, free + np.pi
    for zone in zones:
        zone.narrow(free, low, high)
    assert (low <= free).all()
    assert (free <= high).all()
    for _ in range(20):
        within = rng.uniform(low, high)
        assert not any(zone.holds(within).any() for zone in zones)


def test_cells_are_covered_only_where_all_of_them_is_forbidden():
    rng = np.random.default_rng(0)
    for stand in (STANDS["box"], STANDS["function"]):
        (zone,) = stand.zones
        centers, half = rng.uniform(-np.pi, np.pi, (500, 2)), rng.uniform(0, 0.6, (500, 2))
        covered = zone.covers(centers, half)
        assert covered.any()
        assert not covered.all()
        for _ in range(20):
            points = centers + rng.uniform(-1, 1, centers.shape) * half
            assert zone.holds(points)[covered].all()


def test_fixed_positions_stay_first_and_the_bound_knows_them():
    stand = TwoAxis()
    fixed = FIXED.settings_for(stand)
    bound = problem(stand, n=18, fixed=fixed)
    for optimizer in (Gradient(starts=16), Exchange(chains=1, starts=4, patience=1), DifferentialEvolution(maxiter=30)):
        result = optimizer.solve(bound, np.random.default_rng(0))
        np.testing.assert_array_equal(result.best.settings[:9], fixed)
        certificate = certify(bound, result.best.settings)
        assert certificate.efficiency <= 1.0
    # the tangent at the optimum: what is fixed and the best of the rest add up to the whole
    assert certificate.bound.loss > lower_bound(problem(stand, n=18)).loss


def test_the_best_nine_positions_extend_to_eighteen_within_3_percent_of_the_bound():
    stand = TwoAxis()
    nine = Gradient().solve(problem(stand, n=9), np.random.default_rng(0)).best.settings
    result = Gradient().solve(problem(stand, n=18, fixed=nine), np.random.default_rng(0))
    least = lower_bound(problem(stand, n=18)).loss
    assert np.exp(result.best.loss) <= 1.03 * np.exp(least)


@pytest.mark.parametrize("criterion", [D(), A(), E(), A() * D() ** 0.5], ids=repr)
def test_nothing_between_beats_the_bound_around_fixed_positions(criterion):
    rng = np.random.default_rng(3)
    stand = TwoAxis(alpha2_deg=(-50, 40))
    bound = problem(stand, criterion, 12, fixed=TwoAxis().axes.random(rng, (5,)))
    least = lower_bound(bound).loss
    losses = bound.loss(bound.restrictions.random(rng, 2000))
    best = Gradient(starts=24).solve(bound, rng).best.loss
    assert least <= best + 1e-9
    assert best <= losses.min()
    assert best <= least + 0.1


def test_replicates_are_a_degree_apart_or_a_stop():
    crowded = TwoAxis(alpha1_deg=(-20, 20), alpha2_deg=(-20, 20))
    result = Gradient(starts=16).solve(problem(crowded, n=20, replicates=False), np.random.default_rng(0))
    directions = crowded.stimulus(result.best.settings)["specific_force"]
    cosines = (directions @ directions.T)[np.triu_indices(20, 1)]
    assert np.degrees(np.arccos(cosines.max())) >= 1 - 1e-6
    table = TwoAxis(alpha1_deg=(-40, 40), alpha2_deg=(-40, 40), step_deg=20)
    used_twice = Exchange().solve(problem(table, n=20), np.random.default_rng(0)).best
    each_once = Exchange().solve(problem(table, n=20, replicates=False), np.random.default_rng(0)).best
    assert len(np.unique(np.round(np.degrees(each_once.settings)), axis=0)) == 20
    assert each_once.loss > used_twice.loss


def test_gradient_of_the_sensitivity_is_that_of_its_values():
    bound = problem(STANDS["box"])
    support = np.cov(np.random.default_rng(0).normal(size=(9, 30)))
    points = bound.stand.axes.random(np.random.default_rng(1), (5,))
    _, gradient = sensitivity(bound, support, points)
    for k in range(2):
        step = 1e-6 * np.eye(2)[k]
        numerical = (
            sensitivity(bound, support, points + step)[0] - sensitivity(bound, support, points - step)[0]
        ) / 2e-6
        np.testing.assert_allclose(gradient[:, k], numerical, rtol=1e-6, atol=1e-7)


def test_a_table_with_steps_is_left_to_exchange_unless_an_optimizer_is_asked_for(tmp_path):
    rest = ("stand.step_deg=45", "criterion=d", "n=9", "figures=false", "certificate=false")
    chosen = run(tmp_path, *rest, into="default")
    assert "chains of exchanges" in chosen.result["message"]
    again = run(tmp_path, f"--config-dir={chosen.directory}", "--config-name=resolved", into="again")
    assert again.text() == chosen.text()
    asked = run(tmp_path, *rest, "optimizer=de", "optimizer.restarts=1", "optimizer.maxiter=5", into="asked")
    assert "restarts" in asked.result["message"]
    recorded = run(tmp_path, f"--config-dir={asked.directory}", "--config-name=resolved", into="recorded")
    assert recorded.text() == asked.text()


@pytest.mark.parametrize(
    ("forbidden", "words"),
    [
        ([{"alpha3_deg": (0, 1)}], "has no alpha3_deg; it has alpha1_deg, alpha2_deg"),
        ([{"alpha1_deg": (10, 5)}], "lower end of alpha1_deg must be below"),
        ([{"alpha1_deg": 10}], "lower and an upper end of alpha1_deg"),
        ([{}], "not a box"),
        ("alpha1", "give a list of boxes"),
    ],
)
def test_boxes_that_are_not_understood(forbidden, words):
    with pytest.raises(ArgumentError, match=words):
        TwoAxis(forbidden=forbidden)


def test_functions_that_are_not_understood():
    with pytest.raises(ArgumentError, match=r"forbidden_if='nowhere\.f': can't be imported"):
        TwoAxis(forbidden_if="nowhere.f")
    with pytest.raises(ArgumentError, match="must take alpha1_deg, alpha2_deg"):
        TwoAxis(forbidden_if=lambda x: x)
    with pytest.raises(PluginError, match="as many booleans"):
        TwoAxis(forbidden_if=lambda alpha1_deg, alpha2_deg: alpha1_deg).axes.random(np.random.default_rng(0), (3,))
    with pytest.raises(PluginError, match="raised ZeroDivisionError"):
        TwoAxis(forbidden_if=lambda alpha1_deg, alpha2_deg: 1 / 0).axes.random(np.random.default_rng(0), (3,))


def test_limits_that_leave_nothing_are_said():
    nothing = TwoAxis(alpha1_deg=(0, 50), forbidden=[{"alpha1_deg": (-10, 60)}])
    with pytest.raises(CompatibilityError, match="forbidden zones of stand TwoAxis leave next to nothing"):
        Gradient().solve(problem(nothing), np.random.default_rng(0))
    line = TwoAxis(alpha1_deg=(0, 50), forbidden=[{"alpha1_deg": (10, 60)}, {"alpha2_deg": (1, 359)}])
    few = TwoAxis(alpha1_deg=(0, 40), alpha2_deg=(0, 40), step_deg=40)
    with pytest.raises(CompatibilityError, match="no 10 different positions"):
        Exchange().solve(problem(few, replicates=False), np.random.default_rng(0))
    assert line.axes.allows(line.axes.random(np.random.default_rng(0), (20,))).all()


def test_fixed_positions_that_leave_nothing_to_choose():
    with pytest.raises(ArgumentError, match=r"n=9 with 9 fixed positions leaves nothing to choose.* n=10 or more"):
        problem(TwoAxis(), n=9, fixed=FIXED.settings_for(TwoAxis()))


def test_a_stand_that_shows_too_little_says_which_combination():
    flat = TwoAxis(alpha1_deg=(0, 40), forbidden=[{"alpha1_deg": (5, 35)}], step_deg=20)
    with pytest.raises(AcalxError, match="can estimate all the parameters"):
        Exchange(starts=4).solve(problem(flat), np.random.default_rng(0))


def test_a_program_at_the_edge_of_a_function_is_still_allowed_when_read_again(tmp_path):
    (tmp_path / "table.py").write_text("def no(alpha1_deg, alpha2_deg):\n    return abs(alpha1_deg - 90) < 60\n")
    limits = ("stand.forbidden_if=table.no", "criterion=d", "figures=false")
    made = run(tmp_path, *limits, "n=12", "optimizer=gradient", "optimizer.starts=16", into="made")
    read = evaluate(tmp_path, *limits, f"program={made.directory}/program.csv", into="read")
    assert read.result["outside"] == []
    assert read.result["loss"] == pytest.approx(made.result["loss"], abs=1e-9)


def test_an_edge_that_has_nothing_beside_it_is_forbidden_too():
    at_limit = TwoAxis(alpha1_deg=(0, 90), forbidden=[{"alpha1_deg": (0, 60)}])
    shared = TwoAxis(forbidden=[{"alpha1_deg": (10, 90)}, {"alpha1_deg": (90, 170)}])
    corner = TwoAxis(forbidden=[{"alpha1_deg": (10, 90), "alpha2_deg": (0, 90)}, {"alpha1_deg": (90, 170)}])
    assert at_limit.axes.forbids(np.radians([0.0, 45.0]))
    assert not at_limit.axes.forbids(np.radians([60.0, 45.0]))
    assert shared.axes.forbids(np.radians([90.0, 45.0]))
    assert corner.axes.forbids(np.radians([90.0, 45.0]))
    assert not corner.axes.forbids(np.radians([90.0, 145.0]))


def test_rounding_to_fine_steps_goes_around_zones():
    stand = TwoAxis(step_deg=1, forbidden=[{"alpha1_deg": (20.6, 159.4)}, {"alpha1_deg": (200.6, 339.4)}])
    bound = problem(stand, n=9)
    result = Exchange(chains=1, patience=1, starts=8).solve(bound, np.random.default_rng(0))
    assert stand.axes.allows(result.best.settings).all()
    assert result.best.loss <= lower_bound(bound).loss + 0.6


def test_no_stop_at_all_is_said():
    stand = TwoAxis(step_deg=15, alpha1_deg=(-77, -52), forbidden=[{"alpha1_deg": (283, 344)}])
    with pytest.raises(CompatibilityError, match="allowed no stop at all"):
        Exchange().solve(problem(stand), np.random.default_rng(0))


def test_a_bound_is_found_where_a_function_leaves_next_to_nothing(tmp_path):
    def tight(alpha1_deg, alpha2_deg):
        return (abs(alpha1_deg - 42) > 3) | (abs(alpha2_deg - 180) > 80)

    bound = problem(TwoAxis(forbidden_if=tight))
    best = Gradient(starts=8).solve(bound, np.random.default_rng(0)).best.settings
    assert certify(bound, best).gap >= -1e-9


# ---------------------------------------------------------------- settings that are no angles

RATES = {
    "free": RateTable(),
    "limited rates": RateTable(rate_deg_s=(-20, 90), alpha1_deg=(-30, 40)),
    "steps of the rate": RateTable(rate_step_deg_s=20),
    "boxes in the rate": RateTable(
        forbidden=[{"rate_deg_s": (30, 60)}, {"rate_deg_s": (-10, 20), "alpha1_deg": (10, 200)}]
    ),
    "steps and a box": RateTable(rate_step_deg_s=10, forbidden=[{"rate_deg_s": (-100, -25), "alpha2_deg": (0, 180)}]),
}


@pytest.mark.parametrize("name", RATES)
def test_no_program_beats_the_proved_bound_of_a_rate_table(name):
    bound = Problem(RATES[name], GyroRateTable(), D(), 9)
    least = lower_bound(bound)
    assert least.status == "proved"
    rng = np.random.default_rng(0)
    if bound.stand.axes.stepped:  # the angles alone descend
        best = descend(bound, bound.restrictions.random(rng, 64), account=Account())
        loss, settings = best.loss.min(), best.settings[best.loss.argmin()]
    else:
        best = Gradient(starts=16).solve(bound, rng).best
        loss, settings = best.loss, best.settings
    assert bound.stand.axes.allows(settings, tolerance=1e-7).all()
    assert least.loss <= loss + 1e-9
    assert loss <= least.loss + 12.0  # nine positions for 21 parameters


def test_what_plays_no_part_changes_no_bound():
    for limits in ({}, {"alpha2_deg": (-45, 45)}):
        at_rest, turning = (
            lower_bound(Problem(kind(**limits), ScalarAccel(), D(), 9)) for kind in (TwoAxis, RateTable)
        )
        assert at_rest.status == turning.status == "proved"
        assert turning.loss == pytest.approx(at_rest.loss, abs=1e-6)


def test_the_sensitivity_of_a_rate_table_is_below_its_proved_peak_everywhere():
    bound = Problem(RATES["boxes in the rate"], GyroRateTable(), A(), 12)
    relaxation = relax(bound)
    places = bound.stand.axes.random(np.random.default_rng(0), (20_000,))
    assert sensitivity(bound, relaxation.support, places)[0].max() <= relaxation.peak + 1e-7


def test_a_box_of_a_setting_without_turns_covers_nothing_beside_it():
    (zone,) = TwoAxis(periodic=False, forbidden=[{"alpha1_deg": (100, 200)}]).zones
    centers = np.radians([[50.0, 0.0], [150.0, 0.0], [250.0, 0.0], [105.0, 0.0]])
    np.testing.assert_array_equal(zone.covers(centers, np.full((4, 2), np.radians(10.0))), [False, True, False, False])


@pytest.mark.parametrize("seed", range(5))
def test_boxes_of_angles_hold_what_they_are_of_a_variable(seed):
    rng = np.random.default_rng(seed)
    cosines = Cosines(np.array([[-3.0, 3.0], [-0.4, 1.6]]), (False, True))
    values = np.sort(rng.uniform(-0.4, 1.6, 6))
    np.testing.assert_allclose(np.sort(cosines.points(np.stack([values, cosines.angles(1, values)], -1))[:, 1]), values)
    half = rng.uniform(0.01, 0.2, (50, 2))
    cells = Cells(np.stack([rng.uniform(-3, 3, 50), rng.uniform(0.2, np.pi - 0.2, 50)], axis=-1), half)
    taken = cosines.cells(cells)
    for _ in range(20):
        points = cosines.points(cells.centers + rng.uniform(-1, 1, half.shape) * half)
        assert (np.abs(points - taken.centers) <= taken.half + 1e-12).all()
