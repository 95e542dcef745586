"""Several criteria at once, none of them exchanged for another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

from acalx.criteria.base import Criterion
from acalx.errors import ArgumentError, Option
from acalx.quantities.parameter import Parameter

__all__ = ["Objectives"]


@final
@dataclass(frozen=True)
class Objectives:
    """Several criteria that stay apart: what is sought is the front of their best compromises.

    A product fixes beforehand what a gain in one criterion is worth in another. Objectives
    leave that open: the answer is all the programs of which none is worse than another in
    every criterion. They are no criterion: there is no single loss, and optimizers that need one refuse them.

    Parameters
    ----------
    criteria : sequence of Criterion
        Two or more, all different.
    names : sequence of str, optional
        What to call them in tables and files; their labels where none are given.

    Raises
    ------
    ArgumentError
        Fewer than two criteria, one that is there twice, names that don't match.
    """

    criteria: Sequence[Criterion]
    names: Sequence[str] | None = None

    def __post_init__(self) -> None:
        criteria = tuple(self.criteria) if isinstance(self.criteria, Iterable) else ()
        if not all(isinstance(criterion, Criterion) for criterion in criteria):
            raise ArgumentError.of("criteria", self.criteria, "objectives are a list of criteria, such as D() and A()")
        names = tuple(criterion.label for criterion in criteria) if self.names is None else tuple(self.names)
        if len(names) != len(criteria):
            raise ArgumentError.of("names", list(names), f"{len(criteria)} objectives take as many names")
        if len(criteria) < 2:
            raise ArgumentError(
                "{given}: give two or more, as in {two}; for one use {single}",
                given=Option("objectives", list(names)),
                two=Option("objectives", ["d", "a"], "[D(), A()]"),
                single=Option("criterion", "NAME", "D()"),
            )
        for k, (name, criterion) in enumerate(zip(names, criteria, strict=True)):
            if name in names[:k] or criterion in criteria[:k]:
                other = names[criteria.index(criterion)] if name not in names[:k] else name
                raise ArgumentError(f"objectives: {name} is there twice, the other time as {other}; once is right")
        object.__setattr__(self, "criteria", criteria)
        object.__setattr__(self, "names", names)

    @property
    def labels(self) -> tuple[str, ...]:
        """What the objectives are called in tables and files, in their order."""
        assert self.names is not None  # set at construction
        return tuple(self.names)

    @property
    def label(self) -> str:
        """All the names in one line."""
        return ", ".join(self.labels)

    def check(self, parameters: tuple[Parameter, ...]) -> None:
        """Raise ArgumentError where any of the criteria does not fit the model."""
        for criterion in self.criteria:
            criterion.check(parameters)
