"""The study of the inertial platform: its command gives the page that is kept here."""

from __future__ import annotations

import csv
import re
from decimal import Decimal
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from acalx.criteria import D
from acalx.models import Platform, as_model
from acalx.problem import Problem
from acalx.programs import read_program
from acalx.programs.sequences import regular_sequences
from acalx.sensors import PlatformAccel, PlatformGyro
from acalx.stands import PlatformGimbals
from command import Outcome, execute
from studies import modules_of

STUDY = Path(__file__).parents[1] / "experiments" / "wang_2016"
SOURCES = {
    *("page.md", "reproduce.py", "choices.py", "drawings.py", "inferred.py", "landscapes.py"),
    *("inferred.csv", "nearest.csv"),
}
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    folder = tmp_path_factory.mktemp("wang_2016")
    outcome = execute(folder, "python", str(STUDY / "reproduce.py"), "--to", "page")
    return Outcome(outcome.status, outcome.out, outcome.err, folder / "page")


def files(directory: Path) -> set[str]:
    found = {path.relative_to(directory) for path in directory.rglob("*") if path.is_file()}
    return {path.as_posix() for path in found if not path.parts[0].startswith((".", "__"))}


def figures(page: str) -> list[str]:
    """All but the positions, which are one of several equally good ways to turn a program."""
    return NUMBER.findall(page.partition("## Positions")[0])


def words(page: str) -> list[str]:
    """What stands there, but for the numbers and how wide columns are."""
    return NUMBER.sub("#", page).split()


def test_the_command_writes_the_page_that_is_kept(reproduced: Outcome) -> None:
    assert reproduced.status == 0, reproduced.err
    assert reproduced.err == ""
    kept, written = (STUDY / "README.md").read_text(encoding="utf-8"), reproduced.text("README.md")
    assert words(kept) == words(written)
    for one, other in zip(figures(kept), figures(written), strict=True):
        unit = Decimal(1).scaleb(int(Decimal(one).as_tuple().exponent))
        assert abs(Decimal(one) - Decimal(other)) <= unit


def test_every_file_is_kept_and_every_figure_of_the_page_is_there(reproduced: Outcome) -> None:
    assert files(reproduced.directory) == files(STUDY) - SOURCES
    shown = re.findall(r"\]\(([^)]+)\)", reproduced.text("README.md"))
    assert set(shown) == {"figure_2.png", "figure_3.png", "figure_4.png"}
    assert set(shown) <= files(reproduced.directory)


@pytest.mark.parametrize(("name", "n", "least"), [("joint_free_13", 13, 47.17), ("joint_free_16", 16, 54.77)])
def test_joint_programs_have_the_determinant(name: str, n: int, least: float) -> None:
    stand = PlatformGimbals()
    settings = read_program(STUDY / "programs" / f"{name}.csv").settings_for(stand)
    assert len(settings) == n
    assert -Problem(stand, Platform(), D(), n).loss(settings) >= least


def test_what_the_page_says(reproduced: Outcome) -> None:
    page = reproduced.text("README.md")
    assert "weakest group**, in 10 of 10 programs" in page
    share, bound = (float(cell) for cell in re.findall(r"\| by turns \|.*\| ([\d.]+) \| ([\d.]+) \|", page)[0])
    assert bound <= share < 1.0  # as good as every sequence by turns in every group
    assert float(re.findall(r"\| both \|.*\| ([\d.]+) \|\n", page)[0]) > 1.03  # proved: not for both rules
    within = float(re.findall(r"within ([\d.]+) % of that 16-position program", page)[0])
    assert within <= 12.0
    efficiency = [float(cell) for cell in re.findall(r"\| joint, free, \d+ .*\| ([\d.]+) \|\n", page)[:2]]
    np.testing.assert_array_less(0.996, efficiency)


# ---------------------------------------------------------------- the search over what was inferred


@pytest.fixture(scope="module")
def modules() -> tuple[ModuleType, ...]:
    return modules_of(STUDY, ("inferred", "choices"))


@pytest.fixture(scope="module")
def inferred(modules: tuple[ModuleType, ...]) -> ModuleType:
    return modules[0]


@pytest.fixture(scope="module")
def choices(modules: tuple[ModuleType, ...]) -> ModuleType:
    return modules[1]


