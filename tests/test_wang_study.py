"""The study of the inertial platform: its command gives the page that is kept here."""

from __future__ import annotations

import re
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from acalx.criteria import D
from acalx.models import Platform
from acalx.problem import Problem
from acalx.programs import read_program
from acalx.stands import PlatformGimbals
from command import Outcome, execute

STUDY = Path(__file__).parents[1] / "experiments" / "wang_2016"
SOURCES = {"page.md", "reproduce.py"}
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


def test_the_command_writes_the_page_that_is_kept(reproduced: Outcome) -> None:
    assert reproduced.status == 0, reproduced.err
    assert reproduced.err == ""
    kept, written = (STUDY / "README.md").read_text(encoding="utf-8"), reproduced.text("README.md")
    assert NUMBER.sub("#", kept) == NUMBER.sub("#", written)
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
