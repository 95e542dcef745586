"""The interface of a scheme, and what it gives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError, Option
from acalx.models import Composite, Joined, Model, parts_of
from acalx.numerics.arrays import Array
from acalx.optimizers import Optimizer
from acalx.problem import Problem
from acalx.search.account import Watch
from acalx.search.result import Found, Result, Solution, Status

__all__ = ["Composed", "Part", "Scheme", "joined_result", "kinds_of", "part_problem", "search_part"]


@dataclass(frozen=True, eq=False)
class Part:
    """What was designed for one kind of sensors of a model.

    Parameters
    ----------
    name : str
        Of the kind, e.g. ``gyros``.
    settings : array (k, d), in rad
        Positions that it brings to the program.
    dropped : int
        How many of its positions are left out, since others of the program serve it as well.
    result : Result or None
        Of the search; None where nothing had to be searched for.
    """

    name: str
    settings: Array
    dropped: int
    result: Result | None


@dataclass(frozen=True, eq=False)
class Composed:
    """A program for a whole model.

    Parameters
    ----------
    result : Result or Front
        For the whole problem; the program may have fewer positions than its n.
    parts : tuple of Part
        What was designed separately, in the order of the program; empty where nothing was.
    """

    result: Found
    parts: tuple[Part, ...] = ()


class Scheme(ABC):
    """How an optimizer is used to design one program for all the sensors of a model.

    Concrete schemes are frozen dataclasses of options.
    """

    @property
    def option(self) -> Option:
        """The option by which a user asks for the scheme, for messages."""
        name = type(self).__name__
        return Option("scheme", name.lower(), f"{name}()")

    @abstractmethod
    def smallest_n(self, problem: Problem) -> int:
        """The fewest positions, with those that are fixed, that the scheme can do with."""

    @abstractmethod
    def solve(
        self, problem: Problem, optimizer: Optimizer[Any], rng: np.random.Generator, watch: Watch | None = None
    ) -> Composed:
        """Design a program of at most n positions.

        Parameters
        ----------
        problem : Problem
        optimizer : Optimizer
        rng : numpy Generator
        watch : callable, optional
            As of `Optimizer.solve`.

        Raises
        ------
        CompatibilityError
            The parts do not fit together; before any work.
        NoProgramError
            No program of the problem can estimate all parameters.
        """


def kinds_of(scheme: Scheme, problem: Problem) -> dict[str, Model]:
    """The model taken apart by kinds of sensors, in the order of its parameters.

    Raises
    ------
    CompatibilityError
        There is one kind only, or several objectives, whose programs can't be joined.
    """
    name, joint = scheme.option, Option("scheme", "joint", "Joint()")
    found: dict[str, list[Model]] = {}
    for model in parts_of(problem.model):
        found.setdefault(model.kind, []).append(model)
    shared = problem.model.shared if isinstance(problem.model, Composite) else ()
    if len(found) == 1 and shared:
        raise CompatibilityError(
            "{name} designs for each kind of sensors separately, but they share {shared}; use {joint}",
            name=name,
            shared=", ".join(shared),
            joint=joint,
        )
    if len(found) == 1:
        raise CompatibilityError(
            "{name} designs for each kind of sensors separately, but model {model} has one kind only; use {joint}, "
            "or a model of several, such as {platform} or {joined}",
            name=name,
            model=problem.model.called,
            joint=joint,
            platform=Option("model", "platform", "Platform()"),
            joined=Option("model", "joined", "Joined([...])"),
        )
    if len(problem.singles) > 1:
        raise CompatibilityError(
            "{name} takes one criterion; for several objectives use {joint}", name=name, joint=joint
        )
    return {kind: models[0] if len(models) == 1 else Joined(models) for kind, models in found.items()}


def part_problem(scheme: Scheme, problem: Problem, name: str, model: Model, n: int, fixed: Array | None) -> Problem:
    """The problem of one part; CompatibilityError where the criterion doesn't fit it alone."""
    try:
        problem.criterion.check(model.parameters)
    except ArgumentError as error:
        raise CompatibilityError(
            "{scheme} designs for the {name} alone, which the criterion does not fit: {why}; or use {joint}",
            scheme=scheme.option,
            name=name,
            why=error,
            joint=Option("scheme", "joint", "Joint()"),
        ) from error
    return replace(problem, model=model, n=n, fixed=fixed)


def search_part(
    optimizer: Optimizer[Result], problem: Problem, rng: np.random.Generator, watch: Watch | None, *, last: bool
) -> Result:
    """The search for one part; an interrupt ends all, since there is no program before the last part."""
    result = optimizer.solve(problem, rng, watch)
    if result.status == "interrupted" and not last:
        raise KeyboardInterrupt
    return result


def joined_result(problem: Problem, settings: Array, message: str, parts: Sequence[Part]) -> Result:
    """The result of a program (k, d) that was put together from parts."""
    results = [part.result for part in parts if part.result is not None]
    statuses: list[Status] = [result.status for result in results]
    status: Status = next((bad for bad in ("interrupted", "limit") if bad in statuses), "ok")
    evaluations, seconds = sum(r.evaluations for r in results), sum(r.seconds for r in results)
    loss = float(problem.loss(settings))
    history = [(evaluations, seconds, loss)]
    return Result(status, message, evaluations, seconds, history, (Solution(settings, loss),))
