"""Tables, figures and progress lines."""

import io
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from acalx.models import VectorAccel
from acalx.optimizers import Gradient
from acalx.planning.metrics import best_published, figures_of_merit
from acalx.programs import published
from acalx.quantities.magnitude import from_log, significant, with_decimals, written_from_log
from acalx.reporting.figures import draw_convergence, draw_entries, draw_positions
from acalx.reporting.progress import Progress
from acalx.reporting.tables import align, figures_table, markdown, program_table
from acalx.search.account import Account
from acalx.search.result import Solution
from acalx.stands import TwoAxis
from parts import BAND, EDGES, FACES, FULL, problem, program

SYMMETRIC = program(np.concatenate([FACES, EDGES]))


# ---------------------------------------------------------------- tables


def test_align_puts_names_left_and_numbers_right():
    assert align([["name", "value"], ["a", "1"], ["longer", "12.5"]]) == ("name    value\na           1\nlonger   12.5")


def test_markdown_is_a_table():
    assert markdown([["", "a"], ["D", "1"]]) == "|  | a |\n| --- | ---: |\n| D | 1 |"


def test_program_table_shows_degrees_and_no_negative_zeros():
    lines = program_table(FULL, SYMMETRIC).splitlines()
    assert lines[0].split() == ["position", "alpha1", "deg", "alpha2", "deg", "eta", "x", "eta", "y", "eta", "z"]
    assert len(lines) == 19
    assert lines[1].split() == ["1", "90.00", "0.00", "+1.0000", "+0.0000", "+0.0000"]
    assert "-0.0" not in "\n".join(lines)


def test_program_table_is_cut_where_it_is_long():
    text = program_table(FULL, np.zeros((100, 2)), most=10)
    assert len(text.splitlines()) == 12
    assert text.endswith("... 90 more in program.csv")


def test_figures_table_has_a_column_a_program():
    first, second = (figures_of_merit(problem(n=18).information(settings)) for settings in (SYMMETRIC, SYMMETRIC[::-1]))
    rows = figures_table({"one": first, "two": second})
    assert rows[0] == ["", "one", "two"]
    assert [row[0] for row in rows[1:4]] == ["D", "A", "E"]
    assert all(row[1] == row[2] for row in rows[1:])
    assert ["theta nonorthogonality", "1.0000", "1.0000"] in rows
    assert ["inequality bias", "0.000 %", "0.000 %"] in rows


# ---------------------------------------------------------------- figures of any size


@pytest.mark.parametrize("noise", [1e-12, 1.02e-7, 1.0, 1e3, 1e6])
def test_figures_have_four_significant_digits_or_more_at_any_noise(noise):
    stimulus = FULL.stimulus(SYMMETRIC)
    plain, scaled = (figures_of_merit(VectorAccel(noise_g=size).information(stimulus)) for size in (1.0, noise))
    cells = {row[0]: row[1] for row in figures_table({"one": scaled})}
    digits = 12 * math.log10(noise**2) + plain["log_D"] / math.log(10)
    mantissa, _, exponent = cells["D"].partition("e")
    assert math.log10(float(mantissa)) + float(exponent or 0) == pytest.approx(digits, abs=3e-6)
    for group, theta in plain["theta"].items():
        shown = float(cells[f"theta {group}"])
        assert shown == pytest.approx(noise * theta, rel=5.1e-4)
        assert len(cells[f"theta {group}"].partition("e")[0].replace(".", "").lstrip("0")) >= 4
    for key, power in (("A", 2), ("E", 2)):
        assert float(cells[key]) == pytest.approx(noise**power * plain[key], rel=6e-6)


def test_figures_of_ordinary_size_have_the_decimals_that_they_had():
    metrics = figures_of_merit(problem(n=18).information(SYMMETRIC))
    cells = {row[0]: row[1] for row in figures_table({"one": metrics})}
    assert [cells[key] for key in "DAE"] == [f"{metrics[key]:.6g}" for key in "DAE"]
    assert [cells[f"theta {group}"] for group in metrics["theta"]] == [f"{t:.4f}" for t in metrics["theta"].values()]
    assert cells["condition number"] == f"{metrics['condition_number']:.4g}"


@given(st.floats(-1e308, 1e308), st.integers(2, 12))
def test_significant_figures_are_the_number_again(value, digits):
    text = significant(value, digits)
    assert float(text) == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits), abs=0.0 if value else 1e-300)
    shown = text.lstrip("-").partition("e")[0].replace(".", "").lstrip("0")
    assert len(shown) >= digits or value == 0


@given(st.floats(-1e308, 1e308))
def test_decimals_are_kept_where_they_show_enough(value):
    text = with_decimals(value)
    assert float(text) == pytest.approx(value, rel=5.1e-4, abs=0.0 if value else 1e-300)
    if 0.1 <= abs(value) < 1e7:
        assert text == f"{value:.4f}"


@given(st.floats(-1e6, 1e6), st.integers(1, 9))
def test_written_logarithms_are_right_whatever_their_size(log, digits):
    mantissa, _, exponent = written_from_log(log, digits).partition("e")
    assert 0 < float(mantissa) < 10 or not exponent
    got = math.log(float(mantissa)) + math.log(10) * int(exponent or 0)
    assert got == pytest.approx(log, abs=0.51 * 10.0 ** (1 - digits) + 1e-9)


@given(st.floats(-600, 600))
def test_ordinary_logarithms_are_written_as_their_numbers(log):
    assert written_from_log(log) == f"{math.exp(log):.6g}"


@pytest.mark.parametrize("log", [math.inf, -math.inf, math.nan])
def test_logarithms_of_no_number(log):
    assert written_from_log(log) == f"{from_log(log):g}"
    values = {significant(from_log(log)), with_decimals(from_log(log)), written_from_log(log)}
    assert len(values) == 1


