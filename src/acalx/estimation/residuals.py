"""The two forms of the residual: with the orientation known, and without it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.arrays import Array
from acalx.errors import DataError
from acalx.models import ScalarAccel
from acalx.stimulus import Stimulus

__all__ = ["Magnitude", "Oriented", "Residual"]


class Residual(ABC):
    """What of a reading is compared with gravity."""

    @property
    @abstractmethod
    def needs_directions(self) -> bool:
        """Whether the vertical in sensor axes must be known."""

    @abstractmethod
    def linearized(self, model: ScalarAccel, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """J and the rows h of its linear model at zero errors.

        Parameters
        ----------
        model : ScalarAccel
        measurement : array (..., n, 3), in g
        stimulus : arrays (n, 3) or (..., n, 3), optional
            The vertical, where it is known.

        Returns
        -------
        J, array (..., n), and rows, array (n, p) or (..., n, p)
        """

    @abstractmethod
    def at(
        self, model: ScalarAccel, parameters: Array, measurement: Array, stimulus: Stimulus | None
    ) -> tuple[Array, Array]:
        """What is left of J, exactly, once errors (..., p) are taken off, and the rows there."""


@final
@dataclass(frozen=True)
class Magnitude(Residual):
    """J = |W| / |g| - 1. The orientation need not be known; the linear model uses it where it is."""

    @property
    def needs_directions(self) -> bool:
        """No."""
        return False

    def linearized(self, model: ScalarAccel, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """Without the orientation rows are those of the direction that was read."""
        if stimulus is None:
            lengths = np.sqrt((measurement * measurement).sum(axis=-1, keepdims=True))
            stimulus = Stimulus(specific_force=measurement / lengths)
        return model.residual_magnitude(measurement), model.regressors(stimulus)[..., 0, :]

    def at(
        self, model: ScalarAccel, parameters: Array, measurement: Array, stimulus: Stimulus | None
    ) -> tuple[Array, Array]:
        """|inv(A) (W - bias)| - 1."""
        return model.magnitude_at(parameters, measurement)


@final
@dataclass(frozen=True)
class Oriented(Residual):
    """J = W . eta / |g| - 1, which is linear in the errors: as good as the knowledge of eta, the vertical."""

    @property
    def needs_directions(self) -> bool:
        """Yes."""
        return True

    def linearized(self, model: ScalarAccel, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """Exact, whatever the errors are."""
        if stimulus is None:
            raise DataError(
                "the residual W . eta needs the direction of the vertical in each position: "
                "give it in columns eta_x, eta_y, eta_z or alpha1_deg, alpha2_deg, or take the magnitude"
            )
        return model.residual_oriented(measurement, stimulus), model.regressors(stimulus)[..., 0, :]

    def at(
        self, model: ScalarAccel, parameters: Array, measurement: Array, stimulus: Stimulus | None
    ) -> tuple[Array, Array]:
        """J - h X."""
        residual, rows = self.linearized(model, measurement, stimulus)
        return residual - np.einsum("...np,...p->...n", rows, parameters), rows
