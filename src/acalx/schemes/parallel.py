"""A program for each kind of sensors, joined."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.optimizers import Optimizer
from acalx.options import keep
from acalx.problem import Problem
from acalx.schemes.base import Composed, Part, Scheme, joined_result, kinds_of, part_problem, search_part
from acalx.schemes.division import check_positions, divide
from acalx.search.account import Watch

__all__ = ["Parallel"]


@final
@dataclass(frozen=True)
class Parallel(Scheme):
    """A program for each kind of sensors by itself; then they are joined.

    A position of one program is dropped where its sensors feel it as they do a position of
    another: that one serves both. An accelerometer doesn't feel the Earth's rate, so that any
    attitude with the same vertical serves it. Of programs that are equally good for a kind the
    one is taken of which most can be dropped. The joined program has n positions or fewer.

    Parameters
    ----------
    positions : mapping of str to int, optional
        How many positions the program of a kind has before they are joined, at most, as in
        ``{gyros: 16, accels: 16}`` with n=32; n is divided over the others in proportion to the
        fewest that each of them needs.

    Raises
    ------
    ArgumentError
        Numbers that are not whole; at `solve`, that don't add up to n.
    CompatibilityError
        At `solve`: a model with one kind of sensors, or a criterion that does not fit each.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588.
    """

    positions: Mapping[str, int] | None = None

    def __post_init__(self) -> None:
        check_positions(self.positions)
        keep(self, "positions")

    def smallest_n(self, problem: Problem) -> int:
        """The fewest positions: what each kind needs alone, or is given, added up with those that are fixed."""
        given = self.positions or {}
        return problem.held + sum({**_least(problem, kinds_of(self, problem)), **given}.values())

    def solve(
        self, problem: Problem, optimizer: Optimizer[Any], rng: np.random.Generator, watch: Watch | None = None
    ) -> Composed:
        """Design a program for each kind alone, leave out positions that others serve, join the rest."""
        kinds = kinds_of(self, problem)
        weights = {name: model.smallest_n for name, model in kinds.items()}
        numbers = divide(problem.n, problem.held, _least(problem, kinds), weights, self.positions or {})
        problems = {
            name: part_problem(self, problem, name, model, problem.held + numbers[name], problem.fixed)
            for name, model in kinds.items()
        }
        parts: list[Part] = []
        for name, single in problems.items():
            result = search_part(optimizer, single, rng, watch, last=len(parts) == len(problems) - 1)
            before = np.concatenate([part.settings for part in parts]) if parts else np.empty((0, problem.d))
            programs = [solution.settings[problem.held :] for solution in result.solutions]
            served = [_served(single, program, before) for program in programs]
            best = int(np.argmax([each.sum() for each in served]))  # of equally good ones
            parts.append(Part(name, programs[best][~served[best]], int(served[best].sum()), result))
        settings = np.concatenate([part.settings for part in parts])
        if problem.fixed is not None:
            settings = np.concatenate([problem.fixed, settings])
        told = "; ".join(_told(part) for part in parts)
        return Composed(joined_result(problem, settings, f"parallel: {told}", parts), tuple(parts))


def _least(problem: Problem, kinds: Mapping[str, Model]) -> dict[str, int]:
    """The fewest positions to choose for each kind alone."""
    return {name: max(1, model.smallest_n - problem.held) for name, model in kinds.items()}


def _told(part: Part) -> str:
    assert part.result is not None
    dropped = f" and {part.dropped} that others serve" if part.dropped else ""
    return f"{part.name}: {len(part.settings)} positions{dropped} ({part.result.message})"


def _served(problem: Problem, settings: Array, others: Array) -> np.ndarray:
    """Which positions (k,) others (l, d) serve as well: each of them one, or all where none may repeat."""
    alike = problem.restrictions.alike(settings, others)
    if not problem.replicates:
        return np.asarray(alike.any(axis=1))
    served = np.zeros(len(settings), dtype=bool)
    for k in range(len(settings)):
        if alike[k].any():
            served[k] = True
            alike[:, alike[k].argmax()] = False
    return served
