"""The running account of a search."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from acalx.numerics.arrays import Array
from acalx.search.pareto import front_points, knee
from acalx.search.result import ApproximateDesign, Front, Result, Solution, Status, Survey

__all__ = ["Account", "Watch"]

Watch = Callable[["Account"], None]


@dataclass
class Account:
    """Running account of a search: the best program so far, evaluations, time, progress.

    Parameters
    ----------
    watch : callable, optional
        Called with the account after each step of the search, e.g. to show progress.
    front : (array (m, n, d), array (m, k)), optional
        Programs and losses of the front so far, where there are several objectives.
    """

    watch: Watch | None = None
    best: Solution | None = None
    evaluations: int = 0
    fraction: float = 0.0
    front: tuple[Array, Array] | None = None
    history: list[tuple[int, float, float]] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)

    @property
    def seconds(self) -> float:
        """Time since the search began."""
        return time.perf_counter() - self.started

    def see(self, settings: Array, losses: Array) -> None:
        """Count programs (s, n, d) that were evaluated and keep the best of them."""
        self.evaluations += len(losses)
        self.keep(settings, losses)

    def keep(self, settings: Array, losses: Array) -> None:
        """Keep the best of programs (s, n, d) that are counted already."""
        if not len(losses):
            return
        k = int(losses.argmin())
        if np.isfinite(losses[k]) and (self.best is None or losses[k] < self.best.loss):
            self.best = Solution(settings[k].copy(), float(losses[k]))
            self.history.append((self.evaluations, self.seconds, self.best.loss))
        self.tick()

    def hold(self, settings: Array, losses: Array) -> None:
        """Keep a front, programs (m, n, d) and losses (m, k), in the place of the one before."""
        if len(losses):
            self.front = settings, losses
        self.tick()

    def tick(self) -> None:
        """Let the watch know."""
        if self.watch is not None:
            self.watch(self)

    @property
    def found(self) -> bool:
        """Whether there is a program yet."""
        return self.best is not None or self.front is not None

    def result(
        self,
        status: Status,
        message: str,
        solutions: tuple[Solution, ...],
        *,
        gain: float | None = None,
        survey: Survey | None = None,
        design: ApproximateDesign | None = None,
    ) -> Result:
        """The end of a search for one criterion."""
        return Result(status, message, self.evaluations, self.seconds, self.history, solutions, gain, survey, design)

    def front_result(self, status: Status, message: str, canonical: Callable[[Array], Array]) -> Front:
        """The end of a search for several objectives: the front that is held, its programs as they are written."""
        assert self.front is not None
        programs, losses = self.front
        points = front_points(np.stack([canonical(program) for program in programs]), losses)
        return Front(status, message, self.evaluations, self.seconds, self.history, points, knee(losses))
