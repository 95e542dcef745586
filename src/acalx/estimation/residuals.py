"""What of readings is compared with the model: the magnitude of gravity, W . eta, or outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import CompatibilityError, DataError, Option
from acalx.models import Model, ScalarAccel
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Magnitude", "Oriented", "Outputs", "Residual"]


class Residual(ABC):
    """What of a reading is compared with the model.

    A new one gives `needs_directions`, `check`, `linearized` and `at`.
    """

    @abstractmethod
    def check(self, model: Model) -> None:
        """Raise CompatibilityError where the model does not have this residual."""

    @property
    @abstractmethod
    def needs_directions(self) -> bool:
        """Whether the vertical in sensor axes must be known."""

    @abstractmethod
    def linearized(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """J and the rows h of its linear model at zero errors.

        Parameters
        ----------
        model : Model
        measurement : array (..., n, 3), in g
        stimulus : arrays (n, 3) or (..., n, 3), optional
            The vertical, where it is known.

        Returns
        -------
        J, array (..., n), and rows, array (n, p) or (..., n, p)
        """

    @abstractmethod
    def at(self, model: Model, parameters: Array, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """What is left of J, exactly, once errors (..., p) are taken off, and the rows there."""


@final
@dataclass(frozen=True)
class Magnitude(Residual):
    """J = |W| / |g| - 1. The orientation need not be known; the linear model uses it where it is."""

    def check(self, model: Model) -> None:
        """Refuse a model other than `ScalarAccel`: only a triad in gravity has a magnitude to compare."""
        _scalar(model)

    @property
    def needs_directions(self) -> bool:
        """False: |W| is the same whichever way the sensor lies."""
        return False

    def linearized(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """|W| - 1 and its rows; where the orientation is not known, the direction that was read is taken for it."""
        if stimulus is None:
            lengths = np.sqrt((measurement * measurement).sum(axis=-1, keepdims=True))
            stimulus = Stimulus(specific_force=measurement / lengths)
        return _scalar(model).residual_magnitude(measurement), model.regressors(stimulus)[..., 0, :]

    def at(self, model: Model, parameters: Array, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """|inv(A) (W - bias)| - 1, array (..., n), and its derivatives by the parameters, (..., n, p)."""
        return _scalar(model).magnitude_at(parameters, measurement)


@final
@dataclass(frozen=True)
class Oriented(Residual):
    """J = W . eta / |g| - 1, which is linear in the errors: as good as the knowledge of eta, the vertical."""

    def check(self, model: Model) -> None:
        """Refuse a model other than `ScalarAccel`, as W . eta is its specific force along the vertical."""
        _scalar(model)

    @property
    def needs_directions(self) -> bool:
        """True: eta is what the readings are projected on."""
        return True

    def linearized(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """W . eta - 1 and its rows, which are exact whatever the errors are; DataError where eta is not known."""
        if stimulus is None:
            raise DataError(
                "the residual W . eta needs the direction of the vertical in each position: "
                "give it in columns eta_x, eta_y, eta_z or alpha1_deg, alpha2_deg, or take the magnitude"
            )
        return _scalar(model).residual_oriented(measurement, stimulus), model.regressors(stimulus)[..., 0, :]

    def at(self, model: Model, parameters: Array, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """What the parameters leave of W . eta - 1, J - h X, and the same rows."""
        residual, rows = self.linearized(model, measurement, stimulus)
        return residual - np.einsum("...np,...p->...n", rows, parameters), rows


@final
@dataclass(frozen=True)
class Outputs(Residual):
    """The outputs themselves, of a model that is linear in its parameters; the attitude must be known."""

    def check(self, model: Model) -> None:
        """Refuse `ScalarAccel`; of other models the measurement is the regressors times the parameters."""
        if isinstance(model, ScalarAccel):
            raise CompatibilityError(
                "the outputs of ScalarAccel are not linear in its parameters: "
                "take the magnitude of gravity, as in {instead}",
                instead=Option("estimator", "iterated", "Iterated()"),
            )

    @property
    def needs_directions(self) -> bool:
        """True: what an output should be follows from the attitude."""
        return True

    def linearized(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """Outputs (..., n m) and their rows (n m, p) or (..., n m, p)."""
        if stimulus is None:
            raise DataError("the outputs of a sensor say nothing of its parameters where its attitude is not known")
        rows = model.regressors(stimulus)
        *stack, n, m, p = rows.shape
        return measurement.reshape((*measurement.shape[:-2], n * m)), rows.reshape((*stack, n * m, p))

    def at(self, model: Model, parameters: Array, measurement: Array, stimulus: Stimulus | None) -> tuple[Array, Array]:
        """Outputs less rows times parameters, (..., n m), and the rows."""
        residual, rows = self.linearized(model, measurement, stimulus)
        return residual - np.einsum("...np,...p->...n", rows, parameters), rows


def _scalar(model: Model) -> ScalarAccel:
    """The model, if it has a magnitude of gravity to compare."""
    if not isinstance(model, ScalarAccel):
        raise CompatibilityError(
            "model {model} has no magnitude of gravity to compare: its readings are outputs "
            "that are linear in its parameters, for {instead}",
            model=type(model).__name__,
            instead=Option("estimator", "outputs", "Linear(residual=Outputs())"),
        )
    return model
