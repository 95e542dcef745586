"""Programs as vectors, for searches that vary populations of numbers and know nothing of stands."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Restrictions

__all__ = ["Encoding"]


@dataclass(frozen=True, eq=False)
class Encoding:
    """The free positions of programs as vectors of v = (n - f) d numbers.

    Settings without steps are there in their own unit, between their limits. Those with steps are
    there as the numbers of their stops, from 0; any number between is rounded.

    Parameters
    ----------
    restrictions : Restrictions
        Of the programs; fixed positions are no part of vectors.
    """

    restrictions: Restrictions

    @cached_property
    def _stops(self) -> list[Array | None]:
        """Stops of each of the d settings."""
        return [None if s.step is None else s.stops() for s in self.restrictions.stand.settings]

    @property
    def _free(self) -> int:
        return self.restrictions.n - self.restrictions.held

    @property
    def bounds(self) -> Array:
        """Lower and upper limits of the numbers, (v, 2)."""
        limits = zip(self.restrictions.stand.axes.bounds, self._stops, strict=True)
        one = [bounds if stops is None else (0.0, len(stops) - 1.0) for bounds, stops in limits]
        return np.tile(np.array(one), (self._free, 1))

    @property
    def integral(self) -> np.ndarray:
        """Which numbers are numbers of stops, (v,)."""
        return np.tile([stops is not None for stops in self._stops], self._free)

    def settings(self, vectors: Array) -> Array:
        """Programs (s, n, d), in rad where settings are angles, of vectors (s, v); the fixed positions come first."""
        free = vectors.reshape(len(vectors), self._free, len(self._stops))
        columns = [
            free[..., k] if stops is None else stops[np.rint(free[..., k]).astype(int)]
            for k, stops in enumerate(self._stops)
        ]
        return self.restrictions.completed(np.asarray(np.stack(columns, axis=-1), dtype=float))

    def vectors(self, programs: Array) -> Array:
        """The way back, (s, v), for programs (s, n, d) that the stand can take."""
        free = programs[:, self.restrictions.held :]
        columns = [
            free[..., k] if s.step is None else np.searchsorted(s.stops(), s.nearest(free[..., k]))
            for k, s in enumerate(self.restrictions.stand.settings)
        ]
        vectors = np.stack(columns, axis=-1).astype(float).reshape(len(free), -1)
        return np.asarray(np.clip(vectors, *self.bounds.T))