def rows(name: str) -> list[dict[str, str]]:
    with (STUDY / name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_determinants_are_those_of_the_models_of_acalx(choices: ModuleType) -> None:
    settings = np.random.default_rng(0).uniform(0, 2 * np.pi, (3, 16, 2))
    stand = PlatformGimbals(azimuth_deg=60)
    force, rate = choices.felt(settings, 60)
    for axis, name in enumerate("xyz"):
        for pair in (("IS", "SS"), ("OO", "IO")):
            information = choices.per_measurement(choices.gyro_rows(force, rate, axis)[..., choices.members(pair)], 16)
            expected = as_model(PlatformGyro(name, pair)).information(stand.stimulus(settings)).log_det - 8 * np.log(16)
            np.testing.assert_allclose(choices.log_det(information)[:, 0], expected, atol=1e-8)
        information = choices.per_measurement(choices.accel_rows(force), 16)
        expected = as_model(PlatformAccel(name)).information(stand.stimulus(settings)).log_det - 4 * np.log(16)
        np.testing.assert_allclose(choices.log_det(information)[:, 0], expected, atol=1e-8)


def test_the_latitude_decides_nothing(choices: ModuleType) -> None:
    settings = np.random.default_rng(1).uniform(0, 2 * np.pi, (20, 16, 2))
    levels = {}
    for latitude in (0.0, 50.0):
        rows = choices.gyro_rows(*choices.felt(settings, 90, latitude), 0)[..., choices.members(("IS", "SS"))]
        levels[latitude] = choices.log_det(choices.per_measurement(rows, 16))
    np.testing.assert_allclose(levels[50.0] - levels[0.0], 4 * np.log(np.cos(np.radians(50.0))), atol=1e-8)


def test_the_rules_of_acalx_are_among_those_tried(choices: ModuleType) -> None:
    starts, steps = np.full((1, 2), 35.0), np.array([[45.0, 90.0]])
    for ours, rule in (("both", "both"), ("turn, outer first", "turn"), ("lines of the inner", "raster")):
        tried = np.degrees(choices.sequences(choices.Way(ours, against=False, home=False)))
        expected = regular_sequences(rule, starts, steps, 16) % 360.0
        assert (np.abs(tried - expected).max(axis=(1, 2)) < 1e-9).sum() == 1
        begun = choices.sequences(choices.Way(ours, against=False, home=True))
        np.testing.assert_array_equal(begun[:, 0], 0.0)
        np.testing.assert_allclose(np.degrees(begun[:, 1:]), tried[:, :-1], atol=1e-9)


def test_a_gyro_whose_axes_are_named_the_other_way_is_another_pair(choices: ModuleType) -> None:
    assert choices.swapped(("OO", "IO")) == ("SS", "IS")
    assert choices.swapped(("II", "OS")) == ("II", "OS")
    assert len(choices.gyro_models()) == 51  # 6 couples of pairs in 8 ways, and 3 pairs that stay


@pytest.mark.parametrize("row", rows("nearest.csv"), ids=lambda row: " ".join(list(row.values())[:7]))
def test_the_nearest_choices_give_what_is_kept(inferred: ModuleType, row: dict[str, str]) -> None:
    found = inferred.again(row)
    assert inferred.row_of(found) == row
    assert len(inferred.parallel_program(found)) == found.parallel
    assert (found.parallel, found.serial) == (13, 9) or found.apart < 0.005


@pytest.mark.parametrize("number", [1, 2, 7])
def test_a_way_of_turning_gives_what_is_kept(inferred: ModuleType, choices: ModuleType, number: int) -> None:
    (row,) = inferred.by_way(list(choices.search([choices.WAYS[number]])))
    assert row == rows("inferred.csv")[number]


def test_what_the_page_says_of_the_search(reproduced: Outcome) -> None:
    page, ways = reproduced.text("README.md"), rows("inferred.csv")
    exact = [row for row in ways if row["both"] != "0"]
    assert {(row["rule"], row["start counted"]) for row in exact} == {("both", "yes")}
    assert all(row["parallel 13"] == row["serial 9"] == "0" for row in ways if row not in exact)
    least = {(row["nearest: parallel"], row["serial"]) for row in ways if row["rule"] == "both" and row not in exact}
    assert least == {("12", "8")}
    assert min(int(row["fewest, added up"]) for row in ways) > 13
    counted = sum(int(row["both"]) for row in exact), sum(int(row["choices"]) for row in ways)
    assert "Both printed numbers come out {} times of {}, in 2 of 28 ways".format(*counted) in page
    assert not any(
        row["parallel"] == "13" and row["serial"] == "9" and float(row["log det apart"]) < 0.005
        for row in rows("nearest.csv")  # ordered by positions first, so that one that is equal would be there
    )
    assert all("9" not in (row["serial, accels first"], row["serial, one more"]) for row in rows("nearest.csv"))


def test_figures_2_and_3_are_those_of_the_paper(reproduced: Outcome) -> None:
    page = reproduced.text("README.md")
    tables = re.findall(r"\| (N(?: - 7)?) \| ([\d |]+) \|\n.*\n\| log det \| (.+) \|\n", page)
    assert [axis for axis, _, _ in tables] == ["N", "N", "N - 7", "N - 7"]
    largest = []
    for _, numbers, values in tables:
        best = {int(number): float(value) for number, value in zip(numbers.split("|"), values.split("|"), strict=True)}
        largest.append(max(best, key=lambda number: best[number]))
    # ours and the nearest: the accelerometers against N, then the gyros against N - 7, largest at 2 as is printed
    assert largest == [15, 8, 9, 2]
