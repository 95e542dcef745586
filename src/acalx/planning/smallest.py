"""The smallest number of positions with which the standard errors are as small as wanted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from acalx.bounds import bound
from acalx.criteria import Target
from acalx.errors import ArgumentError, NoProgramError, Option
from acalx.options import is_whole
from acalx.problem import Problem
from acalx.quantities.magnitude import from_log
from acalx.schemes import Composed, Scheme
from acalx.search.regularity import no_regular_program

__all__ = ["Smallest", "Trial", "smallest_program"]

# A program meets its target where no standard error is above it by more than this share.
_SLACK = 1e-6
# So many numbers below the smallest that was found are tried as well: a search that goes by
# another criterion, or that ends early, does not get better with every further position.
_BELOW = 2
# From so many random positions it is seen whether all parameters show at all.
_MANY = 500


@dataclass(frozen=True)
class Trial:
    """What a number of positions reached.

    Parameters
    ----------
    n : int
        Positions that were asked for.
    positions : int
        Of the program, which may have fewer; 0 where none can estimate all the parameters.
    standard_errors : dict
        Largest one of each group of the target.
    share : float
        Largest standard error over its target; 1 or less where the target is met.
    """

    n: int
    positions: int
    standard_errors: dict[str, float]
    share: float

    @property
    def met(self) -> bool:
        """Whether all standard errors of the best program of so many positions are within the target."""
        return self.share <= 1.0 + _SLACK


@dataclass(frozen=True, eq=False)
class Smallest:
    """The smallest program that meets a target.

    Parameters
    ----------
    problem : Problem
        With its number of positions.
    composed : Composed
    trials : tuple of Trial
        All that was tried, by number of positions.
    bound : int or None
        No program of fewer positions can meet the target; None where nothing bounds it.
    method : str
        How that was proved, or why there is no bound.
    """

    problem: Problem
    composed: Composed
    trials: tuple[Trial, ...]
    bound: int | None
    method: str

    @property
    def n(self) -> int:
        """The smallest number of positions that was found to meet the target."""
        return len(self.composed.result.program)

    @property
    def recorded(self) -> dict[str, Any]:
        """What result.json says of it."""
        trials = [{**asdict(trial), "met": trial.met} for trial in self.trials]
        return {"least_n": self.bound, "least_n_method": self.method, "tried": trials}

    def __str__(self) -> str:
        tried = ", ".join(f"{trial.n} ({trial.share:.4f})" for trial in self.trials)
        if self.bound is None:
            proved = f"not bounded from below: {self.method}"
        elif self.bound == self.n:
            proved = "and no program of fewer can meet it"
        else:
            proved = f"no program of fewer than {self.bound} can meet it"
        return f"{self.n} positions meet the target, {proved}; tried, with the largest share of it: {tried}"


def smallest_program(
    problem: Problem, target: Target, scheme: Scheme, solve: Callable[[Problem], Composed], most: int = 500
) -> Smallest:
    """Smallest program that meets a target.

    The numbers between the first one that could meet it and one that does are halved, then the
    next ones below are tried too.

    Parameters
    ----------
    problem : Problem
        With any number of positions.
    target : Target
    scheme : Scheme
        It says how many positions it takes at least.
    solve : callable
        Gives a program for a problem, by that scheme.
    most : int
        Largest number of positions.

    Raises
    ------
    ArgumentError
        A group that the model does not have; a target that needs more than `most` positions.
    NoProgramError
        No program can estimate all the parameters.
    """
    target.check(problem.parameters)
    least = scheme.smallest_n(problem)
    if not is_whole(most) or most < least:
        raise ArgumentError.of(
            "n_most", most, f"must be a whole number, {least} or more, which the model and scheme need"
        )
    problem = replace(problem, n=least)
    bound, method = _bound(problem, target)
    first = max(least, bound or 0)
    if first > most:
        raise ArgumentError(
            f"target: it takes {first:,} positions or more to meet it, more than n_most={most}; "
            "give larger standard errors, or a larger n_most"
        )
    search = _Search(problem, target, solve)
    n, failed = search.up(first, most)
    n = search.halve(failed, n)
    n = search.below(first, n)
    trials = tuple(trial for _, trial in sorted(search.trials.items()))
    return Smallest(replace(problem, n=n), search.designs[n], trials, bound, method)


class _Search:
    """Numbers that were tried, and what they gave."""

    def __init__(self, problem: Problem, target: Target, solve: Callable[[Problem], Composed]) -> None:
        self.problem, self.target, self.solve = problem, target, solve
        self.trials: dict[int, Trial] = {}
        self.designs: dict[int, Composed] = {}

    def trial(self, n: int) -> Trial:
        if n not in self.trials:
            problem = replace(self.problem, n=n)
            try:
                composed = self.solve(problem)
            except NoProgramError:  # too few, since with many all the parameters show
                self.trials[n] = Trial(n, 0, dict.fromkeys(self.target.wanted, math.inf), math.inf)
                return self.trials[n]
            if composed.result.status == "interrupted":
                raise KeyboardInterrupt
            settings = composed.result.program
            information = problem.information(settings)
            errors = {group: float(information.theta(group)) for group in self.target.wanted}
            share = max(errors[group] / wanted for group, wanted in self.target.wanted.items())
            self.designs[n], self.trials[n] = composed, Trial(n, len(settings), errors, share)
        return self.trials[n]

    def up(self, n: int, most: int) -> tuple[int, int]:
        """A number that meets the target, and the largest one below that does not."""
        failed = n - 1
        while not (trial := self.trial(n)).met:
            if n == most:
                best = min(self.trials.values(), key=lambda trial: trial.share)
                raise ArgumentError(
                    "target: not met with {most} positions, where the largest standard error is {share} times what "
                    "is wanted; give larger standard errors, a larger n_most, or a criterion that goes for them, "
                    "as {criterion} does",
                    most=Option("n_most", most),
                    share=f"{best.share:.4g}",
                    criterion=Option("criterion", "target", f"Target({dict(self.target.wanted)})"),
                )
            # variances fall as 1 / n where a search is as good with every n
            wanted = n * min(2.0, trial.share**2 * (1 - _SLACK))
            failed, n = n, min(most, max(n + 1, math.ceil(wanted)))
        return n, failed

    def halve(self, failed: int, n: int) -> int:
        while n - failed > 1:
            middle = (failed + n) // 2
            if self.trial(middle).met:
                n = middle
            else:
                failed = middle
        return n

    def below(self, first: int, n: int) -> int:
        """The smallest that meets the target when the next numbers below are tried too."""
        k = n - 1
        while k >= max(first, n - 1 - _BELOW):
            if self.trial(k).met:
                n = k
            k -= 1
        return n


def _bound(problem: Problem, target: Target) -> tuple[int | None, str]:
    """The fewest positions that could meet the target, from the bound on the worst variance."""
    if problem.based:
        return None, "positions are fixed" if problem.held else "a prior is there before any position"
    many = replace(problem, n=max(problem.n, _MANY), replicates=True)
    if many.information(many.restrictions.random(np.random.default_rng(0), 1)[0]).singular:
        raise no_regular_program(problem)
    found = bound(problem.with_criterion(target))
    if not found.proved:
        return None, found.method
    # variances of the best measure are the bound at n times n, and fall as 1 / n
    return math.ceil(problem.n * from_log(found.loss) * (1 - 2 * _SLACK)), found.method
