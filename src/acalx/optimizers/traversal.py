"""All regular sequences of positions, for every number of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError, Option
from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.options import is_number, keep, require_count, require_switch
from acalx.problem import Problem
from acalx.programs.sequences import RULES
from acalx.search.account import Account
from acalx.search.ending import result_of
from acalx.search.regular import RegularSequences, per_measurement
from acalx.search.result import Result, Survey

__all__ = ["Traversal"]

_MOST_SEQUENCES = 2_000_000
# Losses that differ by less are the same.
_AGREEMENT = 1e-9
# Information of so many positions at a time, in bytes.
_CHUNK_BYTES = 2**25


@final
@dataclass(frozen=True)
class Traversal(Optimizer[Result]):
    """Looks at every regular sequence for every number N of positions up to the problem's n.

    A sequence is given by start angles, step angles and a rule of change. Programs are compared
    by the criterion of the information per measurement, H'H / N, so that numbers of positions
    compare; the best program may therefore have fewer positions than n. Of equally good ones
    the shortest counts. The defaults are the 144 sequences of the paper.

    Parameters
    ----------
    rule : str
        ``turn``: the angles step in turn, the outer one first. ``both``: both step each time.
        ``raster``: the inner one goes through a whole turn before the outer one steps. The
        paper's own rule is not known; with ``both`` and its steps there are no more than 8
        different attitudes, too few for its gyros.
    starts_deg : three floats, degrees
        Start angles: from, up to and without, in steps of.
    independent_starts : bool
        Whether the angles start independently of each other, instead of all alike.
    steps_deg : sequence of float, degrees
        Step angles; each angle takes each of them.
    n_from : int, optional
        Least number of positions; that which the model needs where it is left out.
    shorter : bool
        Whether programs of fewer positions than the problem's n are looked at too.
    extends : bool
        Where positions are fixed, they come before every sequence. With `extends` they are the
        beginning of some of the sequences instead, and these are continued.

    Raises
    ------
    ArgumentError
        An unknown rule, starts or steps that are no numbers, more than two million sequences.
    CompatibilityError
        At `solve`: a stand with settings that are no angles.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588.
    """

    by_position: ClassVar[bool] = True
    rule: str = "turn"
    starts_deg: Sequence[float] = (0.0, 180.0, 5.0)
    independent_starts: bool = False
    steps_deg: Sequence[float] = (45.0, 90.0)
    n_from: int | None = None
    shorter: bool = True
    extends: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.rule, str) or self.rule not in RULES:
            raise ArgumentError.of("rule", self.rule, f"there is no such rule; the rules are {', '.join(RULES)}")
        for name in ("independent_starts", "shorter", "extends"):
            require_switch(name, getattr(self, name))
        starts, steps = _numbers("starts_deg", self.starts_deg), _numbers("steps_deg", self.steps_deg)
        if len(starts) != 3 or not (starts[0] < starts[1] and starts[2] > 0):
            raise ArgumentError.of("starts_deg", list(starts), "give from, up to and step", [0, 180, 5])
        if 0.0 in steps or len(set(steps)) < len(steps):
            raise ArgumentError.of("steps_deg", list(steps), "give one or more different steps, none of them 0")
        if self.n_from is not None:
            require_count("n_from", self.n_from)
            if not self.shorter:
                raise ArgumentError(
                    "{n_from} with {shorter}: one or the other",
                    n_from=Option("n_from", self.n_from),
                    shorter=Option("shorter", False),
                )
        keep(self, "starts_deg", "steps_deg")

    @property
    def _regular(self) -> RegularSequences:
        return RegularSequences(self.rule, self.starts_deg, self.steps_deg, self.independent_starts, self.extends)

    def exact(self) -> Traversal:
        """The same sequences with exactly n positions, no shorter ones."""
        return replace(self, n_from=None, shorter=False)

    def check(self, problem: Problem) -> None:
        """Refuses settings that are no angles, and limits of N that can't be."""
        for setting in problem.stand.settings:
            if setting.unit.turn is None:
                raise CompatibilityError(
                    "optimizer Traversal steps angles, but stand {stand} also sets {setting}; use {instead}",
                    stand=type(problem.stand).__name__,
                    setting=setting.column,
                    instead=Option("optimizer", "de", "DifferentialEvolution()"),
                )
        least = problem.model.smallest_n
        if self.n_from is not None and not max(least, problem.held + 1) <= self.n_from <= problem.n:
            why = f"which the {len(problem.parameters)} parameters of {problem.model.called} need"
            if problem.held >= least:
                least, why = problem.held + 1, f"one more than the {problem.held} fixed positions"
            raise ArgumentError.of("optimizer.n_from", self.n_from, f"must be from {least}, {why}, to n={problem.n}")
        count = self._regular.count(problem.d)
        if count > _MOST_SEQUENCES:
            raise ArgumentError(f"{count:,} sequences are too many; {_MOST_SEQUENCES:,} is the most: take wider steps")

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Every sequence, its information summed up position by position."""
        regular = self._regular
        sequences = regular.sequences(problem)
        least = self.n_from or max(problem.model.smallest_n, problem.held + 1)
        numbers = np.arange(least if self.shorter else problem.n, problem.n + 1)
        losses = np.full((len(sequences), len(numbers)), np.inf)
        names = [
            *(f"start_{c}" for c in problem.stand.axes.columns),
            *(f"step_{c}" for c in problem.stand.axes.columns),
        ]
        survey = Survey(tuple(names), sequences, numbers, losses)
        size = max(1, _CHUNK_BYTES // (problem.n * 8 * len(problem.parameters) ** 2))
        try:
            for first in range(0, len(sequences), size):
                settings = regular.settings(problem, survey.sequences[first : first + size])
                losses[first : first + size] = per_measurement(problem, settings, numbers)
                account.evaluations += len(settings) * len(numbers)
                account.fraction = first / len(sequences)
                account.tick()
        except KeyboardInterrupt:
            if np.isfinite(losses).any():
                self._keep(problem, survey, account)  # the best so far
            raise
        if not np.isfinite(losses).any():
            raise regular.nothing(problem, survey)
        programs = self._keep(problem, survey, account)
        return result_of(
            problem,
            account,
            programs,
            problem.loss(programs),
            status="ok",
            message=regular.told(survey),
            agreement=_AGREEMENT,
            sort=False,
            survey=survey,
        )

    def _keep(self, problem: Problem, survey: Survey, account: Account) -> Array:
        """The best programs (k, N, d), all of the same N; the account is told of them."""
        _, column = survey.best
        near = survey.losses[:, column] <= survey.losses[:, column].min() + _AGREEMENT
        programs = self._regular.settings(problem, survey.sequences[near])[:, : survey.numbers[column]]
        account.keep(programs, problem.loss(programs))
        return programs


def _numbers(name: str, values: object) -> tuple[float, ...]:
    if isinstance(values, str) or not isinstance(values, Sequence) or not values:
        raise ArgumentError.of(name, values, "give a list of degrees")
    for value in values:
        if not is_number(value):
            raise ArgumentError(f"{name}: {value} is not a finite number of degrees")
    return tuple(float(value) for value in values)
