"""What a descent needs of a problem: how good programs are, and which there are."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Objective

__all__ = ["Bounds", "Landscape"]


class Bounds(Protocol):
    """What keeps descent where programs may be: see `acalx.problem.Restrictions`."""

    @property
    def active(self) -> bool:
        """Whether some programs within the limits are not permitted."""

    @property
    def sizes(self) -> Array:
        """What is about as much of each of the d variables of a position, (d,)."""

    def limits_around(self, settings: Array) -> tuple[Array, Array]:
        """Limits (s, n d) of the variables around programs (s, n, d), infinite where there are none."""

    def permits(self, settings: Array) -> np.ndarray:
        """Which programs (s, n, d) are permitted, (s,)."""

    def project(self, settings: Array, allowed: Array) -> Array:
        """Programs (s, n, d) moved back towards permitted ones until they are permitted too."""


class Landscape(Protocol):
    """One criterion over variables: a `acalx.problem.Problem`, or whatever else can be descended on."""

    @property
    def objective(self) -> Objective:
        """How good programs are by the criterion."""

    @property
    def restrictions(self) -> Bounds:
        """Which programs there are."""

    def loss(self, settings: Array) -> Array:
        """Loss (s,) of programs (s, n, d), +inf where singular or not permitted."""

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        """The same with its gradient (s, n, d)."""
