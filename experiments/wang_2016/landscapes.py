"""The determinants of the traversal against the number of positions, and what the search over the choices left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from choices import LEAST_ACCELS, LEAST_GYROS, MOST, Landscape
from drawings import Curve, draw_determinants
from inferred import again, read

from acalx.criteria import D
from acalx.models import Platform
from acalx.optimizers import Traversal
from acalx.problem import Problem
from acalx.reporting.tables import markdown
from acalx.stands import PlatformGimbals

GYROS, ACCELS = Platform(sensors=["gyros"]), Platform(sensors=["accels"])


def traversed(model: Platform) -> tuple[str, Curve]:
    """What the traversal by the choices of this study finds, in words and as a curve."""
    result = Traversal().solve(Problem(PlatformGimbals(), model, D(), MOST), np.random.default_rng(0))
    survey = result.survey
    assert survey is not None  # a traversal always gives it
    return result.message, Curve("in turn, as in this study", survey.numbers, -survey.losses)


def along(curve: Curve, before: int = 0) -> str:
    """The largest determinant of each number of positions, or of positions beyond a number of them."""
    head = f"N - {before}" if before else "N"
    rows = [[head, *(str(n - before) for n in curve.numbers)], ["log det", *(f"{best:.2f}" for best in curve.best)]]
    return markdown(rows).replace("-inf", "singular")


def figures_2_and_3(directory: Path) -> dict[str, str]:
    """The accelerometers' determinant against N and the gyros' one against N - 7, by two sets of choices."""
    accels, ours_2 = traversed(ACCELS)
    gyros, ours_3 = traversed(GYROS)
    nearest = again(read("nearest.csv")[0])
    assert nearest is not None  # it was found by its own program
    landscape = Landscape(nearest.way, nearest.azimuth)
    title = "both at once, the start counted"
    # all three accelerometers have the same determinant
    theirs_2 = Curve(title, np.arange(LEAST_ACCELS, MOST + 1), 3.0 * landscape.accels)
    theirs_3 = Curve(title, np.arange(LEAST_GYROS, MOST + 1), landscape.values(nearest.pairs, nearest.judge))
    draw_determinants([theirs_2, ours_2], directory, "figure_2")
    draw_determinants([theirs_3, ours_3], directory, "figure_3", before=LEAST_GYROS - 1)
    return {
        "traversal_accels": accels,
        "landscape_accels": along(ours_2),
        "nearest_accels": along(theirs_2),
        "traversal_gyros": gyros,
        "landscape_gyros": along(ours_3, LEAST_GYROS - 1),
        "nearest_gyros": along(theirs_3, LEAST_GYROS - 1),
    }


def inferred() -> dict[str, str]:
    """The tables that the search over the inferred choices left, and what they add up to."""
    ways, nearest = read("inferred.csv"), read("nearest.csv")
    exact = [row for row in ways if row["both"] != "0"]
    return {
        "ways": markdown([list(ways[0]), *(list(row.values()) for row in ways)]),
        "nearest": markdown([list(nearest[0]), *(list(row.values()) for row in nearest)]),
        "tried": str(sum(int(row["choices"]) for row in ways)),
        "exact": str(sum(int(row["both"]) for row in ways)),
        "equal": str(sum(int(row["gyros equal"]) for row in ways)),
        "exact_ways": str(len(exact)),
        "of_ways": str(len(ways)),
        "apart_east": nearest[0]["log det apart"],
        "misaligned_east": nearest[0]["misalignments %"],
    }
