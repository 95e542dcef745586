"""Estimates of the inverse Hessian for a stack of minimizations, dense or of limited memory.

Source: Nocedal and Wright, Numerical Optimization (2006), formula 6.17 and algorithm 7.4; for the
scale Oren and Luenberger, Manage. Sci. 20 (1974) 845.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Self, final

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["Curvature", "curvature"]

# Up to this many variables, or so many entries in all, the whole matrix is kept: fewer steps,
# and each costs less.
_DENSE = 128
_DENSE_ENTRIES = 2**18
_MEMORY = 20
# The first steps rescale the whole matrix, since they say most of its size and little of its shape.
_RESCALED = 6


class Curvature(ABC):
    """Inverse Hessians of s functions of k variables, learnt from their gradients."""

    def __init__(self, s: int, k: int) -> None:
        self.known = np.zeros(s, dtype=bool)

    @abstractmethod
    def apply(self, gradient: Array) -> Array:
        """Inverse Hessian times vectors (s, k), for those that are known."""

    @abstractmethod
    def learn(self, step: Array, change: Array, useful: np.ndarray) -> None:
        """Take steps (s, k) and the changes of the gradients along them, where useful."""

    @abstractmethod
    def select(self, keep: np.ndarray) -> None:
        """Keep only some members of the stack."""

    @abstractmethod
    def take(self, index: np.ndarray) -> Self:
        """Some members of the stack, by their numbers, as a stack of their own."""

    @abstractmethod
    def put(self, index: np.ndarray, source: Self) -> None:
        """Bring members taken before up to date."""

    def newton(self, gradient: Array) -> Array:
        """The step to the minimum as far as it is known; a short one downhill at first."""
        size = np.abs(gradient).max(axis=1, keepdims=True)
        first = gradient * (0.1 / np.maximum(size, 0.1))
        if not self.known.any():
            return np.asarray(-first)
        return np.asarray(-np.where(self.known[:, None], self.apply(gradient), first))

    def forget(self, which: np.ndarray) -> None:
        """Begin afresh for some members of the stack."""
        self.known[which] = False


@final
class _Dense(Curvature):
    def __init__(self, s: int, k: int) -> None:
        super().__init__(s, k)
        self.inverse = np.zeros((s, k, k))
        self.learnt = np.zeros(s, dtype=int)

    def apply(self, gradient: Array) -> Array:
        return np.asarray((self.inverse @ gradient[..., None])[..., 0])

    def learn(self, step: Array, change: Array, useful: np.ndarray) -> None:
        slope = np.where(useful, np.einsum("sk,sk->s", step, change), 1.0)
        fresh = useful & ~self.known
        if fresh.any():
            norm = np.einsum("sk,sk->s", change[fresh], change[fresh])
            self.inverse[fresh] = (slope[fresh] / norm)[:, None, None] * np.eye(step.shape[1])
            self.known |= fresh
            self.learnt[fresh] = 0
        turned = (self.inverse @ change[..., None])[..., 0]
        bend = np.einsum("sk,sk->s", change, turned)
        young = useful & (self.learnt < _RESCALED) & (bend > 0)
        if young.any():
            scale = np.where(young, slope / np.where(young, bend, 1.0), 1.0)
            self.inverse *= scale[:, None, None]
            turned, bend = turned * scale[:, None], bend * scale
        self.learnt += useful
        weight = (1.0 + bend / slope) / slope
        outer = step[:, :, None] * (weight[:, None] * step - turned / slope[:, None])[:, None, :]
        outer -= turned[:, :, None] * (step / slope[:, None])[:, None, :]
        self.inverse += outer if useful.all() else np.where(useful[:, None, None], outer, 0.0)

    def select(self, keep: np.ndarray) -> None:
        self.inverse, self.known, self.learnt = self.inverse[keep], self.known[keep], self.learnt[keep]

    def take(self, index: np.ndarray) -> Self:
        some = type(self)(0, self.inverse.shape[-1])
        some.inverse, some.known, some.learnt = self.inverse[index], self.known[index], self.learnt[index]
        return some

    def put(self, index: np.ndarray, source: Self) -> None:
        self.inverse[index], self.known[index], self.learnt[index] = source.inverse, source.known, source.learnt


@final
class _Limited(Curvature):
    def __init__(self, s: int, k: int) -> None:
        super().__init__(s, k)
        self.k = k
        self.steps: list[Array] = []
        self.changes: list[Array] = []
        self.weights: list[Array] = []  # 1 / (step . change); 0 where a pair was of no use
        self.scale = np.ones(s)

    def apply(self, gradient: Array) -> Array:
        direction = gradient.copy()
        products = []
        pairs = list(zip(self.steps, self.changes, self.weights, strict=True))
        for step, change, weight in reversed(pairs):
            products.append(weight * np.einsum("sk,sk->s", step, direction))
            direction -= products[-1][:, None] * change
        direction *= self.scale[:, None]
        for (step, change, weight), product in zip(pairs, reversed(products), strict=True):
            back = weight * np.einsum("sk,sk->s", change, direction)
            direction += (product - back)[:, None] * step
        return direction

    def learn(self, step: Array, change: Array, useful: np.ndarray) -> None:
        slope = np.where(useful, np.einsum("sk,sk->s", step, change), 1.0)
        norm = np.where(useful, np.einsum("sk,sk->s", change, change), 1.0)
        self.scale = np.where(useful, slope / norm, self.scale)
        self.known |= useful
        self.steps = [*self.steps[1 - _MEMORY :], step]
        self.changes = [*self.changes[1 - _MEMORY :], change]
        self.weights = [*self.weights[1 - _MEMORY :], np.where(useful, 1.0 / slope, 0.0)]

    def forget(self, which: np.ndarray) -> None:
        super().forget(which)
        for weight in self.weights:
            weight[which] = 0.0

    def select(self, keep: np.ndarray) -> None:
        self.steps = [step[keep] for step in self.steps]
        self.changes = [change[keep] for change in self.changes]
        self.weights = [weight[keep] for weight in self.weights]
        self.scale, self.known = self.scale[keep], self.known[keep]

    def take(self, index: np.ndarray) -> Self:
        """Afresh: the pairs of members that end at different steps are not of one length."""
        return type(self)(len(index), self.k)

    def put(self, index: np.ndarray, source: Self) -> None:
        """Nothing is kept."""


def curvature(s: int, k: int) -> Curvature:
    """A fresh estimate for s functions of k variables."""
    return _Dense(s, k) if k <= _DENSE or s * k * k <= _DENSE_ENTRIES else _Limited(s, k)
