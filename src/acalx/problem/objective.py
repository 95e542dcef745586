"""How good programs are, and which way they get better: settings to loss, and its gradient back to the settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from acalx.criteria import Criterion
from acalx.criteria.answers import gradient_of, loss_of
from acalx.models import Model
from acalx.models.jacobian import Jacobian
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.stimulus import Stimulus

__all__ = ["Linearization", "Objective", "Placement", "Response"]

# Entries that are so small beside the largest of their output are rounding.
_ROUNDING = 1e-13
# Regressors of at most this many bytes are computed at a time: large enough that calls don't
# count, small enough that the C library keeps the memory instead of asking for fresh pages at
# each call, which would take as long as the arithmetic; and a bound on memory.
_CHUNK_BYTES = 2**18


class Placement(Protocol):
    """What variables make a sensor feel: a stand its settings, or the rotations of a given program."""

    def stimulus(self, settings: Array) -> Stimulus:
        """What is felt, for variables (..., n, d)."""

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        """From a gradient with respect to the stimulus to one with respect to the variables, (..., n, d)."""


@dataclass(frozen=True)
class Response:
    """What settings show of the parameters of a sensor.

    Parameters
    ----------
    place : Placement
        As a rule a stand.
    model : Model
    dwell_s : float, s
        Time in each position, where the model asks for it and the stand does not say.
    """

    place: Placement
    model: Model
    dwell_s: float = 60.0

    def stimulus(self, settings: Array) -> Stimulus:
        """What is felt in positions (..., n, d), with times where the model needs them."""
        return self.place.stimulus(settings).timed(self.model.needs, self.dwell_s)

    def information(self, settings: Array) -> Information:
        """Information of programs: settings (..., n, d) in rad to matrices (..., p, p)."""
        return self.model.information(self.stimulus(settings))

    def regressors(self, settings: Array) -> Array:
        """Rows (..., n, m, p) of positions (..., n, d)."""
        return self.model.regressors(self.stimulus(settings))

    def at(self, settings: Array) -> Linearization:
        """Programs (..., n, d), kept with what the chain rule needs."""
        stimulus = self.stimulus(settings)
        return Linearization(self, settings, self.model.jacobian(stimulus))

    def chunk(self, n: int) -> int:
        """How many programs of n positions are worked on at a time."""
        return max(1, _CHUNK_BYTES // (n * self.model.entries * 8))


@dataclass(frozen=True, eq=False)
class Linearization:
    """Programs with their Jacobian, ready to pull a gradient back to the settings."""

    response: Response
    settings: Array
    jacobian: Jacobian

    @property
    def information(self) -> Information:
        """Of the programs, matrices (..., p, p)."""
        return self.jacobian.information

    def pull(self, gradient: Array) -> Array:
        """From a gradient G with respect to the matrix, (..., p, p), to the settings, (..., n, d).

        2 H G to the regressors, the model's derivative to the stimulus, the stand's to the settings.
        """
        pulled = self.jacobian.stimulus.untimed(self.jacobian.pull(gradient))
        return self.response.place.pull(self.settings, pulled)


@dataclass(frozen=True)
class Objective:
    """The loss of programs by one criterion.

    Parameters
    ----------
    response : Response
    criterion : Criterion
    """

    response: Response
    criterion: Criterion

    def loss(self, settings: Array) -> Array:
        """Loss of programs, +inf where singular: settings (..., n, d) in rad to (...).

        Raises
        ------
        PluginError
            Where a criterion raises or returns something other than one number a program.
        """
        *stack, n, d = settings.shape
        if len(stack) != 1:
            return self.loss(settings.reshape((-1, n, d))).reshape(stack)
        pieces = -(-len(settings) // self.response.chunk(n))
        size = max(1, -(-len(settings) // max(1, pieces)))
        losses = np.empty(stack)
        for start in range(0, len(settings), size):
            part = settings[start : start + size]
            if len(part) > n:  # arithmetic runs along the longer axis
                part = np.asfortranarray(part)
            losses[start : start + size] = loss_of(self.criterion, self.response.information(part))
        return losses

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        """Loss (...) and its gradient (..., n, d) with respect to the settings in rad."""
        at = self.response.at(settings)
        return loss_of(self.criterion, at.information), at.pull(gradient_of(self.criterion, at.information))


def comparable(rows: Array) -> Array:
    """Rows of positions (n, m, p) as (n, m p), about 1 whatever the units: to compare what the sensor feels.

    Each entry is in units of the largest among these positions, to a power of two, which changes
    no digit; what is rounding beside the others of its output stays small.
    """
    largest = np.abs(rows).max(axis=0)  # (m, p): noises of sensors differ, and units of parameters
    of_output = largest.max(axis=1, keepdims=True)
    largest = np.where(largest > _ROUNDING * of_output, largest, of_output)
    units = 2.0 ** np.round(np.log2(np.where(largest > 0.0, largest, 1.0)))
    return np.asarray((rows / units).reshape(len(rows), -1))
