"""Reproduces Tables 1 to 7 and Figures 1 to 3 of Egorov, Kiryachenko, Popov (2021) and writes the page of results."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from drawings import MARKS, draw_figure_2, draw_figure_3, sorted_columns
from kinematics import ALPHA_1, ALPHA_2, draw_figure_1
from printed import GROUPS, KEYS, PRINTED, TABLE_5, TABLES, agrees, smaller
from simulations import tables_6_and_7

from acalx.criteria import Criterion, D, Inequality, Product
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.optimizers import DifferentialEvolution, Gradient, Optimizer
from acalx.planning.metrics import figures_of_merit
from acalx.problem import Problem
from acalx.programs import find_program, read_program
from acalx.recording import RunDirectory
from acalx.reporting.figures import draw_positions
from acalx.reporting.tables import figures_table, markdown, program_table
from acalx.stands import TwoAxis

HERE = Path(__file__).resolve().parent
STAND, MODEL = TwoAxis(), ScalarAccel()
FAIR = Product([D(), *(Inequality(group) for group in GROUPS)], [1.0, 0.1, 0.1, 0.1])
OPTIMIZERS: dict[str, Optimizer] = {"de": DifferentialEvolution(), "gradient": Gradient()}

# Figure 2.
CLASSES = dict(
    zip(
        MARKS,
        (
            ("rotations_18", "rotations_24", "rotations_36"),
            ("axes_and_vertices_9", "axes_and_edges_9", "faces_and_edges_18"),
            ("icosahedron_12", "dodecahedron_20"),
            ("egorov_2021_table_1", "egorov_2021_table_2"),
        ),
        strict=True,
    )
)
NUMBERS = range(9, 37)


def design(criterion: Criterion, optimizer: str, n: int) -> Array:
    """Settings (n, 2) of the best program, always from the same seed."""
    return OPTIMIZERS[optimizer].solve(Problem(STAND, MODEL, criterion, n), np.random.default_rng(0)).best.settings


def angles(name: str) -> Array:
    """Settings (n, 2) of a published program."""
    return find_program(name).settings_for(STAND)


def metrics(settings: Array) -> dict[str, Any]:
    """All the figures of merit of a program."""
    return figures_of_merit(MODEL.information(STAND.stimulus(settings)))


def values(figures: Mapping[str, Any]) -> list[float]:
    """Those that the paper prints, in the order of KEYS, inequalities in %."""
    inequalities = [100.0 * figures["inequality"][group] for group in GROUPS]
    return [figures["D"], *(figures["theta"][group] for group in GROUPS), *inequalities]


def constant_of_the_bound() -> Fraction:
    """D1 of D >= D1 / n^9: 1 / det of the information of one position spread evenly over the sphere."""
    square, fourth, mixed = Fraction(1, 3), Fraction(1, 5), Fraction(1, 15)
    squares = (fourth - mixed) ** 2 * (fourth + 2 * mixed)
    return 1 / (square**3 * squares * mixed**3)


def bound(n: int) -> float:
    """The least D that n positions could have."""
    return float(constant_of_the_bound() / n**9)


def times_bound(d: float, n: int) -> float:
    """D as a multiple of it."""
    return d / bound(n)


def beside(printed: list[str], columns: Mapping[str, Mapping[str, Any]], turned: tuple[str, ...] = ()) -> str:
    """Figures of merit beside the printed ones; ~ for columns of which only D is determined."""
    head, *rows = figures_table(columns)
    cells = dict(zip(KEYS, [*printed[:4], *(f"{text} %" for text in printed[4:])], strict=True))
    table = [["", "printed", *head[1:]]]
    for key, *figures in rows:
        marks = ["~" if column in turned and key != "D" else "" for column in columns]
        table.append([key, cells.get(key, "-"), *(m + f for m, f in zip(marks, figures, strict=True))])
    return markdown(table)


def comparison(table: str) -> str:
    """The programs of Table 3 or 4 by their numbers there, their printed figures above the computed ones."""
    rows = [["no.", "program", "", *KEYS, "agree"]]
    for number, name in TABLES[table].items():
        title, printed = PRINTED[name]
        computed = values(metrics(angles(name)))
        same = all(map(agrees, printed, computed))
        rows.append([number, title, "printed", *printed, ""])
        forms = ["#.6g", *[".4f"] * len(GROUPS), *[".3f"] * len(GROUPS)]
        cells = [format(value + 0.0, form) for value, form in zip(computed, forms, strict=True)]
        rows.append(["", "", "computed", *cells, "yes" if same else "**no**"])
    return markdown(rows)


def agreement() -> str:
    """How many printed figures the positions give, and which they do not."""
    total, others = 0, []
    for name, (title, printed) in PRINTED.items():
        for key, text, value in zip(KEYS, printed, values(metrics(angles(name))), strict=True):
            total += 1
            if not agrees(text, value):
                cut = ", cut off rather than rounded" if f"{value:.10f}".startswith(text) else ""
                others.append(f'The exception: {key} of "{title}" is {value:.6g} but printed as {text}{cut}.')
    counted = f"{total - len(others)} of {total} figures of the programs whose positions are known agree"
    return "\n  ".join([f"{counted} to the last printed digit.", *others])


def verdict(fair: Mapping[str, Mapping[str, Any]]) -> str:
    """Whether acalx's fair programs are better than Table 5, figure by figure."""
    worse = [
        f"{key} by {optimizer}"
        for optimizer, figures in fair.items()
        for key, value, text in zip(KEYS, values(figures), TABLE_5, strict=True)
        if not smaller(value, text)
    ]
    if worse:
        return f"Not in every figure, though: {', '.join(worse)} is no smaller than printed."
    return "acalx's program is strictly better in all seven figures, however the printed ones were rounded."


