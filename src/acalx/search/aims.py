"""What each of a stack of runs seeks among several losses.

A run either minimizes a weighted sum of the losses, or seeks the least s for which no loss
exceeds its target by more than s times its rate. The targets may lie anywhere, so goals reach
every part of a front, also where it is not convex and weighted sums don't come.

Source: Pascoletti and Serafini, J. Optim. Theory Appl. 42 (1984) 499.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["Aims", "Goals"]

# Penalty of a goal, over the smallest range of a loss; larger ones are stiffer and no closer.
_PENALTY = 30.0
# By how much of the smallest range a goal may be missed.
_MISS = 0.003


@dataclass(frozen=True, eq=False)
class Goals:
    """Targets of the losses of s runs.

    Parameters
    ----------
    targets : array (s, k)
        What each loss is not to exceed; +inf where a run has no goal.
    rates : array (k,)
        How much of each loss an excess s stands for, the smallest of them 1.
    unit : float
        Smallest range of a loss.
    """

    targets: Array
    rates: Array
    unit: float

    @property
    def penalty(self) -> float:
        """By which the Lagrangian holds them."""
        return _PENALTY / self.unit

    @property
    def tolerance(self) -> float:
        """By how much they may be missed."""
        return _MISS * self.unit

    @property
    def sought(self) -> np.ndarray:
        """Which runs have goals, (s,)."""
        return np.asarray(np.isfinite(self.targets).all(axis=-1))

    def exceeded(self, losses: Array) -> Array:
        """By how much losses (s, k) are above their targets, over the rates, (s, k)."""
        return np.asarray((losses - self.targets) / self.rates)

    def excess(self, losses: Array) -> Array:
        """Least s for losses (s, k), zero for runs without goals."""
        return np.where(self.sought, self.exceeded(losses).max(axis=-1), 0.0)

    def select(self, index: np.ndarray) -> Self:
        """Of some of the runs."""
        return type(self)(self.targets[index], self.rates, self.unit)


@dataclass(frozen=True, eq=False)
class Aims:
    """What s runs seek among k losses.

    Parameters
    ----------
    weights : array (s, k)
        Of the losses in what is minimized.
    goals : Goals, optional
        What some of the runs seek beside that; none where it is left out.
    """

    weights: Array
    goals: Goals | None = None

    def merit(self, losses: Array) -> Array:
        """What is minimized, (s,), for losses (s, k)."""
        weighted = np.asarray((self.weights * losses).sum(axis=-1))
        return weighted if self.goals is None else np.asarray(self.goals.excess(losses) + weighted)

    def select(self, index: np.ndarray) -> Self:
        """Of some of the runs."""
        return type(self)(self.weights[index], None if self.goals is None else self.goals.select(index))
