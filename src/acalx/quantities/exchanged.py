"""Information of all the programs that differ from one in a single position.

A position h is taken out of a program and another one, c, put in: M' = M - h'h + c'c. With
K = inv(M) and the numbers a = h K h', b = c K c', e = h K c', the matrix identities of rank two give

    det M' = det M ((1 + b)(1 - a) + e^2),
    K' = K - ((1 - a) u u' + e (u v' + v u') - (1 + b) v v') / ((1 + b)(1 - a) + e^2),

with u = K c', v = K h': the determinant and the variances of thousands of programs for a few
products each, without their matrices.

Source: Fedorov, Theory of Optimal Experiments (1972), section 3.3; the Woodbury identity.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.information import Information

__all__ = ["Exchanged"]

# Where the determinant falls to less than this share of what it was the program counts as singular.
_SMALLEST = 1e-10


class Exchanged(Information):
    """Information of programs after an exchange, whose matrices are computed only when asked for.

    Where positions have one output, `log_det` and `variances` come from the identities above; a
    criterion that reads nothing else is evaluated in a small part of the time. Programs that the
    exchange makes singular are in `lost`, and have the figures of the program before.

    Parameters
    ----------
    before : Information
        With regular matrices (s, p, p).
    removed : array (s, m, p)
        Regressors of the position that is taken out.
    added : array (k, m, p) or (s, k, m, p)
        Regressors of those that may be put in, the same for all programs or not.
    """

    def __init__(self, before: Information, removed: Array, added: Array) -> None:
        object.__setattr__(self, "parameters", before.parameters)
        self.__dict__.update(before=before, removed=removed, added=added)
        self.__dict__["singular"] = np.zeros(self.lost.shape, dtype=bool)

    before: Information
    removed: Array
    added: Array

    @cached_property
    def lost(self) -> np.ndarray:
        """Which programs (s, k) become singular."""
        if not self._single:
            return Information(self._matrices, self.parameters).singular
        return np.less(self._factor, _SMALLEST)

    @cached_property
    def matrix(self) -> Array:
        """Information matrices M' after the exchange, (s, k, p, p)."""
        if not self.lost.any():
            return self._matrices
        return np.where(self.lost[..., None, None], self.before.matrix[:, None], self._matrices)

    @cached_property
    def log_det(self) -> Array:
        """log det M' of the programs after the exchange, (s, k)."""
        if not self._single:
            return Information(self.matrix, self.parameters).log_det
        factor = np.where(self.lost, 1.0, self._factor)
        return np.asarray(self.before.log_det[:, None] + np.log(factor))

    @cached_property
    def variances(self) -> Array:
        """Variances after the exchange, the diagonal of K', (s, k, p)."""
        if not self._single:
            return Information(self.matrix, self.parameters).variances
        a, b, e = self._products
        factor = np.where(self.lost, np.inf, self._factor)  # no change
        v = self._by_removed[..., None]
        change = self._by_added * ((1.0 - a) / factor)[:, None, :]
        change += v * (2.0 * e / factor)[:, None, :]
        change *= self._by_added
        change -= v**2 * ((1.0 + b) / factor)[:, None, :]
        return np.moveaxis(self.before.variances[..., None] - change, -2, -1)

    @property
    def _single(self) -> bool:
        return bool(self.removed.shape[-2] == 1)

    @cached_property
    def _matrices(self) -> Array:
        without = self.before.matrix - self.removed.swapaxes(-1, -2) @ self.removed
        return np.asarray(without[:, None] + self.added.swapaxes(-1, -2) @ self.added)

    @cached_property
    def _by_added(self) -> Array:
        """u, (s, p, k): arithmetic runs along the candidates."""
        return np.asarray(self.before.covariance @ self.added[..., 0, :].swapaxes(-1, -2))

    @cached_property
    def _by_removed(self) -> Array:
        """v, (s, p)."""
        return np.asarray((self.removed @ self.before.covariance)[:, 0, :])

    @cached_property
    def _products(self) -> tuple[Array, Array, Array]:
        """a (s, 1), b (s, k), e (s, k)."""
        a = (self._by_removed * self.removed[:, 0, :]).sum(axis=-1)[:, None]
        b = (self._by_added * self.added[..., 0, :].swapaxes(-1, -2)).sum(axis=-2)
        e = (self.removed @ self._by_added)[:, 0, :]
        return a, b, e

    @cached_property
    def _factor(self) -> Array:
        a, b, e = self._products
        return np.asarray((1.0 + b) * (1.0 - a) + e * e)
