"""A program for one kind of sensors, then more positions for the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from acalx.errors import AcalxError, ArgumentError
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.optimizers import Optimizer
from acalx.options import keep
from acalx.problem import Problem
from acalx.schemes.base import Composed, Part, Scheme, joined_result, kinds_of, part_problem, search_part
from acalx.schemes.division import check_positions, divide
from acalx.search.account import Watch

__all__ = ["Serial"]


@final
@dataclass(frozen=True)
class Serial(Scheme):
    """A program for one kind of sensors, which then stays; the rest is chosen for the next kind.

    Each kind is designed for with all that the positions before show of it, so that it adds
    only what is missing. With ``optimizer=traversal`` and its ``extends=true`` the sequence of the
    first kind goes on by its own rule.

    Parameters
    ----------
    order : sequence of str, optional
        The kinds, the first one first, as in ``[accels, gyros]``; as in the model where it is
        left out.
    positions : mapping of str to int, optional
        How many positions a kind adds at most; of the kinds after the first it may be 0, where
        those before serve it too. n is divided over the others in proportion to the fewest that
        each needs alone.

    Raises
    ------
    ArgumentError
        An order of other kinds than the model's; numbers that are not whole; at `solve`, numbers
        that don't add up to n.
    CompatibilityError
        At `solve`: a model with one kind of sensors, or a criterion that does not fit each.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588.
    """

    order: Sequence[str] | None = None
    positions: Mapping[str, int] | None = None

    def __post_init__(self) -> None:
        check_positions(self.positions)
        if self.order is not None and (isinstance(self.order, str) or not isinstance(self.order, Sequence)):
            raise ArgumentError.of("scheme.order", self.order, "give a list of kinds", ["accels", "gyros"])
        keep(self, "order", "positions")

    def smallest_n(self, problem: Problem) -> int:
        """What the first kind needs alone, and one for each further kind."""
        kinds = self._ordered(problem)
        given = self.positions or {}
        chosen = problem.held + sum({**_least(problem, kinds, given), **given}.values())
        return max(chosen, problem.model.smallest_n)

    def solve(
        self, problem: Problem, optimizer: Optimizer[Any], rng: np.random.Generator, watch: Watch | None = None
    ) -> Composed:
        """Design for each kind after the other, around the positions that are there already."""
        kinds = self._ordered(problem)
        weights, given = {name: model.smallest_n for name, model in kinds.items()}, self.positions or {}
        numbers = divide(problem.n, problem.held, _least(problem, kinds, given), weights, given)
        for name, model in kinds.items():  # refused before any work
            part_problem(self, problem, name, model, problem.n, problem.fixed)
        parts: list[Part] = []
        settings = problem.fixed
        for name, model in kinds.items():
            held = 0 if settings is None else len(settings)
            if held + numbers[name] < weights[name]:
                rule = (
                    f"with {held + numbers[name]} positions in all the {name} can't be estimated, they need "
                    f"{weights[name]}; give a larger n, or other positions of the scheme"
                )
                raise ArgumentError.of("n", problem.n, rule)
            if numbers[name]:
                single = part_problem(self, problem, name, model, held + numbers[name], settings)
                result = search_part(optimizer, single, rng, watch, last=len(parts) == len(kinds) - 1)
                settings = result.best.settings
                parts.append(Part(name, settings[held:], 0, result))
            else:
                assert settings is not None  # the first kind has positions
                _check_served(problem, name, model, settings)
                parts.append(Part(name, settings[:0], 0, None))
        assert settings is not None
        told = "; ".join(_told(part) for part in parts)
        return Composed(joined_result(problem, settings, f"serial: {told}", parts), tuple(parts))

    def _ordered(self, problem: Problem) -> dict[str, Model]:
        """The kinds, the first one first."""
        kinds = kinds_of(self, problem)
        order = list(kinds) if self.order is None else list(self.order)
        if sorted(order) != sorted(kinds):
            raise ArgumentError.of("scheme.order", order, f"give each kind of the model once: {', '.join(kinds)}")
        return {name: kinds[name] for name in order}


def _least(problem: Problem, kinds: Mapping[str, Model], given: Mapping[str, int]) -> dict[str, int]:
    """The fewest positions that each kind adds: those given may be 0 after the first, others are one or more."""
    first, *others = kinds
    return {first: max(1, kinds[first].smallest_n - problem.held), **{name: int(name not in given) for name in others}}


def _check_served(problem: Problem, name: str, model: Model, settings: Array) -> None:
    """Raise AcalxError where the positions that are there do not show all the parameters of a kind."""
    unseen = replace(problem.response, model=model).information(settings).inestimable()
    if unseen:
        raise AcalxError(
            f"positions: {name}=0, but the {len(settings)} positions before can't see {'; '.join(unseen)}; "
            f"give the {name} some of their own"
        )


def _told(part: Part) -> str:
    if part.result is None:
        return f"{part.name}: no more, the positions before serve them"
    return f"{part.name}: {len(part.settings)} positions ({part.result.message})"
