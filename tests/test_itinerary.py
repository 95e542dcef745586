"""The order of visit: what is shortest, what stays, and what runs record of it."""

from __future__ import annotations

import itertools
import time
from functools import partial

import numpy as np
import pytest

import parts
from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.numerics.routes import exact_route, searched_route
from acalx.planning.itinerary import ORDERS, Itinerary, itinerary, shorter
from acalx.programs import find_program
from acalx.stands import Chamber, RateTable, Stand, TwoAxis
from command import Outcome, assert_refused, run, together

STANDS: list[Stand] = [
    parts.FULL,
    parts.BAND,
    parts.UNWRAPPED,
    parts.TABLE_15,
    TwoAxis(dip_deg=65),
    TwoAxis(speed_deg_s=[10, 3], forbidden=[{"alpha1_deg": (80, 100), "alpha2_deg": (170, 190)}]),
    parts.GIMBALS,
    parts.RATE_TABLE,
]


def stimuli(stand: Stand, settings: Array) -> Array:
    """What is felt in each position, rows in an order that does not depend on that of the visit."""
    rows = np.concatenate(list(stand.stimulus(settings).values()), axis=-1)
    return rows[np.lexsort(np.round(rows, 9).T)]


def lengths(costs: Array, first: Array, route: np.ndarray) -> float:
    return float(first[route[0]] + costs[route[:-1], route[1:]].sum())


def puzzle(n: int, seed: int, ways: int = 2) -> tuple[Array, Array]:
    points = np.random.default_rng(seed).random((ways * n, 2))
    return np.abs(points[:, None] - points).max(axis=-1), np.abs(points - 0.5).max(axis=-1)


@pytest.mark.parametrize("seed", range(3))
def test_the_exact_route_is_the_shortest_of_all(seed: int) -> None:
    costs, first = puzzle(5, seed)
    every = (
        lengths(costs, first, np.array(order) + 5 * np.array(ways))
        for order in itertools.permutations(range(5))
        for ways in itertools.product(range(2), repeat=5)
    )
    route = exact_route(costs, first, 5)
    assert sorted(route % 5) == list(range(5))
    assert lengths(costs, first, route) == pytest.approx(min(every), abs=1e-12)


@pytest.mark.parametrize(("n", "ways"), [(5, 1), (8, 2), (11, 2)])
def test_the_search_finds_the_shortest_where_that_is_known(n: int, ways: int) -> None:
    for seed in range(2):
        costs, first = puzzle(n, seed, ways)
        route = searched_route(costs, first, n, np.random.default_rng(0))
        assert sorted(route % n) == list(range(n))
        assert lengths(costs, first, route) == pytest.approx(
            lengths(costs, first, exact_route(costs, first, n)), abs=1e-9
        )


@pytest.mark.parametrize("stand", STANDS, ids=repr)
@pytest.mark.parametrize("order", ORDERS)
def test_an_order_keeps_what_is_felt(stand: Stand, order: str) -> None:
    settings = stand.axes.random(np.random.default_rng(0), (13,))
    visit = itinerary(stand, settings, order, np.random.default_rng(0), held=2)
    np.testing.assert_array_equal(visit.settings[:2], settings[:2])
    np.testing.assert_allclose(stimuli(stand, visit.settings), stimuli(stand, settings), atol=1e-9)
    assert stand.axes.allows(visit.settings).all()
    if order == "shortest":
        assert visit.seconds <= itinerary(stand, settings, "given", np.random.default_rng(0)).seconds


@pytest.mark.parametrize("stand", STANDS, ids=repr)
def test_equivalent_settings_are_allowed_and_the_same(stand: Stand) -> None:
    settings = stand.axes.random(np.random.default_rng(1), (50,))
    ways = stand.equivalents(settings)
    np.testing.assert_array_equal(ways[0], settings)
    assert stand.axes.allows(ways).all()
    for name, felt in stand.stimulus(ways).items():
        expected = stand.stimulus(settings)[name]
        np.testing.assert_allclose(felt, np.broadcast_to(expected, felt.shape), atol=1e-12)


def test_the_other_pair_of_angles_is_a_real_saving() -> None:
    settings = find_program("egorov_2021_table_2").settings_for(parts.FULL)
    shortest = itinerary(parts.FULL, settings, "shortest", np.random.default_rng(0)).seconds
    fixed_ways = TwoAxis(dip_deg=0)  # where the field counts, too
    assert shortest < 0.9 * itinerary(fixed_ways, settings, "shortest", np.random.default_rng(0)).seconds


def test_moves_take_the_shorter_way_only_where_there_is_one() -> None:
    settings = np.radians([[350.0, 0.0], [20.0, 0.0]])
    assert np.degrees(Itinerary(parts.FULL, settings).travel) == pytest.approx(30)
    assert np.degrees(Itinerary(parts.UNWRAPPED, settings).travel) == pytest.approx(330)
    turned = np.radians([[0.0, 0.0], [20.0, 40.0]])
    table = Itinerary(TwoAxis(speed_deg_s=[10, 5]), turned)
    assert table.seconds == pytest.approx(8)  # both at the same time
    entries = table.entries(60)
    assert entries == pytest.approx({"travel_deg": 60, "travel_s": 8, "total_s": 128})


