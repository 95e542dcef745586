"""The interface of a measurement model: which parameters, and the regressors that show them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Protocol

import numpy as np

from acalx.errors import CompatibilityError, Option
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus

__all__ = ["Model"]


class _Stand(Protocol):
    """What a model asks of an `acalx.stands.Stand`."""

    def advice(self, quantity: str) -> tuple[str, Mapping[str, Option]]: ...


class Model(ABC):
    """A sensor with p error parameters and m outputs in each position, linear in the parameters.

    A new model gives `parameters`, `outputs`, `needs` and `regressors`; the derivative is then
    numerical until it is given exactly. Concrete models are frozen dataclasses.
    """

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """The p parameters, in the order of the regressors."""

    @property
    @abstractmethod
    def needs(self) -> tuple[str, ...]:
        """Names of the quantities of the stimulus that the regressors read."""

    @property
    def outputs(self) -> int:
        """Number m of outputs in a position."""
        return 1

    @property
    def kind(self) -> str:
        """What sensors like it are called; those of a kind are designed for together."""
        return type(self).__name__

    @property
    def degree(self) -> int | None:
        """Degree of the regressors as polynomials in the stimulus; None if they are none."""
        return None

    @property
    def smallest_n(self) -> int:
        """The fewest positions that can determine all the parameters."""
        return -(-len(self.parameters) // self.outputs)

    @property
    def entries(self) -> int:
        """Number of entries of the rows of a position that are not zero in every position; m p, or fewer."""
        return self.outputs * len(self.parameters)

    @abstractmethod
    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows h of H, (..., n, m, p), each divided by the noise standard deviation of its output."""

    def measurement(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Noise-free readings (..., n, k) of a sensor with these parameters (..., p).

        The default is the linear model: the m outputs, each in units of its noise. A model of
        which the regressors are only the linear part gives the whole.
        """
        return np.asarray((self.regressors(stimulus) @ parameters[..., None, :, None])[..., 0])

    def information(self, stimulus: Stimulus) -> Information:
        """Information of programs, matrices (..., p, p)."""
        return self.information_of(self.regressors(stimulus))

    def information_of(self, regressors: Array) -> Information:
        """Information of programs whose rows (..., n, m, p) are there already."""
        return Information.from_regressors(regressors, self.parameters)

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the regressors with respect to the stimulus, arrays (..., n, m, p, 3).

        The default differentiates `regressors` numerically, by central differences.
        """
        step = 1e-5
        derivatives = {}
        for name in self.needs:
            value = getattr(stimulus, name)
            columns = []
            for k in range(value.shape[-1]):
                shift = np.zeros(value.shape[-1])
                shift[k] = step
                above = self.regressors(replace(stimulus, **{name: value + shift}))
                below = self.regressors(replace(stimulus, **{name: value - shift}))
                columns.append((above - below) / (2 * step))
            derivatives[name] = np.stack(columns, axis=-1)
        return Stimulus(**derivatives)

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the regressors, (..., n, m, p), to the stimulus, (..., n, 3)."""
        by_stimulus = self.derivative(stimulus).quantities()
        return Stimulus(**{name: np.einsum("...nmp,...nmpk->...nk", rows, each) for name, each in by_stimulus})

    def check(self, stimulus: Stimulus, stand: _Stand) -> None:
        """Raise CompatibilityError where the stand does not provide what the model needs."""
        known = [field.name for field in fields(Stimulus)]
        for name in self.needs:
            if name not in known or getattr(stimulus, name) is None:
                advice, options = stand.advice(name)
                raise CompatibilityError(
                    "model {model} needs the {quantity}, which stand {stand} does not provide" + advice,
                    model=type(self).__name__,
                    quantity=name.replace("_", " "),
                    stand=type(stand).__name__,
                    **options,
                )
