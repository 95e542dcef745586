"""Projected quasi-Newton minimization of a stack of independent functions at once.

All the starts of a multi-start search go through each step together, so that the cost of a
numpy call is shared by them; a run that has ended leaves the stack.

Source: Nocedal and Wright, Numerical Optimization (2006), chapters 3 and 6; bounds by the
two-metric projection of Bertsekas, SIAM J. Control Optim. 20 (1982) 221.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.curvature import Curvature, curvature

__all__ = ["Minima", "minimize_stack"]

_SUFFICIENT = 1e-4
_MAX_HALVINGS = 20

Objective = Callable[[Array, np.ndarray], tuple[Array, Array]]
Projection = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class Minima:
    """Where each minimization of a stack ended.

    Parameters
    ----------
    x : array (s, k)
    loss : array (s,)
    converged : array (s,) of bool
        False where the iterations ran out.
    """

    x: Array
    loss: Array
    converged: np.ndarray


def minimize_stack(
    objective: Objective,
    x: Array,
    lower: Array,
    upper: Array,
    *,
    tolerance: float = 1e-7,
    loss_tolerance: float = 1e-13,
    iterations: int = 1000,
    project: Projection | None = None,
    known: Curvature | None = None,
    sizes: Array | None = None,
) -> Minima:
    """Minimize s functions of k variables within bounds, all at once.

    Parameters
    ----------
    objective : callable
        Takes points (a, k) and the indices (a,) of the functions that they belong to; returns
        values (a,) and gradients (a, k). A value may be inf.
    x : array (s, k)
        Starts.
    lower, upper : array (k,) or (s, k)
        Bounds of all the runs or of each; infinite where there are none.
    tolerance : float
        A run ends where no component of the projected gradient is larger,
    loss_tolerance : float
        or where two steps one after another lower the value by less, relative to 1 + |value|,
    iterations : int
        or after so many steps.
    project : callable, optional
        Takes points (a, k) and others (a, k) that are allowed, and gives points between them that
        are allowed; where bounds do not say all.
    known : Curvature, optional
        What is known of the curvatures beforehand; brought up to date at the end, so that
        functions that change a little can be minimized again in fewer steps.
    sizes : array (k,), optional
        What is about as much of each variable, powers of two; all the same where they are not given.
    """
    if sizes is not None and (sizes != 1.0).any():
        return _sized(
            partial(
                minimize_stack,
                tolerance=tolerance,
                loss_tolerance=loss_tolerance,
                iterations=iterations,
                known=known,
            ),
            (objective, x, lower, upper, project),
            sizes,
        )
    runs = _Runs(objective, np.clip(x, lower, upper), lower, upper, project, known)
    for _ in range(iterations):
        if not runs.step(tolerance, loss_tolerance):
            break
    return runs.minima()


def _sized(minimize: Callable[..., Minima], given: tuple[Any, ...], sizes: Array) -> Minima:
    """Minima of the same functions of variables that are divided by their sizes."""
    objective, x, lower, upper, project = given

    def of_sized(y: Array, index: np.ndarray) -> tuple[Array, Array]:
        value, gradient = objective(y * sizes, index)
        return value, gradient * sizes

    def projected(y: Array, allowed: Array) -> Array:
        return np.asarray(project(y * sizes, allowed * sizes) / sizes)

    found = minimize(of_sized, x / sizes, lower / sizes, upper / sizes, project=projected if project else None)
    return Minima(found.x * sizes, found.loss, found.converged)


class _Runs:
    """The runs that go on, and in `final` where all of them were last."""

    def __init__(
        self,
        objective: Objective,
        x: Array,
        lower: Array,
        upper: Array,
        project: Projection | None,
        known: Curvature | None,
    ) -> None:
        self.objective, self.project = objective, project
        self.lower, self.upper = np.broadcast_to(lower, x.shape), np.broadcast_to(upper, x.shape)
        self.index = np.arange(len(x))
        self.x = x
        self.value, self.gradient = objective(x, self.index)
        self.known = known
        self.curvature = curvature(*x.shape) if known is None else known.take(self.index)
        self.idle = np.zeros(len(x), dtype=int)
        self.final = Minima(x.copy(), self.value.copy(), np.zeros(len(x), dtype=bool))

    def minima(self) -> Minima:
        self.final.x[self.index], self.final.loss[self.index] = self.x, self.value
        if self.known is not None:
            self.known.put(self.index, self.curvature)
        return self.final

    def step(self, tolerance: float, loss_tolerance: float) -> bool:
        """One step of every run that has not ended; False when all have."""
        held = ((self.x <= self.lower) & (self.gradient > 0)) | ((self.x >= self.upper) & (self.gradient < 0))
        free = np.where(held, 0.0, self.gradient)
        ended = (np.abs(free).max(axis=1, initial=0.0) <= tolerance) | (self.idle >= 2) | ~np.isfinite(self.value)
        if ended.any():
            self._retire(ended)
            held, free = held[~ended], free[~ended]
        if not len(self.index):
            return False
        direction = np.where(held, 0.0, self.curvature.newton(free))
        uphill = ~(np.einsum("sk,sk->s", direction, free) < 0)
        if uphill.any():
            self.curvature.forget(uphill)
            direction = np.where(held, 0.0, self.curvature.newton(free))
        self._search(direction, free, held, loss_tolerance)
        return True

    def _search(self, direction: Array, free: Array, held: np.ndarray, loss_tolerance: float) -> None:
        """Backtracking along the projected direction; then learn from the steps taken."""
        length = np.ones(len(direction))
        x, value, gradient = self.x.copy(), self.value.copy(), self.gradient.copy()
        going = np.arange(len(direction))
        for _ in range(_MAX_HALVINGS):
            base = self.value[going]
            trial = self.x[going] + length[going, None] * direction[going]
            trial = np.clip(trial, self.lower[going], self.upper[going])
            if self.project is not None:
                trial = self.project(trial, self.x[going])
            trial_value, trial_gradient = self.objective(trial, self.index[going])
            slope = np.einsum("sk,sk->s", trial - self.x[going], free[going])
            rounding = 1e-14 * (1.0 + np.abs(base))
            good = trial_value <= base + _SUFFICIENT * slope + rounding
            done = going[good]
            x[done], value[done], gradient[done] = trial[good], trial_value[good], trial_gradient[good]
            if good.all():
                going = going[:0]
                break
            # the minimum of the parabola through what is known, between a tenth and a half
            bad = ~good
            rise = trial_value[bad] - base[bad] - slope[bad]
            with np.errstate(invalid="ignore", divide="ignore"):
                factor = np.clip(np.nan_to_num(-slope[bad] / (2 * rise), nan=0.1), 0.1, 0.5)
            going = going[bad]
            length[going] *= factor
        # only what can move: the curvature towards a bound that holds is of no use
        bound = held | (((x <= self.lower) | (x >= self.upper)) & (x != self.x))
        step = np.where(bound, 0.0, x - self.x)
        change = np.where(bound, 0.0, gradient - self.gradient)
        along = np.einsum("sk,sk->s", step, change)
        sizes = np.einsum("sk,sk->s", step, step) * np.einsum("sk,sk->s", change, change)
        useful = along > 1e-9 * np.sqrt(sizes)
        self.curvature.learn(step, change, useful)
        self.curvature.forget(~useful)
        small = ~(self.value - value > loss_tolerance * (1.0 + np.abs(value)))
        self.idle = np.where(small, self.idle + 1, 0)
        self.idle[going] = 2  # no lower point was found along the direction
        self.x, self.value, self.gradient = x, value, gradient

    def _retire(self, ended: np.ndarray) -> None:
        gone, keep = self.index[ended], ~ended
        if self.known is not None:
            self.known.put(gone, self.curvature.take(np.flatnonzero(ended)))
        self.final.x[gone], self.final.loss[gone] = self.x[ended], self.value[ended]
        self.final.converged[gone] = np.isfinite(self.value[ended])
        self.index, self.x, self.idle = self.index[keep], self.x[keep], self.idle[keep]
        self.lower, self.upper = self.lower[keep], self.upper[keep]
        self.value, self.gradient = self.value[keep], self.gradient[keep]
        self.curvature.select(keep)
