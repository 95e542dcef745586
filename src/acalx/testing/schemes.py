"""The contract of a scheme."""

from __future__ import annotations

from typing import Any

import numpy as np

from acalx.optimizers.base import Optimizer
from acalx.problem import Problem
from acalx.schemes import Scheme
from acalx.testing.optimizers import interrupt, require_program
from acalx.testing.rules import require, require_close

__all__ = ["check_scheme"]


def check_scheme(scheme: Scheme, problem: Problem, optimizer: Optimizer[Any], *, seed: int = 0) -> None:
    """Check a scheme on a problem that it takes: its program, its parts, an interrupt.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
        With one criterion and a model that the scheme takes apart, if it does; it is solved
        twice, and begun a third time.
    optimizer : Optimizer
        One that is fast on it.
    seed : int
        Of the random generator.
    """
    least = scheme.smallest_n(problem)
    whole = isinstance(least, (int, np.integer)) and problem.held < least <= problem.n
    require(whole, scheme, f"smallest_n is a whole number above the fixed positions and up to n, got {least!r}")
    one, again = (scheme.solve(problem, optimizer, np.random.default_rng(seed)) for _ in range(2))
    result, settings = one.result, one.result.program
    require(result.status in ("ok", "limit"), scheme, f"status is ok or limit, got {result.status!r}")
    require(bool(result.message), scheme, "the message says how the program came about")
    require(result.evaluations > 0, scheme, "evaluations are counted")
    require(len(settings) <= problem.n, scheme, f"the program has n={problem.n} positions at most, got {len(settings)}")
    require_program(scheme, problem, settings, len(settings))
    loss, last = problem.loss(settings), result.history[-1][2] if result.history else np.nan
    require(bool(np.isfinite(loss)), scheme, "the program shows all parameters")
    require_close(scheme, "the history ends with the loss of the program", np.array(last), loss, 1e-6)
    same = settings.tobytes() == again.result.program.tobytes()
    require(same, scheme, "the same seed gives the same program, bit for bit")
    names = [part.name for part in one.parts]
    require(len(set(names)) == len(names), scheme, f"each part has its own name, got {names}")
    if one.parts:
        brought = np.concatenate([part.settings for part in one.parts])
        free = np.array_equal(brought, settings[problem.held :])
        require(free, scheme, "the program is the fixed positions and what the parts bring, in their order")
        require(all(part.dropped >= 0 for part in one.parts), scheme, "a part drops no position or some")
    _check_interrupt(scheme, problem, optimizer, seed)


def _check_interrupt(scheme: Scheme, problem: Problem, optimizer: Optimizer[Any], seed: int) -> None:
    """An interrupt ends in a result that says so, or where there is no program yet in KeyboardInterrupt."""
    try:
        halted = scheme.solve(problem, optimizer, np.random.default_rng(seed), interrupt).result
    except KeyboardInterrupt:
        return
    require(halted.status == "interrupted", scheme, f"lets an interrupt pass, got status {halted.status!r}")
