"""Derivatives of residuals by the parameters, kept as a model has them best: their information, and the way back."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from acalx.models.blocks import Places, in_blocks, side_by_side
from acalx.models.table import Table
from acalx.numerics.arrays import Array, empty_as
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus

__all__ = ["InBlocks", "Jacobian", "PartByPart", "Whole", "placed"]


class Linear(Protocol):
    """What a model says that its rows do not: what is known before, and how they depend on the stimulus."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The p parameters, in the order of the columns."""

    @property
    def outputs(self) -> int:
        """Number m of residuals in a position."""

    def information_of(self, regressors: Array) -> Information:
        """Information of programs with these rows, and what is known before."""

    def with_prior(self, information: Information) -> Information:
        """The same with what is known before."""

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the rows to the stimulus."""


@dataclass(frozen=True, eq=False)
class Jacobian(ABC):
    """Rows of programs, what was felt in them, and what information and its gradient need of both.

    Parameters
    ----------
    model : Linear
        As a rule an `acalx.models.Model`.
    stimulus : Stimulus
        Arrays (..., n, width).
    """

    model: Linear
    stimulus: Stimulus

    @property
    @abstractmethod
    def regressors(self) -> Array:
        """The rows H, (..., n, m, p)."""

    @property
    @abstractmethod
    def information(self) -> Information:
        """H' H, and what is known before, matrices (..., p, p)."""

    @abstractmethod
    def pull(self, gradient: Array) -> Stimulus:
        """From a gradient G with respect to the information, (..., p, p), to the stimulus: through 2 H G."""


@dataclass(frozen=True, eq=False)
class Whole(Jacobian):
    """Rows as one array.

    Parameters
    ----------
    rows : array (..., n, m, p)
    """

    rows: Array

    @property
    def regressors(self) -> Array:
        """The rows as they were given."""
        return self.rows

    @cached_property
    def information(self) -> Information:
        """The model's, of all the rows at once."""
        return self.model.information_of(self.rows)

    def pull(self, gradient: Array) -> Stimulus:
        """Through the model's own `pull`."""
        return self.model.pull(self.stimulus, 2.0 * (self.rows @ gradient[..., None, :, :]))


@dataclass(frozen=True, eq=False)
class InBlocks(Jacobian):
    """Rows of outputs that share no parameters with others, a small array for each block of a table.

    Parameters
    ----------
    table : Table
    felt : Stimulus
        In the units that the table takes.
    units : mapping of str to str
        Those, by quantity.
    """

    table: Table
    felt: Stimulus
    units: Mapping[str, str]

    @cached_property
    def rows(self) -> Sequence[Array]:
        """Those of each block, (..., n, its outputs, its parameters)."""
        return self.table.in_blocks(self.felt)

    @property
    def regressors(self) -> Array:
        """Those of the blocks in their places, and zeros."""
        first = self.rows[0]
        whole = empty_as(first, (*first.shape[:-2], self.table.outputs, self.table.count))
        whole[...] = 0.0
        for (outputs, numbers), rows in zip(self.table.blocks, self.rows, strict=True):
            whole[..., outputs[:, None], numbers] = rows
        return whole

    @cached_property
    def information(self) -> Information:
        """That of each block in its place."""
        return self.model.with_prior(in_blocks(self.table.blocks, self.rows, self.model.parameters))

    def pull(self, gradient: Array) -> Stimulus:
        """From block to block, added up."""
        pulled = [
            2.0 * (rows @ gradient[..., None, numbers[:, None], numbers])
            for (_, numbers), rows in zip(self.table.blocks, self.rows, strict=True)
        ]
        return self.stimulus.from_units(self.table.pull_blocks(self.felt, pulled), self.units)


@dataclass(frozen=True, eq=False)
class PartByPart(Jacobian):
    """Rows of models that are read in the same positions.

    Parameters
    ----------
    parts : sequence of Jacobian
    places : sequence of pairs
        Outputs and parameters of each part among those of the whole.
    shared : bool
        Whether parts share parameters.
    """

    parts: Sequence[Jacobian]
    places: Sequence[tuple[slice, Places]]
    shared: bool

    @property
    def regressors(self) -> Array:
        """Those of the parts in their places, and zeros."""
        parts = [part.regressors for part in self.parts]
        rows = empty_as(parts[0], (*parts[0].shape[:-2], self.model.outputs, len(self.model.parameters)))
        rows[...] = 0.0
        for part, (outputs, own) in zip(parts, self.places, strict=True):
            rows[..., outputs, own] = part
        return rows

    @cached_property
    def information(self) -> Information:
        """That of each part in its place."""
        parts = [part.information for part in self.parts]
        return placed(parts, [own for _, own in self.places], self.model.parameters, shared=self.shared)

    def pull(self, gradient: Array) -> Stimulus:
        """Part by part, summed up."""
        total: dict[str, Array] = {}
        for one, (_, own) in zip(self.parts, self.places, strict=True):
            of_part = gradient[..., own, own] if isinstance(own, slice) else gradient[..., own[:, None], own]
            for name, pulled in one.pull(of_part).items():
                total[name] = total[name] + pulled if name in total else pulled
        return self.stimulus.made(total)


def placed(
    parts: Sequence[Information], places: Sequence[Places], parameters: tuple[Parameter, ...], *, shared: bool
) -> Information:
    """Information of a whole from that of its parts, each with the places of its parameters; added up where shared."""
    p = len(parameters)
    matrix = np.zeros((*parts[0].matrix.shape[:-2], p, p))
    for part, own in zip(parts, places, strict=True):
        if isinstance(own, slice):
            matrix[..., own, own] = part.matrix
        else:
            matrix[..., own[:, None], own] += part.matrix
    numbers = np.arange(p)
    return Information(matrix, parameters, () if shared else side_by_side(parts, [numbers[own] for own in places]))