def test_a_rate_is_no_travel() -> None:
    settings = np.radians([[0.0, 0.0, -50.0], [10.0, 0.0, 50.0]])
    table = Itinerary(RateTable(), settings)
    assert np.degrees(table.travel) == pytest.approx(10)
    assert table.seconds == pytest.approx(1)


@pytest.mark.parametrize("speed", [0, -1, "fast", [10], [10, 5, 1], True])
def test_bad_speeds_are_refused(speed: object) -> None:
    with pytest.raises(ArgumentError, match="speed_deg_s="):
        TwoAxis(speed_deg_s=speed)  # type: ignore[arg-type]


def test_too_many_positions_are_refused() -> None:
    settings = parts.FULL.axes.random(np.random.default_rng(0), (501,))
    with pytest.raises(ArgumentError, match="501 positions are too many"):
        itinerary(parts.FULL, settings, "shortest", np.random.default_rng(0))


# ---------------------------------------------------------------- the commands

QUICK = ("criterion=d", "optimizer=gradient", "n=12", "figures=false", "certificate=false")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Outcome]:
    folder = tmp_path_factory.mktemp("orders")
    calls = {
        "given": partial(run, folder, *QUICK, into="given"),
        "shortest": partial(run, folder, *QUICK, "order=shortest", "dwell_s=30", into="shortest"),
        "random": partial(run, folder, *QUICK, "order=random", into="random"),
        "fixed": partial(run, folder, *QUICK, "fixed=axes_and_edges_9", "order=shortest", into="fixed"),
        "simulated": partial(
            run,
            folder,
            *("program=[icosahedron_12,rotations_18]", "order=shortest", "trials=100", "figures=false"),
            into="simulated",
            entry="simulate",
        ),
        "wrong": partial(run, folder, *QUICK, "order=longest", into="wrong"),
        "never": partial(run, folder, *QUICK, "dwell_s=-1", into="never"),
        "slow": partial(run, folder, *QUICK, "stand.speed_deg_s=0", into="slow"),
        "simulated wrong": partial(
            run, folder, "program=icosahedron_12", "order=longest", into="simulated_wrong", entry="simulate"
        ),
    }
    return dict(zip(calls, together(calls.values()), strict=True))


def test_a_run_is_written_in_the_order_of_visit(runs: dict[str, Outcome]) -> None:
    given, shortest, shuffled = (runs[name] for name in ("given", "shortest", "random"))
    for outcome in (given, shortest, shuffled):
        assert outcome.status == 0, outcome.err
        assert [row["position"] for row in outcome.rows()] == [str(k + 1) for k in range(12)]
        assert "in the order of visit" in outcome.out
        assert outcome.result["loss"] == pytest.approx(given.result["loss"], abs=1e-9)
    assert shortest.result["travel_s"] < 0.8 * given.result["travel_s"]
    assert shortest.result["total_s"] == pytest.approx(shortest.result["travel_s"] + 12 * 30)
    seen = [sorted(round(float(row["eta_x"]), 6) for row in outcome.rows()) for outcome in (given, shortest, shuffled)]
    assert seen[0] == seen[1] == seen[2]
    assert given.text() != shuffled.text()


def test_fixed_positions_come_first(runs: dict[str, Outcome]) -> None:
    fixed = runs["fixed"]
    assert fixed.status == 0, fixed.err
    rows = fixed.rows()
    assert [row["fixed"] for row in rows] == ["yes"] * 9 + ["no"] * 3
    program = find_program("axes_and_edges_9").settings_for(parts.FULL)
    np.testing.assert_allclose([float(row["alpha1_deg"]) for row in rows[:9]], np.degrees(program[:, 0]), atol=1e-9)


def test_a_simulation_states_the_travel_of_each_program(runs: dict[str, Outcome]) -> None:
    visits = runs["simulated"].result["visits"]
    assert visits["rotations_18"]["total_s"] > visits["icosahedron_12"]["total_s"] > 12 * 60


@pytest.mark.parametrize(
    ("name", "phrases"),
    [
        ("wrong", ("order=longest", "given, random, shortest")),
        ("simulated wrong", ("order=longest", "given, random, shortest")),
        ("never", ("dwell_s=-1", "0 or more")),
        ("slow", ("speed_deg_s=0", "positive number")),
    ],
)
def test_bad_input_gets_one_plain_message(runs: dict[str, Outcome], name: str, phrases: tuple[str, ...]) -> None:
    assert_refused(runs[name], *phrases)


def test_a_slow_axis_is_worth_a_remark() -> None:
    stand, n = Chamber(), 100
    settings = stand.axes.random(np.random.default_rng(0), (n,))
    visit = itinerary(stand, settings, "given", np.random.default_rng(0))
    started = time.process_time()
    remark = shorter(visit, "given", 60.0)
    assert time.process_time() - started < 5.0
    least = itinerary(stand, settings, "shortest", np.random.default_rng(0)).seconds
    assert remark == f"most of the time is on the way; order=shortest makes that {least:.0f} s"
    assert shorter(visit, "random", 60.0) == ""
    assert shorter(visit, "given", visit.seconds) == ""
    sorted_already = itinerary(stand, settings, "shortest", np.random.default_rng(0))
    assert shorter(sorted_already, "given", 60.0) == ""


def test_a_fast_table_is_not() -> None:
    stand = TwoAxis()
    settings = stand.axes.random(np.random.default_rng(0), (12,))
    assert shorter(itinerary(stand, settings, "given", np.random.default_rng(0)), "given", 60.0) == ""
