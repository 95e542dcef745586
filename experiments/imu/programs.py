"""Joint programs beside the usual recipes: standard errors, and how many positions they take."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from recipes import RECIPES, program_of

from acalx.bounds import bound
from acalx.criteria import D
from acalx.models import Compared, Model, as_model
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient
from acalx.planning.design import design
from acalx.problem import Problem
from acalx.programs import Program
from acalx.quantities.parameter import parameter_groups
from acalx.sensors import IMU
from acalx.stands import TwoAxisRateTable

__all__ = [
    "GROUPS",
    "KNOWN",
    "MODEL",
    "STAND",
    "Accuracy",
    "Programs",
    "needed_without_arms",
    "plain",
    "save",
    "targeted",
    "written",
]

STAND, SENSOR = TwoAxisRateTable(), IMU()
MODEL, BARE = as_model(SENSOR), as_model(IMU(arms=()))
# What is known of a unit of the make before it is measured: so much do they differ. What a program does not show
# keeps this standard error, and the others still have theirs.
KNOWN: Model = Compared(SENSOR, prior={one.name: float(one.scatter or 0.0) for one in SENSOR.parameters})
SIZES, FURTHER = (12, 24, 36), (20, 30, 40)
# A position that leaves more than half of what was known before shows nothing.
SHOWN = 0.5
# Rates below it are for the angle more than for the gyro.
SLOW_DEG_S = 30.0


@dataclass(frozen=True)
class Group:
    """How a group of parameters is written: its name, the unit, how many of them are one of the model's."""

    title: str
    unit: str
    factor: float


GROUPS = {
    "accel_bias": Group("accel. bias", "µg", 1e6),
    "accel_scale": Group("accel. scale", "ppm", 1e6),
    "accel_misalignment": Group("accel. misalignment", "µrad", 1e6),
    "accel_quadratic": Group("accel. square", "µg/g²", 1e6),
    "accel_arm": Group("lever arm", "µm", 1e6),
    "gyro_bias": Group("gyro bias", "deg/h", 3600.0),
    "gyro_scale": Group("gyro scale", "ppm", 1e6),
    "gyro_misalignment": Group("gyro misalignment", "µrad", 1e6),
    "gyro_g_sensitivity": Group("g-sensitivity", "deg/h/g", 3600.0),
}


@dataclass(frozen=True)
class Accuracy:
    """Standard errors of a program by group, in the units of `GROUPS`.

    Parameters
    ----------
    name : str
    settings : array (n, 4), rad and rad/s
    """

    name: str
    settings: Array

    @property
    def n(self) -> int:
        """Number of positions."""
        return len(self.settings)

    @cached_property
    def deviations(self) -> Array:
        """Standard errors of all parameters with what was known before, (p,)."""
        return KNOWN.information(STAND.stimulus(self.settings)).standard_deviations

    @cached_property
    def shown(self) -> np.ndarray:
        """Which parameters it shows, (p,)."""
        return self.deviations < SHOWN * np.array([one.scatter for one in SENSOR.parameters])

    def of(self, group: str) -> tuple[float, int, int]:
        """The largest standard error of those that are shown, how many these are, and of how many."""
        members = np.array(parameter_groups(SENSOR.parameters)[group])
        shown = members[self.shown[members]]
        largest = float(self.deviations[shown].max()) if len(shown) else math.nan
        return GROUPS[group].factor * largest, len(shown), len(members)

    def cell(self, group: str) -> str:
        """The same for a table."""
        largest, shown, count = self.of(group)
        if not shown:
            return "not shown"
        return written(largest) if shown == count else f"{written(largest)}, {shown} of {count}"

    def needed(self, group: str, wanted: float) -> int | None:
        """Positions that bring the whole group to a standard error, where the program is repeated; None: none do."""
        largest, shown, count = self.of(group)
        return None if shown < count else math.ceil(self.n * (largest / wanted) ** 2 - 1e-9)


def written(value: float) -> str:
    """Three digits of a standard error."""
    return f"{value:.0f}" if value >= 99.95 else f"{value:.1f}" if value >= 9.995 else f"{value:.2f}"


def searched(n: int, model: Model = MODEL, starts: int = 40) -> Array:
    """The joint D-optimal program of so many positions: angles in whole degrees, rates in whole degrees per second."""
    found = design(Problem(STAND, model, D(), n), Gradient(starts=starts), certificate=False).program
    return STAND.axes.read(np.round(STAND.axes.written(found)))