# ---------------------------------------------------------------- figures of merit


def test_figures_of_merit_of_the_symmetric_program():
    metrics = figures_of_merit(problem(n=18).information(SYMMETRIC))
    assert metrics["D"] == pytest.approx(8.6e-5, abs=5e-7)
    assert [round(value, 2) for value in metrics["theta"].values()] == [0.41, 0.53, 1.00]
    assert metrics["A"] == pytest.approx(sum(v**2 for v in metrics["standard_deviations"].values()))
    assert np.diag(metrics["correlations"]) == pytest.approx(np.ones(9))


def test_figures_of_merit_of_a_singular_program_are_infinite():
    metrics = figures_of_merit(problem(n=9).information(np.zeros((9, 2))))
    assert metrics["D"] == metrics["A"] == metrics["E"] == np.inf


def test_best_published_program_is_by_the_criterion():
    assert best_published(problem(n=12)).name == "icosahedron_12"
    assert best_published(problem(n=10)) is None
    others = [p for p in published().values() if p.n == 9]
    best = best_published(problem(n=9))
    losses = {p.name: float(problem(n=9).loss(p.settings_for(FULL))) for p in others}
    assert losses[best.name] == min(losses.values())


# ---------------------------------------------------------------- figures


@pytest.mark.parametrize("n", [1, 18, 200])
def test_positions_are_drawn_on_both_halves(tmp_path, n):
    directions = np.random.default_rng(0).normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    draw_positions(directions, tmp_path, "a title")
    text = (tmp_path / "positions.svg").read_text()
    assert ElementTree.fromstring(text).tag.endswith("svg")
    for word in ("a title", "+z", "-z", "+x", "+y"):
        assert word in text.replace("−", "-")
    assert (tmp_path / "positions.png").stat().st_size > 5000


def test_a_position_on_the_horizon_is_drawn_once(tmp_path):
    draw_positions(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -1e-17]]), tmp_path, "two")
    text = (tmp_path / "positions.svg").read_text()
    assert text.count(">1</text>") == 1
    assert text.count(">2</text>") == 1


@pytest.mark.parametrize("history", [[(10, 0.1, 2.0), (30, 0.2, 1.0), (50, 0.3, 0.5)], [(8, 0.1, -3.0)]])
def test_convergence_is_drawn(tmp_path, history):
    draw_convergence(history, tmp_path)
    assert f"final loss {history[-1][2]:.6g}" in (tmp_path / "convergence.svg").read_text().replace("−", "-")
    assert (tmp_path / "convergence.png").read_bytes().startswith(b"\x89PNG")


def test_entries_are_drawn_for_several_programs(tmp_path):
    regressors = problem(n=18).model.regressors(FULL.stimulus(SYMMETRIC))
    draw_entries({"symmetric": regressors, "again": regressors[:9]}, tmp_path, name="figure_3")
    text = (tmp_path / "figure_3.svg").read_text()
    assert "symmetric" in text
    assert "again" in text


def test_the_same_figure_is_the_same_file(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        draw_entries({"one": np.arange(9.0)}, tmp_path / name)
    assert (tmp_path / "a" / "entries.svg").read_bytes() == (tmp_path / "b" / "entries.svg").read_bytes()
    assert (tmp_path / "a" / "entries.png").read_bytes() == (tmp_path / "b" / "entries.png").read_bytes()


# ---------------------------------------------------------------- progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def account(seconds: float, fraction: float = 0.0, loss: float | None = -1.5) -> Account:
    best = None if loss is None else Solution(np.zeros((9, 2)), loss)
    running = Account(best=best, evaluations=1234, fraction=fraction)
    running.started -= seconds
    return running


def test_progress_is_quiet_for_two_seconds():
    stream = io.StringIO()
    progress = Progress(stream)
    progress(account(1.9, 0.5))
    progress.close()
    assert stream.getvalue() == ""


def test_progress_tells_the_time_left():
    stream = io.StringIO()
    Progress(stream)(account(3.0, 0.25))
    assert stream.getvalue() == "3 s: best loss -1.500000, 1234 evaluations, at most 9 s left\n"


@pytest.mark.parametrize(("seconds", "left"), [(31.0, "5 min"), (2000.0, "5.0 h")])
def test_progress_uses_units_that_fit(seconds, left):
    stream = io.StringIO()
    Progress(stream)(account(seconds, 0.1))
    assert f"at most {left} left" in stream.getvalue()


def test_progress_before_there_is_a_program():
    stream = io.StringIO()
    Progress(stream)(account(3.0, 0.0, loss=None))
    assert stream.getvalue() == "3 s: best loss none yet, 1234 evaluations\n"


def test_progress_writes_a_line_now_and_then_to_a_file_and_in_place_on_a_terminal():
    moments = (2.1, 2.2, 5.0, 11.0, 12.2, 12.6)
    for stream, expected in ((io.StringIO(), 2), (Terminal(), 5)):
        progress = Progress(stream)
        for seconds in moments:
            progress(account(seconds, 0.5))
        assert stream.getvalue().count("best loss") == expected
        progress.close()
    assert "\n" not in stream.getvalue()
    assert stream.getvalue().endswith("\r")
    assert stream.getvalue().split("\r")[-2].strip() == ""


def test_progress_is_called_by_an_optimizer():
    stream = io.StringIO()
    result = Gradient().solve(problem(n=9, stand=BAND), np.random.default_rng(0), Progress(stream))
    assert result.seconds > 2 or stream.getvalue() == ""
    called = []
    Gradient().solve(problem(stand=TwoAxis()), np.random.default_rng(0), called.append)
    assert len(called) > 3
    assert {type(item) for item in called} == {Account}
