"""Why no program of a problem can estimate all the parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acalx.errors import NoProgramError
from acalx.problem import Problem

__all__ = ["no_regular_program"]

# From so many random positions it is seen whether all parameters show at all.
_MANY = 500


def no_regular_program(problem: Problem) -> NoProgramError:
    """The error for a problem in which every program that was tried is singular."""
    limits = [setting.limits for setting in problem.stand.settings]
    everything = problem.restrictions.random(np.random.default_rng(0), 1)
    many = replace(problem, n=max(problem.n, _MANY), replicates=True)
    unseen = many.information(many.restrictions.random(np.random.default_rng(0), 1)[0]).inestimable()
    if not unseen:
        unseen = problem.information(everything[0]).inestimable()
    can_not = f"; no position there shows {'; '.join(unseen)}" if unseen else ""
    fixed = problem.stand.circumstances
    where, remedy = (" with {fixed}", "; change one of {fixed}") if fixed else ("", "")
    return NoProgramError(
        f"no program of {{n}} positions within {{limits}}{where} can estimate all the parameters{{can_not}}{remedy}",
        n=problem.n,
        limits=limits,
        fixed=fixed,
        can_not=can_not,
        inestimable=unseen,
    )
