"""The information matrix of a program and everything that is read from it."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.numerics.elimination import cholesky, inverse_roots, row_reduced, substituted
from acalx.quantities.parameter import Parameter, as_sum, parameter_groups, parameter_sensors

__all__ = ["Information"]

# A parameter is a combination of the others, to working accuracy, where its variance is so many times larger
# than with the others known, or an eigenvalue of the matrix scaled to a unit diagonal so much smaller than the largest.
_LARGEST_INFLATION = 1e13
_EIGENVALUE_TOLERANCE = 1e-13
# A diagonal entry so much smaller than the largest of the same sensor is the square of rounding errors: no
# measurement shows the parameter at all.
_ROUNDING = 1e-28
# With eigenvalues of M further apart than this, the smallest is read from K: that of M would have the rounding
# errors of the largest.
_APART = 1e10
# From this many matrices on, elimination along the stack beats one LAPACK call a matrix.
_LARGE_STACK = 32
_SMALL_MATRIX = 36


@dataclass(frozen=True, eq=False)
class Information:
    """Information matrix M = H'H of one program or a stack of them.

    Everything derived from it is computed on first use and kept. The covariance of the
    least-squares estimate is K = inv(M) times the noise variance, which is 1 here because
    regressors are divided by the noise standard deviation.

    Parameters
    ----------
    matrix : array (..., p, p)
        Symmetric, positive semidefinite.
    parameters : tuple of Parameter, length p
    blocks : tuple of arrays of int, optional
        Indices of parameters that have nothing to do with others, where the matrix is zero between them.
    """

    matrix: Array
    parameters: tuple[Parameter, ...]
    blocks: tuple[np.ndarray, ...] = ()

    @classmethod
    def from_regressors(cls, regressors: Array, parameters: tuple[Parameter, ...]) -> Information:
        """Sum the information of all positions and outputs.

        Parameters
        ----------
        regressors : array (..., n, m, p)
            Rows h for m outputs in each of n positions, in units of the noise.
        """
        *stack, n, m, p = regressors.shape
        rows = regressors.reshape((*stack, n * m, p), order="F" if _stack_first(regressors) else "C")
        if math.prod(stack) < _LARGE_STACK:
            return cls(rows.swapaxes(-1, -2) @ rows, parameters)
        matrix = np.empty((*stack, p, p), order="F")
        for i in range(p):  # the upper triangle, one row at a time, along the stack
            np.einsum("...n,...nj->...j", rows[..., i], rows[..., i:], out=matrix[..., i, i:])
            matrix[..., i + 1 :, i] = matrix[..., i, i + 1 :]
        return cls(matrix, parameters)

    @cached_property
    def groups(self) -> Mapping[str, list[int]]:
        """Indices of the parameters of each group."""
        return parameter_groups(self.parameters)

    def group(self, name: str) -> list[int]:
        """Indices of the parameters of one group; ArgumentError where there is none."""
        groups = self.groups
        if name not in groups:
            raise ArgumentError(f"no parameter group {name!r}; the groups are {', '.join(groups)}")
        return groups[name]

    @property
    def _large(self) -> bool:
        many = math.prod(self.matrix.shape[:-2]) >= _LARGE_STACK
        return many and self.matrix.shape[-1] <= _SMALL_MATRIX and not self.blocks

    @cached_property
    def _factors(self) -> tuple[Array, np.ndarray]:
        """Cholesky factors (p, p, ...) along the stack, and where there is one (...)."""
        return cholesky(self.matrix)

    @cached_property
    def _unchecked_root(self) -> Array:
        """Inverse R of the Cholesky factor, inv(M) = R'R; of no meaning where M is singular."""
        if not self._large:
            with contextlib.suppress(np.linalg.LinAlgError):
                return self._by_blocks(self.matrix, lambda block: np.linalg.inv(np.linalg.cholesky(block)))
        return inverse_roots(*self._factors)

    def _by_blocks(self, matrix: Array, function: Callable[[Array], Array]) -> Array:
        """A function of each block of a matrix, zero outside of them."""
        if not self.blocks:
            return np.asarray(function(matrix))
        whole = np.zeros_like(matrix)
        for block in self.blocks:
            whole[..., block[:, None], block] = function(matrix[..., block[:, None], block])
        return whole

    @cached_property
    def _root(self) -> Array:
        """Inverse R of the Cholesky factor, inv(M) = R'R; inf where M is singular."""
        if not self.singular.any():
            return self._unchecked_root
        return np.where(self.singular[..., None, None], np.inf, self._unchecked_root)

    @property
    def _inflated(self) -> np.ndarray:
        """Where a parameter is a combination of the others to working accuracy, or unseen, (...)."""
        root = self._unchecked_root
        # variance of a parameter with the others unknown, over that with the others known
        with np.errstate(invalid="ignore"):  # inf times zero is nan, which compares as it should
            inflation = np.einsum("...ki,...ki->...i", root, root) * self.matrix.diagonal(axis1=-2, axis2=-1)
        return np.asarray(~(self._shown & (inflation < _LARGEST_INFLATION)).all(axis=-1))

    @property
    def _shown(self) -> np.ndarray:
        """Which parameters some measurement shows, (..., p)."""
        diagonal = self.matrix.diagonal(axis1=-2, axis2=-1)
        shown = diagonal > _ROUNDING * diagonal.max(axis=-1, keepdims=True)
        if not shown.all():
            for members in parameter_sensors(self.parameters).values():
                own = diagonal[..., members]
                shown[..., members] = own > _ROUNDING * own.max(axis=-1, keepdims=True)
        return np.asarray(shown)

    @cached_property
    def singular(self) -> np.ndarray:
        """Where some combination of the parameters can't be estimated, shape (...)."""
        if not self._large:
            return self._inflated
        upper, regular = self._factors
        diagonal = self.matrix.diagonal(axis1=-2, axis2=-1)
        # Hadamard: no variance is inflated by more than the product of the diagonal over the determinant
        with np.errstate(all="ignore"):  # what is not regular gives inf or nan
            inflation = (diagonal / upper.diagonal() ** 2).prod(axis=-1)
        clear = (inflation < _LARGEST_INFLATION) & (diagonal.min(axis=-1) > _ROUNDING * diagonal.max(axis=-1))
        singular = ~regular
        doubtful = regular & ~clear
        if doubtful.any():
            singular[doubtful] = Information(self.matrix[doubtful], self.parameters)._inflated
        return singular

    @cached_property
    def log_det(self) -> Array:
        """log det M, shape (...); -inf where M is singular."""
        if not self._large:
            return np.asarray(-2.0 * np.log(self._root.diagonal(axis1=-2, axis2=-1)).sum(axis=-1))
        with np.errstate(all="ignore"):  # what is not regular gives inf or nan
            return np.where(self.singular, -np.inf, 2.0 * np.log(self._factors[0].diagonal()).sum(axis=-1))

    def select(self, members: np.ndarray) -> Information:
        """Some members of the stack, by a mask (...)."""
        chosen = Information(self.matrix[members], self.parameters, self.blocks)
        # computed already, and the same verdict where another algorithm suits the fewer ones
        chosen.__dict__["singular"] = self.singular[members]
        if "_factors" in self.__dict__:
            upper, regular = self._factors
            chosen.__dict__["_factors"] = upper[..., members], regular[members]
        if "_unchecked_root" in self.__dict__:
            chosen.__dict__["_unchecked_root"] = self._unchecked_root[members]
        return chosen

    @cached_property
    def covariance(self) -> Array:
        """K = inv(M), shape (..., p, p); inf where M is singular."""
        if not self.singular.any():
            return self._by_blocks(self._root, lambda root: root.swapaxes(-1, -2) @ root)
        singular = self.singular[..., None, None]
        root = np.where(singular, 0.0, self._root)
        return np.where(singular, np.inf, root.swapaxes(-1, -2) @ root)

    def solve(self, vectors: Array) -> Array:
        """K v for vectors (..., p), which may have more leading axes than M; nan where M is singular."""
        if self._large:
            upper, _ = self._factors
            solution = substituted(upper, vectors)
            return np.where(self.singular[..., None], np.nan, solution) if self.singular.any() else solution
        root = self._unchecked_root
        with np.errstate(invalid="ignore"):  # inf times zero, where M is singular
            inner = np.einsum("...ij,...j->...i", root, vectors)
            solution = np.einsum("...ji,...j->...i", root, inner)
        return np.where(self.singular[..., None], np.nan, solution) if self.singular.any() else np.asarray(solution)

    @cached_property
    def eigenvalues(self) -> Array:
        """Eigenvalues of M, ascending, shape (..., p)."""
        return np.asarray(np.linalg.eigvalsh(self.matrix), dtype=float)

    @property
    def _far_apart(self) -> np.ndarray:
        """Where the smallest eigenvalue may be lost in the rounding errors of the largest, or M is singular, (...)."""
        values = self.eigenvalues
        return np.asarray(~(values[..., 0] * _APART > values[..., -1]))

    @cached_property
    def smallest_eigenvalue(self) -> Array:
        """Smallest eigenvalue of M, to working accuracy, shape (...); 0 where M is singular."""
        smallest, apart = self.eigenvalues[..., 0], self._far_apart
        if not apart.any():  # none of them singular either
            return np.asarray(smallest)
        smallest = np.where(self.singular, 0.0, smallest)
        members, inverted = self._inverted(apart)
        smallest[members] = 1.0 / np.linalg.eigvalsh(inverted)[..., -1]
        return smallest

    @property
    def weakest(self) -> Array:
        """Combinations of parameters that are known worst, unit vectors (..., p): those of the smallest eigenvalue."""
        direction = np.linalg.eigh(self.matrix).eigenvectors[..., 0]
        members, inverted = self._inverted(self._far_apart)
        direction[members] = np.linalg.eigh(inverted).eigenvectors[..., -1]
        return np.asarray(direction)

    def _inverted(self, members: np.ndarray) -> tuple[np.ndarray, Array]:
        """Which members (...) of the stack have an inverse, judged by their own matrices, and their covariances."""
        members = np.array(members & ~self.singular)
        own = Information(self.matrix[members], self.parameters)
        members[members] = regular = ~own.singular
        return members, own.select(regular).covariance

    @cached_property
    def variances(self) -> Array:
        """Variances of the parameters, shape (..., p)."""
        return self.covariance.diagonal(axis1=-2, axis2=-1)

    @property
    def standard_deviations(self) -> Array:
        """Standard deviations of the parameters in units of the noise, shape (..., p)."""
        return np.sqrt(self.variances)

    @property
    def correlations(self) -> Array:
        """Correlations of the estimates, shape (..., p, p); nan where M is singular."""
        singular = self.singular[..., None]
        deviations = np.where(singular, 1.0, self.standard_deviations)
        covariance = np.where(singular[..., None], np.nan, self.covariance)
        return np.asarray(covariance / (deviations[..., :, None] * deviations[..., None, :]))

    @property
    def condition_number(self) -> Array:
        """Ratio of the largest to the smallest eigenvalue of M, shape (...); inf where singular."""
        smallest = np.where(self.singular, 1.0, self.smallest_eigenvalue)
        return np.where(self.singular, np.inf, self.eigenvalues[..., -1] / smallest)

    def theta(self, group: str) -> Array:
        """Largest standard deviation of a group of parameters, shape (...).

        Source: Egorov, Kiryachenko, Popov (2021).
        """
        return np.asarray(np.sqrt(self.variances[..., self.group(group)].max(axis=-1)))

    def inequality(self, group: str) -> Array:
        """(max - min) / max of the standard deviations of a group, shape (...), 0 to 1.

        Nan where the information is singular. Source: Egorov, Kiryachenko, Popov (2021), whose
        tables come out with standard deviations though the formula there has variances.
        """
        variances = self.variances[..., self.group(group)]
        ratio = np.where(self.singular, np.nan, variances.min(axis=-1)) / variances.max(axis=-1)
        return np.asarray(1.0 - np.sqrt(ratio))

    def inestimable(self, smallest: float = 1e-6) -> list[str]:
        """Combinations of the parameters that this one program can't see, as readable sums.

        Adding any multiple of such a combination to the true parameters changes no measurement.
        The list is empty where all the parameters can be estimated.

        Parameters
        ----------
        smallest : float
            Coefficients below it are not shown; the largest of each combination is 1.
        """
        if not self.singular:
            return []
        shown = self._shown
        scale = np.sqrt(np.where(shown, self.matrix.diagonal(), 1.0))
        scaled = np.where(np.outer(shown, shown), self.matrix, 0.0) / np.outer(scale, scale)
        values, vectors = np.linalg.eigh(scaled)
        null_space = (vectors[:, values < _EIGENVALUE_TOLERANCE * max(values[-1], 1e-300)] / scale[:, None]).T
        rows = sorted(row_reduced(null_space), key=lambda row: int(np.argmax(np.abs(row) >= smallest)))
        return [as_sum(row, self.parameters, smallest) for row in rows]


def _stack_first(array: Array) -> bool:
    return bool(array.flags.f_contiguous and not array.flags.c_contiguous)
