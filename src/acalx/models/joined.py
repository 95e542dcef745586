"""Several models read at the same positions, as one."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, starmap
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.models.base import Model
from acalx.numerics.arrays import Array, empty_as
from acalx.options import keep
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus

__all__ = ["Composite", "Joined"]


class Composite(Model):
    """Models without common parameters, each read in every position.

    Regressors stack the outputs of the parts; the information is block-diagonal, each block
    that of a part. A new composite gives `models`.
    """

    @property
    @abstractmethod
    def models(self) -> tuple[Model, ...]:
        """The parts, in the order of their parameters and outputs."""

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters of all the parts, each part a sensor of its own, or several."""
        return tuple(
            replace(parameter, sensor=f"{number}.{parameter.sensor}" if parameter.sensor else f"{number}")
            for number, model in enumerate(self.models)
            for parameter in model.parameters
        )

    @property
    def needs(self) -> tuple[str, ...]:
        """Names of the quantities of the stimulus that any of the parts reads, each once."""
        return tuple(dict.fromkeys(name for model in self.models for name in model.needs))

    @property
    def outputs(self) -> int:
        """Number m of outputs in a position, those of all the parts together."""
        return sum(model.outputs for model in self.models)

    @property
    def degree(self) -> int | None:
        """Degree of the rows as polynomials in the stimulus, the largest of the parts; None if one of them has none."""
        degrees = [model.degree for model in self.models]
        return max((degree for degree in degrees if degree is not None), default=None) if None not in degrees else None

    @property
    def entries(self) -> int:
        """Number of entries of the rows of a position that are not zero in every position: the blocks of the parts."""
        return sum(model.entries for model in self.models)

    @property
    def smallest_n(self) -> int:
        """The fewest positions that determine the parameters of every part: they are read in the same positions."""
        return max(model.smallest_n for model in self.models)

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows (..., n, m, p), zero where an output does not depend on a parameter."""
        parts = [model.regressors(stimulus) for model in self.models]
        rows = empty_as(parts[0], (*parts[0].shape[:-2], self.outputs, len(self.parameters)))
        rows[...] = 0.0
        for part, (outputs, own) in zip(parts, self._blocks, strict=True):
            rows[..., outputs, own] = part
        return rows

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows, (..., n, m, p, 3)."""
        derivatives: dict[str, Array] = {}
        for model, (outputs, own) in zip(self.models, self._blocks, strict=True):
            for name, part in model.derivative(stimulus).quantities():
                if name not in derivatives:
                    shape = (*part.shape[:-3], self.outputs, len(self.parameters), part.shape[-1])
                    derivatives[name] = empty_as(part, shape)
                    derivatives[name][...] = 0.0
                derivatives[name][..., outputs, own, :] = part
        return Stimulus(**derivatives)

    def information(self, stimulus: Stimulus) -> Information:
        """Block-diagonal matrices (..., p, p), a block for each part."""
        return self._on_the_diagonal([model.information(stimulus) for model in self.models])

    def information_of(self, regressors: Array) -> Information:
        """Block-diagonal information of programs whose rows (..., n, m, p) are there already."""
        parts = zip(self.models, self._blocks, strict=True)
        return self._on_the_diagonal([model.information_of(regressors[..., out, own]) for model, (out, own) in parts])

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the rows, (..., n, m, p), to the stimulus, (..., n, 3), summed over parts."""
        total: dict[str, Array] = {}
        for model, (outputs, own) in zip(self.models, self._blocks, strict=True):
            for name, part in model.pull(stimulus, rows[..., outputs, own]).quantities():
                total[name] = total[name] + part if name in total else part
        return Stimulus(**total)

    def _on_the_diagonal(self, parts: Sequence[Information]) -> Information:
        p = len(self.parameters)
        matrix = np.zeros((*parts[0].matrix.shape[:-2], p, p))
        for part, (_, own) in zip(parts, self._blocks, strict=True):
            matrix[..., own, own] = part.matrix
        return Information(matrix, self.parameters)

    @cached_property
    def _blocks(self) -> tuple[tuple[slice, slice], ...]:
        """Outputs and parameters of each part."""
        outputs = np.cumsum([0, *(model.outputs for model in self.models)]).tolist()
        parameters = np.cumsum([0, *(len(model.parameters) for model in self.models)]).tolist()
        return tuple(zip(starmap(slice, pairwise(outputs)), starmap(slice, pairwise(parameters)), strict=True))


@final
@dataclass(frozen=True)
class Joined(Composite):
    """Any models read at the same positions.

    Parameters
    ----------
    parts : sequence of Model
        Without common parameter names.

    Raises
    ------
    ArgumentError
        No models, or a parameter that two of them have.
    """

    parts: Sequence[Model]

    def __post_init__(self) -> None:
        if not isinstance(self.parts, Sequence) or not self.parts or not all(isinstance(p, Model) for p in self.parts):
            raise ArgumentError.of("parts", self.parts, "give a list of one or more models")
        keep(self, "parts")
        names = [parameter.name for parameter in self.parameters]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ArgumentError(f"joined models have the same parameters: {', '.join(twice)}; each needs its own")

    @property
    def models(self) -> tuple[Model, ...]:
        """The joined models, one for each sensor, in the order in which their parameters come."""
        return tuple(self.parts)
