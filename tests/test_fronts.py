"""Several criteria as objectives: their front, its ends, what is refused, and what a run leaves."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import parts
from acalx.criteria import A, Criterion, D, E, Inequality, Objectives, Product
from acalx.errors import ArgumentError, CompatibilityError
from acalx.models import GyroRateTable
from acalx.numerics.arrays import Array
from acalx.optimizers import NSGA2, DifferentialEvolution, Gradient, Optimizer, Scalarized
from acalx.problem import Problem
from acalx.reporting.front_figure import draw_front
from acalx.search.account import Account
from acalx.search.aims import Aims, Goals
from acalx.search.front import lattice
from acalx.search.lagrangian import Lagrangian
from acalx.search.pareto import knee, nondominated, normalized, spread
from acalx.search.result import Front
from acalx.search.runs import Runs
from acalx.stands import RateTable, Stand, TwoAxis
from acalx.testing import check_optimizer
from command import Outcome, assert_refused, evaluate, run, together

INEQUALITY = Product([Inequality(group) for group in parts.GROUPS], [1 / 3] * 3)
NAMES: dict[str, Criterion] = {"d": D(), "a": A(), "e": E(), "inequality": INEQUALITY}
QUICK = NSGA2(population=20, generations=10)
both = pytest.mark.parametrize("optimizer", [Scalarized(), QUICK], ids=["scalarized", "nsga2"])


def objectives(*names: str) -> Objectives:
    return Objectives([NAMES[name] for name in names], names)


def problem(*names: str, n: int = 9, stand: Stand = parts.FULL) -> Problem:
    return parts.problem(objectives(*names), n, stand)


@cache
def solve(optimizer: Optimizer, asked: Problem, seed: int = 0) -> Front:
    return optimizer.solve(asked, np.random.default_rng(seed))


@cache
def best_alone(single: Problem) -> float:
    return Gradient().solve(single, np.random.default_rng(0)).best.loss


def losses_of(result: Front) -> Array:
    return np.array([point.losses for point in result.points])


# --- fronts ---


@pytest.mark.parametrize(
    ("names", "n", "stand"),
    [
        (("d", "a"), 9, parts.FULL),
        (("d", "a"), 12, parts.FULL),
        (("a", "d"), 10, parts.BAND),
        (("d", "e"), 9, parts.FULL),
    ],
    ids=repr,
)
def test_front_has_all_its_points_and_the_ends_of_one_objective_alone(
    names: tuple[str, ...], n: int, stand: Stand
) -> None:
    asked = problem(*names, n=n, stand=stand)
    result = solve(Scalarized(), asked)
    losses = losses_of(result)
    assert len(losses) == 50
    assert list(nondominated(losses)) == list(range(50))
    for k, single in enumerate(asked.singles):
        assert losses[:, k].min() <= best_alone(single) + 2e-6
    assert np.abs(np.diff(normalized(losses), axis=0)).max() < 0.06  # well spread
    np.testing.assert_allclose(asked.losses(np.array([p.settings for p in result.points])), losses, atol=1e-9)


def test_known_ends_at_nine_positions() -> None:
    losses = losses_of(solve(Scalarized(), problem("d", "a")))
    assert math.exp(losses[0, 0]) <= 0.04893152 * (1 + 2e-6)
    assert math.exp(losses[-1, 1]) == pytest.approx(7.9808, abs=1e-4)
    # the end is the best of all programs with the best D, which may be turned at will
    assert math.exp(losses[0, 1]) == pytest.approx(8.1007, abs=2e-4)


@pytest.mark.parametrize("names", [("d", "a"), ("d", "e"), ("d", "a", "e")], ids=repr)
def test_no_product_of_the_objectives_beats_the_front(names: tuple[str, ...]) -> None:
    asked = problem(*names)
    losses = losses_of(solve(Scalarized(), asked))
    for weights in lattice(len(names), 6):
        if (weights > 0).all():
            product = parts.problem(Product([NAMES[name] for name in names], list(weights)))
            reached = Gradient(starts=40).solve(product, np.random.default_rng(3)).best.loss
            assert reached >= (losses @ weights).min() - 0.01 * np.ptp(losses, axis=0).min() - 1e-6
            assert reached <= (losses @ weights).min() + 1e-6


def test_front_of_equality_is_not_convex_and_reached() -> None:
    """Between D and the inequality within limits lie parts that no weighted sum comes to."""
    losses = losses_of(
        solve(Scalarized(points=20, seeds=4, iterations=300), problem("d", "inequality", stand=parts.BAND), seed=3)
    )
    assert len(losses) == 20
    assert losses[:, 0].min() <= best_alone(problem("d", "inequality", stand=parts.BAND).singles[0]) + 2e-6
    assert losses[:, 1].min() == pytest.approx(math.log(5e-4), abs=1e-5)
    places = normalized(losses)
    weighted = {int((places @ (1 - w, w)).argmin()) for w in np.linspace(0, 1, 201)}
    assert len(weighted) < 15


def test_objectives_that_agree_have_one_best_program() -> None:
    result = solve(Scalarized(), problem("d", "inequality"))
    assert len(result.points) == 1
    assert "one program is best in all" in result.message
    assert math.exp(result.points[0].losses[0]) == pytest.approx(0.0489315, rel=1e-5)
    assert result.points[0].losses[1] == pytest.approx(math.log(5e-4), abs=1e-5)


def test_three_objectives() -> None:
    asked = problem("d", "a", "e")
    result = solve(Scalarized(), asked)
    losses = losses_of(result)
    assert losses.shape == (50, 3)
    assert len(nondominated(losses)) == 50
    for k, single in enumerate(asked.singles):
        assert losses[:, k].min() <= best_alone(single) + 2e-6


@pytest.mark.parametrize("stand", [parts.FULL, parts.PATCH, TwoAxis(step_deg=30)], ids=repr)
@pytest.mark.parametrize("optimizer", [Scalarized(points=8, seeds=3), QUICK], ids=["scalarized", "nsga2"])
def test_contract(optimizer: Optimizer, stand: Stand) -> None:
    if stand.axes.stepped and isinstance(optimizer, Scalarized):
        with pytest.raises(CompatibilityError, match=r"Scalarized moves angles continuously.*use optimizer=NSGA2\(\)"):
            solve(optimizer, problem("d", "a", stand=stand))
    else:
        check_optimizer(optimizer, problem("d", "a", stand=stand))


def test_nsga2_takes_settings_with_steps_beside_others_without() -> None:
    table, model = RateTable(step_deg=30), GyroRateTable()
    assert {setting.step is None for setting in table.settings} == {True, False}
    asked = Problem(table, model, objectives("d", "a"), model.smallest_n + 2)
    check_optimizer(QUICK, asked)
    rates = solve(QUICK, asked).program[:, [s.step is None for s in table.settings]]
    assert np.abs(rates - np.round(rates)).max() > 1e-3  # not rounded with the others


def test_polish_takes_the_ends_of_evolution_to_the_best() -> None:
    asked = problem("d", "a")
    rough = losses_of(solve(NSGA2(population=20, generations=10, polish=False), asked))
    polished = losses_of(solve(QUICK, asked))
    assert len(nondominated(np.concatenate([rough, polished]))) == len(polished) == 50
    for k, single in enumerate(asked.singles):
        assert rough[:, k].min() > best_alone(single) + 1e-3
        assert polished[:, k].min() <= best_alone(single) + 2e-6


def test_evolution_alone_finds_better_programs_with_time() -> None:
    asked = problem("d", "a")
    few, many = (
        losses_of(solve(NSGA2(population=40, generations=g, polish=False), asked)).min(axis=0) for g in (5, 100)
    )
    assert (many < few - 0.05).all()


@both
def test_another_seed_gives_another_front(optimizer: Optimizer) -> None:
    one, other = (solve(optimizer, problem("d", "a"), seed) for seed in (0, 1))
    assert one.points[25].settings.tobytes() != other.points[25].settings.tobytes()
    assert losses_of(one).min(axis=0) == pytest.approx(losses_of(other).min(axis=0), abs=2e-6)


@both
@pytest.mark.parametrize("calls", [1, 40])
def test_interrupt_leaves_the_front_so_far(optimizer: Optimizer, calls: int) -> None:
    asked = problem("d", "a", stand=parts.BAND)
    seen = 0

    def watch(account: Account) -> None:
        nonlocal seen
        seen += 1
        assert 0.0 <= account.fraction <= 1.0
        if seen >= calls and account.found:
            raise KeyboardInterrupt

    result = optimizer.solve(asked, np.random.default_rng(0), watch)
    assert result.status == "interrupted"
    assert "best front so far" in result.message
    losses = losses_of(result)
    assert len(nondominated(losses)) == len(losses) > 0
    assert asked.losses(result.program) == pytest.approx(result.points[result.knee].losses, abs=1e-9)


# --- goals ---


def test_goals_are_met_where_the_front_crosses_their_ray() -> None:
    asked = problem("d", "a", n=10)
    targets = np.array([[-4.0, 1.8], [-4.0, 1.9], [-3.9, 1.8]])
    aims = Aims(np.full((3, 2), 1e-4), Goals(targets, np.array([1.0, 2.0]), 0.05))
    starts = asked.restrictions.random(np.random.default_rng(0), 3)
    lagrangian = Lagrangian([single.objective for single in asked.singles], asked.restrictions, (10, 2))
    runs = Runs(lagrangian, aims, Account(), starts).descend(1e-6, 1000)
    excess = (runs.losses - targets) / (1.0, 2.0)
    on_ray = np.abs(excess[:, 0] - excess[:, 1]) < 0.002
    below = excess.min(axis=1) < excess.max(axis=1) - 0.002  # an end of the front, off the ray
    assert (on_ray | below).all()
    np.testing.assert_allclose(aims.merit(runs.losses), runs.merit)


# --- sets of losses ---

LOSSES = st.integers(2, 4).flatmap(
    lambda k: st.lists(st.lists(st.integers(0, 6).map(float), min_size=k, max_size=k), min_size=1, max_size=30)
)


@given(LOSSES)
def test_nondominated_is_what_its_name_says(rows: list[list[float]]) -> None:
    losses = np.array(rows)
    kept = nondominated(losses)
    better = (losses[:, None] <= losses).all(axis=-1) & (losses[:, None] < losses).any(axis=-1)
    expected = {tuple(row) for row in losses[~better.any(axis=0)]}
    assert [tuple(row) for row in losses[kept]] == sorted(expected)


def test_points_that_differ_by_rounding_are_one() -> None:
    assert list(nondominated(np.array([[0.0, 1.0], [1e-8, 0.5], [2.0, 0.5 - 1e-8], [3.0, np.inf]]))) == [1]


def test_knee_is_farthest_below_the_line_through_the_ends() -> None:
    first = np.linspace(0, 1, 101)
    assert knee(np.stack([first, (1 - first) ** 2], axis=-1) * (3.0, 0.1)) == 50
    assert knee(np.zeros((1, 2))) == 0


def test_spread_keeps_the_ends_and_is_even() -> None:
    first = np.linspace(0, 1, 1001)
    chosen = spread(np.stack([first, 1 - first], axis=-1), 9)
    assert list(chosen) == [0, 125, 250, 375, 500, 625, 750, 875, 1000]


@pytest.mark.parametrize(("k", "count", "size"), [(2, 50, 50), (3, 50, 45), (3, 2, 3), (4, 50, 35)])
def test_lattice_is_the_largest_that_fits(k: int, count: int, size: int) -> None:
    weights = lattice(k, count)
    assert weights.shape == (size, k)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert len({tuple(row) for row in weights.round(9)}) == size
    assert all((weights[:, i] == 1.0).sum() == 1 for i in range(k))


# --- what does not fit ---


@pytest.mark.parametrize("optimizer", [Gradient(), DifferentialEvolution()], ids=["gradient", "de"])
def test_optimizers_of_one_criterion_refuse_several(optimizer: Optimizer) -> None:
    message = (
        r"optimizer \w+ takes one criterion, got the objectives d, a; "
        r"for several use optimizer=Scalarized\(\) or optimizer=NSGA2\(\), or multiply them to a product"
    )
    with pytest.raises(CompatibilityError, match=message):
        solve(optimizer, problem("d", "a"))


@both
def test_optimizers_of_several_refuse_one(optimizer: Optimizer) -> None:
    with pytest.raises(
        CompatibilityError,
        match=r"takes several objectives, got D alone; give two or more.*Objectives\(\[D\(\), A\(\)\]\)",
    ):
        solve(optimizer, parts.problem(D()))


def test_objectives_have_no_single_loss() -> None:
    asked = problem("d", "a")
    programs = asked.restrictions.random(np.random.default_rng(0), 3)
    assert asked.losses(programs).shape == (3, 2)
    for refused in (asked.loss, asked.loss_and_gradient):
        with pytest.raises(CompatibilityError, match="the objectives d, a have no single loss"):
            refused(programs)


@pytest.mark.parametrize(
    ("criteria", "names", "message"),
    [
        ([D()], None, "give two or more"),
        ([], None, "give two or more"),
        ([D(), D()], None, "D is there twice"),
        ([D(), D()], ["d", "b"], "b is there twice, the other time as d"),
        ([D(), A()], ["d"], "take as many names"),
        ([D(), "a"], None, "objectives are a list of criteria"),
        ([D(), objectives("d", "a")], None, "objectives are a list of criteria"),
    ],
)
def test_bad_objectives(criteria: list[Criterion], names: list[str] | None, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Objectives(criteria, names)


def test_an_objective_that_does_not_fit_the_model() -> None:
    with pytest.raises(ArgumentError, match="no parameter group 'gyro'"):
        parts.problem(Objectives([D(), Inequality("gyro")]))


@pytest.mark.parametrize(
    ("kind", "name", "bad"),
    [
        *((Scalarized, name, 0) for name in ("points", "seeds", "starts", "batch", "iterations")),
        *((Scalarized, name, -1.0) for name in ("agreement", "tolerance")),
        *((NSGA2, name, 2.5) for name in ("population", "generations", "points")),
        *((NSGA2, name, bad) for name in ("crossover", "mutation") for bad in (0, 1.5, "x")),
        *((NSGA2, name, 0) for name in ("crossover_eta", "mutation_eta")),
        (NSGA2, "polish", "yes"),
    ],
)
def test_bad_options(kind: type[Optimizer], name: str, bad: object) -> None:
    with pytest.raises(ArgumentError, match=f"^{name}={bad!r}: "):
        kind(**{name: bad})


def test_fewer_points_than_ends() -> None:
    with pytest.raises(ArgumentError, match="points=2: a front of 3 objectives has 3 ends or more"):
        solve(Scalarized(points=2), problem("d", "a", "e"))


# --- the command ---

COMMAND = ("objectives=[d,a]", "optimizer=scalarized", "optimizer.points=12", "n=9")


@pytest.fixture(scope="module")
def commands(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Outcome]:
    folder = tmp_path_factory.mktemp("fronts")
    mine = folder / "mine" / "criterion"
    mine.mkdir(parents=True)
    (mine / "both.yaml").write_text(
        "_target_: acalx.criteria.Product\ncriteria: [{_target_: acalx.criteria.D}, {_target_: acalx.criteria.E}]\n"
    )
    own = ("objectives=[both,inequality_bias]", "optimizer=nsga2", "optimizer.generations=5", "figures=false")
    calls = {
        "two": COMMAND,
        "own": (f"--config-dir={mine.parent}", *own),
        "one": ("objectives=[d]", "optimizer=scalarized"),
        "single": ("criterion=d", "optimizer=nsga2"),
        "gradient": ("objectives=[d,a]", "optimizer=gradient"),
        "twice": ("objectives=[d,a,d]", "optimizer=scalarized"),
        "unknown": ("objectives=[d,inequalty]", "optimizer=scalarized"),
        "beside": ("objectives=[d,a]", "optimizer=scalarized", "criterion=e"),
        "certificate": ("objectives=[d,a]", "optimizer=scalarized", "certificate=true"),
        "certainly": ("certificate=maybe",),
    }
    outcomes = together([partial(run, folder, *arguments, into=name) for name, arguments in calls.items()])
    return dict(zip(calls, outcomes, strict=True))


def test_a_run_leaves_the_front(commands: dict[str, Outcome]) -> None:
    outcome = commands["two"]
    assert outcome.status == 0, outcome.err
    assert {"front.csv", "front.svg", "front.png", "program.csv", "resolved.yaml"} <= outcome.files
    assert not {"alternatives.csv", "history.csv", "convergence.svg"} & outcome.files
    rows = outcome.rows("front.csv")
    assert list(rows[0]) == ["point", "d", "a", "knee", "log_d", "log_a"]
    assert [row["point"] for row in rows] == [str(k + 1) for k in range(12)]
    values = np.array([[float(row["d"]), float(row["a"])] for row in rows])
    assert (np.diff(values[:, 0]) > 0).all()
    assert (np.diff(values[:, 1]) < 0).all()
    (number,) = [int(row["point"]) for row in rows if row["knee"] == "1"]
    result = outcome.result
    assert (result["status"], result["loss"], result["certificate"]) == ("ok", None, None)
    assert (result["objectives"], result["points"], result["knee"]) == (["d", "a"], 12, number)
    assert np.exp(result["losses"]) == pytest.approx(values[number - 1], rel=1e-12)
    assert (result["metrics"]["D"], result["metrics"]["A"]) == pytest.approx(values[number - 1], rel=1e-9)
    assert outcome.text(f"front/{number:02}.csv") == outcome.text("program.csv")
    assert sorted(path.name for path in (outcome.directory / "front").iterdir()) == [
        f"{k:02}.csv" for k in range(1, 13)
    ]
    assert ElementTree.parse(outcome.directory / "front.svg").getroot().tag.endswith("svg")
    for words in (f"knee ({number})", "best d (1)", "best a (12)", "12 points on the front"):
        assert words in outcome.out


def test_front_runs_again_and_its_programs_evaluate(commands: dict[str, Outcome], tmp_path: Path) -> None:
    two, own = commands["two"], commands["own"]
    assert own.status == 0, own.err
    calls = [
        partial(run, tmp_path, f"--config-dir={outcome.directory}", "--config-name=resolved", into=name)
        for name, outcome in (("two", two), ("own", own))
    ]
    program = f"program={two.directory}/front/07.csv"
    calls.append(partial(evaluate, tmp_path, program, "criterion=a", "figures=false"))
    again, own_again, evaluated = together(calls)
    for before, after in ((two, again), (own, own_again)):
        assert after.status == 0, after.err
        for file in ("front.csv", "program.csv", "front/03.csv", "resolved.yaml"):
            assert after.text(file) == before.text(file)
    assert evaluated.metrics["A"] == pytest.approx(float(two.rows("front.csv")[6]["a"]), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "phrases"),
    [
        ("one", ("objectives=[d]", "give two or more")),
        ("single", ("optimizer NSGA2 takes several objectives, got D alone",)),
        ("gradient", ("optimizer Gradient takes one criterion", "optimizer=scalarized")),
        ("twice", ("objectives=[d,a,d]: d is there twice",)),
        ("unknown", ("there is no criterion inequalty", "did you mean inequality?")),
        ("beside", ("criterion=e beside objectives",)),
        ("certificate", ("certificate=true", "acalx.run criterion=d", "acalx.evaluate program=")),
        ("certainly", ("certificate=maybe: must be auto, true or false",)),
    ],
)
def test_refusals(commands: dict[str, Outcome], name: str, phrases: tuple[str, ...]) -> None:
    assert_refused(commands[name], *phrases)


# --- the figure ---


@pytest.mark.parametrize("k", [2, 3, 4])
@pytest.mark.parametrize("m", [1, 30])
def test_front_is_drawn(tmp_path: Path, k: int, m: int) -> None:
    names = [f"objective {i}" for i in range(k)]
    values = np.exp(np.random.default_rng(0).normal(size=(m, k)) * np.linspace(0.1, 2.0, k))
    near, far = values.mean(axis=0), 1e3 * values.max(axis=0)
    draw_front(names, values, m // 2, tmp_path, "a title", {"published": near, "far": far})
    text = (tmp_path / "front.svg").read_text()
    for word in ("a title", "knee", *names):
        assert word in text
    assert ("published" in text) == (k < 4)
    assert ">far<" not in text
    assert (tmp_path / "front.png").stat().st_size > 5000
