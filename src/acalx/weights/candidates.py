"""Candidate positions, of which there may be more than memory holds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.stands import Grid, Stand

__all__ = ["Candidates", "Positions", "Rows"]

# Regressors of so many bytes are worked on at a time: they stay in the processor's cache.
_CHUNK_BYTES = 2**20


class Candidates(ABC):
    """Positions from which weights choose, known by their numbers."""

    @abstractmethod
    def __len__(self) -> int:
        """How many candidates there are, N."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """The p parameters that the columns of the regressors belong to."""

    @property
    @abstractmethod
    def outputs(self) -> int:
        """Number m of outputs in a position."""

    @abstractmethod
    def regressors(self, index: slice | np.ndarray) -> Array:
        """Regressors (k, m, p) of some of them; zero for a position that is not allowed."""

    def chunks(self, index: np.ndarray | None = None) -> Iterator[tuple[np.ndarray, Array]]:
        """Numbers and regressors of all of them, or of those of an index, a chunk at a time."""
        step = max(1, _CHUNK_BYTES // (8 * self.outputs * len(self.parameters)))
        total = len(self) if index is None else len(index)
        for start in range(0, total, step):
            stop = min(total, start + step)
            if index is None:
                yield np.arange(start, stop), self.regressors(slice(start, stop))
            else:
                yield index[start:stop], self.regressors(index[start:stop])


@final
@dataclass(frozen=True, eq=False)
class Rows(Candidates):
    """Candidates whose regressors are given.

    Parameters
    ----------
    rows : array (N, m, p)
    names : tuple of Parameter, length p

    Raises
    ------
    ArgumentError
        Rows of another shape, or not finite.
    """

    rows: Array
    names: tuple[Parameter, ...]

    def __post_init__(self) -> None:
        if self.rows.ndim != 3 or self.rows.shape[-1] != len(self.names) or not len(self.rows):
            raise ArgumentError(
                f"candidate regressors of shape {self.rows.shape}: expected (N, m, {len(self.names)}), N at least 1"
            )
        if not np.isfinite(self.rows).all():
            raise ArgumentError("candidate regressors must be finite numbers")

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters as they were given with the rows."""
        return self.names

    @property
    def outputs(self) -> int:
        """Number m of outputs in a position, from the shape of the rows."""
        return int(self.rows.shape[1])

    def regressors(self, index: slice | np.ndarray) -> Array:
        """The rows (k, m, p) of some of the candidates."""
        return self.rows[index]


@final
@dataclass(frozen=True, eq=False)
class Positions(Candidates):
    """Candidates that are positions of a stand; regressors are computed each time they are looked at.

    Parameters
    ----------
    stand : Stand
    model : Model
    settings : array (N, d) or Grid, in rad
    dwell_s : float, s
        In each position, for models that ask for it.
    """

    stand: Stand
    model: Model
    settings: Array | Grid
    dwell_s: float = 60.0

    def __len__(self) -> int:
        return len(self.settings)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The p parameters of the model."""
        return self.model.parameters

    @property
    def outputs(self) -> int:
        """Number m of outputs that the model has in a position."""
        return self.model.outputs

    def regressors(self, index: slice | np.ndarray) -> Array:
        """Regressors (k, m, p) of the model at what the stand lets the sensor feel."""
        settings = np.asfortranarray(self.settings[index])
        rows = self.model.regressors(self.stand.stimulus(settings).timed(self.model.needs, self.dwell_s))
        allowed = self.stand.axes.allows(settings)
        return rows if allowed.all() else np.where(allowed[:, None, None], rows, 0.0)
