"""Regular sequences of positions: start angles, step angles and a rule of change.

Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acalx.criteria.answers import loss_of
from acalx.errors import AcalxError, NoProgramError, Option
from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.programs.sequences import RULES, regular_sequences
from acalx.quantities.information import Information
from acalx.search.result import Survey

__all__ = ["RegularSequences", "per_measurement"]

_TURN = 360.0
_SAME_ANGLE = 1e-6
# So many sequences are looked at to explain why none is regular.
_EXPLAINED = 500


@dataclass(frozen=True)
class RegularSequences:
    """All the sequences of a rule; options as those of `acalx.optimizers.Traversal`.

    Parameters
    ----------
    rule : str
        How angles change, see `acalx.programs.sequences`.
    starts_deg : three floats, degrees
        Start angles: from, up to and without, in steps of.
    steps_deg : sequence of float, degrees
        Each angle takes each of them.
    independent_starts : bool
        Whether the angles start independently of each other, instead of all alike.
    extends : bool
        Whether fixed positions are the beginning of the sequences, instead of before them.
    """

    rule: str
    starts_deg: Sequence[float]
    steps_deg: Sequence[float]
    independent_starts: bool
    extends: bool

    def count(self, d: int) -> int:
        """How many sequences there are for d angles."""
        return int(len(self.steps_deg) ** d * len(self._starts()) ** (d if self.independent_starts else 1))

    def _starts(self) -> Array:
        lower, upper, step = self.starts_deg
        return np.asarray(np.arange(lower, upper * (1 - 1e-12), step), dtype=float)

    def sequences(self, problem: Problem) -> Array:
        """Starts and steps of all sequences, (s, 2 d) in degrees; of those that begin as they must."""
        starts, d = self._starts(), problem.d
        if self.independent_starts:
            begin = np.array(list(itertools.product(starts, repeat=d)))
        else:
            begin = np.repeat(starts[:, None], d, axis=1)
        step = np.array(list(itertools.product(self.steps_deg, repeat=d)), dtype=float)
        sequences = np.concatenate([np.repeat(begin, len(step), axis=0), np.tile(step, (len(begin), 1))], axis=1)
        if problem.fixed is None or not self.extends:
            return sequences
        apart = self._regular(problem, sequences, problem.held) - problem.stand.axes.wrap(problem.fixed)
        begun = (np.abs(np.sin(0.5 * apart)) < _SAME_ANGLE).all(axis=(1, 2))
        if not begun.any():
            raise AcalxError(
                "none of the {count} sequences by {rule} begins with the {held} fixed positions, so that none can "
                "be continued; leave {extends} out, or fix the beginning of a sequence",
                count=len(sequences),
                rule=Option("rule", self.rule),
                held=problem.held,
                extends=Option("extends", True),
            )
        return sequences[begun]

    def settings(self, problem: Problem, sequences: Array) -> Array:
        """Programs (s, n, d) in rad of sequences (s, 2 d) in degrees, the fixed positions first."""
        if problem.fixed is None or self.extends:
            return self._regular(problem, sequences, problem.n)
        return problem.restrictions.completed(self._regular(problem, sequences, problem.n - problem.held))

    def _regular(self, problem: Problem, sequences: Array, n: int) -> Array:
        starts, steps = sequences[:, : problem.d], sequences[:, problem.d :]
        return problem.stand.axes.wrap(np.radians(regular_sequences(self.rule, starts, steps, n)))

    def told(self, survey: Survey) -> str:
        """What a survey of them found, in words."""
        row, column = survey.best
        of_it = ", ".join(f"{name}={value:g}" for name, value in zip(survey.names, survey.sequences[row], strict=True))
        regular = int(np.isfinite(survey.losses).any(axis=1).sum())
        least, most = survey.numbers[0], survey.numbers[-1]
        return (
            f"of {len(survey.sequences)} sequences by rule={self.rule} with {least} to {most} positions each "
            f"({regular} can estimate all the parameters), the best per measurement has "
            f"{survey.numbers[column]} positions: {of_it}"
        )

    def nothing(self, problem: Problem, survey: Survey) -> NoProgramError:
        """Why no sequence can estimate all the parameters, and what to change."""
        head = (
            f"no regular sequence of up to {problem.n} positions by rule={self.rule} with "
            f"steps_deg={[float(step) for step in self.steps_deg]} can estimate all the parameters"
        )
        settings = self.settings(problem, survey.sequences[:_EXPLAINED])
        lengths = _within(problem, settings).sum(axis=1)
        usable = [one[:length] for one, length in zip(settings, lengths, strict=True) if length >= survey.numbers[0]]
        if not usable:
            return NoProgramError(
                "{head}: they leave the limits or stops of the stand, {limits}; choose other starts_deg or steps_deg",
                head=head,
                limits=[setting.limits for setting in problem.stand.settings],
            )
        visited = max(len(np.unique(np.round(np.degrees(one), 6) % _TURN, axis=0)) for one in usable)
        repeats = visited < max(map(len, usable))
        again = f": they come back to the same attitude after {visited} positions or fewer" if repeats else ""
        unseen = min((problem.information(one).inestimable() for one in usable), key=len)
        one, other = (Option("rule", rule) for rule in RULES if rule != self.rule)
        return NoProgramError(
            "{head}{again}; at best they can't see {unseen}; choose {one} or {other}, or other steps_deg",
            head=head,
            again=again,
            unseen="; ".join(unseen),
            one=one,
            other=other,
        )


def per_measurement(problem: Problem, settings: Array, numbers: np.ndarray) -> Array:
    """Losses (s, k) of the information per measurement of the first N positions; inf where not allowed."""
    single, prior = problem.information(settings[:, :, None, :]).matrix, np.diag(problem.model.prior_information)
    if problem.model.informed:  # once for all positions, not for each
        single = single - prior
    sums = (single.cumsum(axis=1)[:, numbers - 1] + prior) / numbers[:, None, None]
    losses = loss_of(problem.objective.criterion, Information(sums, problem.parameters))
    allowed = _within(problem, settings)[:, numbers - 1]
    if not problem.replicates:
        allowed &= np.stack([problem.restrictions.permits(settings[:, :number]) for number in numbers], axis=1)
    return np.where(allowed, losses, np.inf)


def _within(problem: Problem, settings: Array) -> np.ndarray:
    """Whether the first N positions of programs (s, n, d) are within the limits that bind them, (s, n)."""
    allows = problem.stand.axes.allows(settings)
    allows[:, : problem.held] = True  # the stand's limits don't bind fixed positions
    return np.logical_and.accumulate(allows, axis=1)