def plain(settings: Array) -> Array:
    """The same for people: angles in steps of 5 degrees, full rates or none."""
    degrees = STAND.axes.written(settings)
    angles = 5.0 * np.round(degrees[:, :2] / 5.0) % 360.0
    full = np.where(np.abs(degrees[:, 2:]) < SLOW_DEG_S, 0.0, 100.0 * np.sign(degrees[:, 2:]))
    table = np.concatenate([angles, full], axis=1)
    return STAND.axes.read(table[np.lexsort(table.T[::-1])])


class Programs:
    """All the programs of the study, each designed when it is asked for and kept."""

    @cached_property
    def joint(self) -> dict[int, Accuracy]:
        """The joint programs of as many positions as the recipes have."""
        return {n: Accuracy(f"joint_{n}", searched(n)) for n in SIZES}

    @cached_property
    def by_size(self) -> dict[int, Accuracy]:
        """The same with those of further numbers of positions, in their order."""
        further = {n: Accuracy(f"joint_{n}", searched(n)) for n in FURTHER}
        return dict(sorted({**self.joint, **further}.items()))

    @cached_property
    def recipes(self) -> dict[str, Accuracy]:
        """The recipes."""
        return {name: Accuracy(name, recipe.settings(STAND)) for name, recipe in RECIPES.items()}

    @property
    def pairs(self) -> list[tuple[Accuracy, Accuracy]]:
        """Each recipe beside the joint program of as many positions."""
        return [(recipe, self.joint[recipe.n]) for recipe in self.recipes.values()]

    @property
    def all(self) -> list[Program]:
        """Recipes and joint programs with their names, to be simulated."""
        each = [*self.recipes.values(), *self.joint.values()]
        return [program_of(one.name, one.settings, STAND) for one in each]

    @cached_property
    def least(self) -> float:
        """The loss that no program of a position beats, by computation: that of n positions is log n p less."""
        return _least(MODEL)

    def efficiency(self, settings: Array) -> float:
        """D-efficiency of a program against that."""
        return _efficiency(settings, MODEL, self.least)

    @cached_property
    def without_arms(self) -> list[tuple[str, int, float]]:
        """Programs with their numbers of positions and efficiencies where no lever arms are estimated."""
        model, least = BARE, _least(BARE)
        own = Accuracy("joint 24, designed without arms", searched(24, model))
        programs = [*self.recipes.values(), self.joint[24], own]
        return [(one.name, one.n, _efficiency(one.settings, model, least)) for one in programs]

    def kinds(self, settings: Array) -> tuple[int, int, int, int]:
        """Positions at rest or nearly, turning about the outer axis alone, the inner one alone, and both."""
        fast = np.abs(STAND.axes.written(settings)[:, 2:]) >= SLOW_DEG_S
        outer, inner = fast.T
        counts = (~outer & ~inner, outer & ~inner, ~outer & inner, outer & inner)
        rest, first, second, both = (int(one.sum()) for one in counts)
        return rest, first, second, both


def _least(model: Model, n: int = 24) -> float:
    return bound(Problem(STAND, model, D(), n)).loss + len(model.parameters) * math.log(n)


def _efficiency(settings: Array, model: Model, least: float) -> float:
    """(det M / det M of the bound)^(1/p); 0 of a singular program."""
    p, n = len(model.parameters), len(settings)
    loss = float(Problem(STAND, model, D(), n).loss(settings))
    return math.exp((least - p * math.log(n) - loss) / p) if math.isfinite(loss) else 0.0


def needed_without_arms(wanted: Mapping[str, float]) -> dict[str, int]:
    """Positions for given standard errors, in the units of `GROUPS`, of a program that has no arms to show."""
    information = BARE.information(STAND.stimulus(searched(24, BARE)))
    ratios = {
        group: GROUPS[group].factor * float(information.theta(group)) / wanted[group] for group in information.groups
    }
    return {group: math.ceil(24 * ratio**2 - 1e-9) for group, ratio in ratios.items()}


def targeted(wanted: Mapping[str, float]) -> int:
    """The fewest positions of a program that is designed for these standard errors."""
    target = {group: value / GROUPS[group].factor for group, value in wanted.items()}
    problem = Problem(STAND, MODEL, D(), 24)
    return design(problem, Gradient(starts=8), target=target, certificate=False).problem.n


def save(accuracies: Sequence[Accuracy], directory: Path) -> None:
    """Each program as a file that acalx reads."""
    directory.mkdir(parents=True, exist_ok=True)
    for one in accuracies:
        with (directory / f"{one.name}.csv").open("w", encoding="utf-8", newline="") as file:
            rows: Any = csv.writer(file, lineterminator="\n")
            rows.writerow(["position", *STAND.axes.columns])
            degrees = np.round(STAND.axes.written(one.settings)) + 0.0
            rows.writerows([k, *(int(value) for value in row)] for k, row in enumerate(degrees, 1))