def classes(optimized: Mapping[int, float]) -> str:
    """D of the programs of Figure 2 beside the lower bound."""
    rows = [["program", "positions", "D", "lower bound", "D / bound"]]
    listed = [(find_program(name).title.split(";")[0], angles(name)) for names in CLASSES.values() for name in names]
    points = [(title, len(settings), metrics(settings)["D"]) for title, settings in listed]
    points += [("optimized by acalx", n, optimized[n]) for n in NUMBERS]
    for title, n, d in points:
        rows.append([title, str(n), f"{d:#.6g}", f"{bound(n):#.6g}", f"{times_bound(d, n):.4f}"])
    return markdown(rows)


def block(settings: Array) -> str:
    """The positions of a program, as text that keeps its columns."""
    return f"```text\n{program_table(STAND, settings)}\n```"


def tables_1_and_2() -> dict[str, str]:
    """The printed programs beside those that acalx designs for D."""
    texts = {}
    for k in (1, 2):
        name = f"egorov_2021_table_{k}"
        designed = {f"acalx, {optimizer}": metrics(design(D(), optimizer, 9 * k)) for optimizer in OPTIMIZERS}
        columns = {"computed": metrics(angles(name))} | designed
        texts[f"angles_{k}"] = block(angles(name))
        texts[f"table_{k}"] = beside(PRINTED[name][1], columns, turned=tuple(designed) if k == 1 else ())
    return texts


def tables_3_to_5(directory: Path) -> dict[str, str]:
    """The comparison, and acalx's fair program with its files."""
    designed = {f"acalx, {optimizer}": design(FAIR, optimizer, 9) for optimizer in OPTIMIZERS}
    fair = {name: metrics(settings) for name, settings in designed.items()}
    settings = designed["acalx, de"]
    RunDirectory(directory / "fair_9", []).write_program(STAND, settings)
    force = STAND.stimulus(settings)["specific_force"]
    assert force is not None  # a two-axis table always gives it
    draw_positions(force, directory / "fair_9", "9 positions, equally accurate within each group")
    return {
        "agreement": agreement(),
        "table_3": comparison("Table 3"),
        "table_4": comparison("Table 4"),
        "table_5": beside(TABLE_5, fair, turned=tuple(fair)),
        "angles_5": block(settings),
        "verdict": verdict(fair),
    }


def figure_2(directory: Path) -> dict[str, str]:
    """D against the number of positions."""
    optimized = {n: float(metrics(design(D(), "gradient", n))["D"]) for n in NUMBERS}
    programs = {label: [angles(name) for name in names] for label, names in CLASSES.items()}
    points = {label: [(len(each), metrics(each)["D"]) for each in some] for label, some in programs.items()}
    draw_figure_2(points, optimized, bound, directory)
    ratios = {n: times_bound(d, n) for n, d in optimized.items()}
    return {
        "d_1": f"{constant_of_the_bound()} = {float(constant_of_the_bound()):.2f}",
        "classes": classes(optimized),
        "above": ", ".join(f"{n} ({ratio:.4f})" for n, ratio in ratios.items() if ratio > 1 + 1e-6),
    }


def figure_3(directory: Path) -> dict[str, str]:
    """The sorted entries of H, column by column: how far the columns of a group are apart, and what comes of it."""
    optimized, symmetric = angles("egorov_2021_table_2"), angles("faces_and_edges_18")
    regressors = {"(a) optimized": regressors_of(optimized), "(b) symmetric": regressors_of(symmetric)}
    draw_figure_3(regressors, directory)
    programs = {
        "(a) Table 2, optimized for D": optimized,
        "(b) 6 faces, 12 edge midpoints": symmetric,
        "acalx, optimized for D": design(D(), "gradient", 18),
        "Table 1, optimized for D": angles("egorov_2021_table_1"),
        "acalx, fair": read_program(directory / "fair_9" / "program.csv").settings_for(STAND),
    }
    rows = [["program", "positions", *(f"apart, {group}" for group in GROUPS), *KEYS[-len(GROUPS) :]]]
    for title, settings in programs.items():
        apart = [float(np.ptp(columns, axis=1).max()) for columns in sorted_columns(regressors_of(settings)).values()]
        inequalities = values(metrics(settings))[-len(GROUPS) :]
        mark = "~" if title.startswith("acalx") else ""
        cells = [*(f"{mark}{value:.3f}" for value in apart), *(f"{mark}{value + 0.0:.3f} %" for value in inequalities)]
        rows.append([title, str(len(settings)), *cells])
    zeros = {label: int((np.abs(rows) < 1e-12).sum()) for label, rows in regressors.items()}
    return {"columns": markdown(rows), "zeros": ", ".join(f"{count} in {label}" for label, count in zeros.items())}


def regressors_of(settings: Array) -> Array:
    """The regressor matrix H (n, 9) of a program."""
    return MODEL.regressors(STAND.stimulus(settings))[:, 0, :]


def reproduce(directory: Path) -> None:
    """Write the page, the figures and the fair program."""
    directory.mkdir(parents=True, exist_ok=True)
    draw_figure_1(directory)
    parts = (
        {"drawn": f"{np.degrees(ALPHA_1):.0f} and {np.degrees(ALPHA_2):.0f}"}
        | tables_1_and_2()
        | tables_3_to_5(directory)
        | figure_2(directory)
        | figure_3(directory)
    )
    parts |= tables_6_and_7(read_program(directory / "fair_9" / "program.csv").settings_for(STAND))
    page = Template((HERE / "page.md").read_text(encoding="utf-8")).substitute(parts)
    (directory / "README.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, default=HERE, metavar="DIRECTORY", help="default: beside this script")
    reproduce(parser.parse_args().to)
