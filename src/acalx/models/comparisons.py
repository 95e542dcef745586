"""What of a sensor's readings is held against what is known: the interface, and the readings themselves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from acalx.errors import ArgumentError
from acalx.models.standins import Faultless
from acalx.numerics.arrays import Array
from acalx.options import keep
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["Comparison", "Outputs", "Residual", "Together"]


class Residual(NamedTuple):
    """What parameters leave of a comparison.

    Parameters
    ----------
    value : array (..., n, m)
        Zero for readings without noise of a sensor with these parameters.
    rows : array (..., n, m, p)
        What a parameter adds to it: value = rows (true - assumed), to first order.
    by_readings : array (..., n, m, k), or None
        Its derivatives by the readings, of a sensor without errors, which make their noise its noise; None where it is
        the readings themselves.
    """

    value: Array
    rows: Array
    by_readings: Array | None


class Comparison(ABC):
    """What of the readings is compared; m numbers a position.

    A new one gives `check`, `count` and `residual`. Concrete comparisons are frozen dataclasses.
    """

    @abstractmethod
    def check(self, sensor: Sensor) -> None:
        """Raise CompatibilityError where the sensor's readings do not have what is compared."""

    @abstractmethod
    def count(self, sensor: Sensor) -> int:
        """Number m of residuals in a position."""

    @abstractmethod
    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """What parameters (..., p) leave of it, with readings (..., n, k) and what is known of the positions.

        `known` has the quantities that were known, in the sensor's units; None where nothing was.
        """

    def knows(self, sensor: Sensor) -> tuple[str, ...]:
        """Quantities that must be known of each position; by default all that the readings depend on."""
        return tuple(sensor.needs)

    @property
    def by_length(self) -> bool:
        """Whether it holds a length against one that is the same in all positions: readings lie on a sphere, nearly."""
        return False

    @property
    def at_once(self) -> bool:
        """Whether it asks what was felt, of which a position must have one and not a motion."""
        return False

    def of_length_one(self, sensor: Sensor) -> tuple[str, ...]:
        """Vectors whose length it takes for 1, in the unit of the stimulus."""
        return ()

    def rows(self, sensor: Sensor, stimulus: Stimulus) -> Residual:
        """The residual of a sensor without errors or noise, and its rows there."""
        nominal = sensor.nominal
        return self.residual(Faultless(sensor, stimulus), nominal, sensor.readings(nominal, stimulus), stimulus)


@final
@dataclass(frozen=True)
class Outputs(Comparison):
    """The readings themselves, against those that are predicted: the attitude is known.

    Source: IEEE Std 1293-2018, multipoint tests.
    """

    def check(self, sensor: Sensor) -> None:
        """Every sensor has outputs."""

    def count(self, sensor: Sensor) -> int:
        """As many as there are channels."""
        return len(sensor.channels)

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """W - f(X, s), and the derivatives of f."""
        assert known is not None  # `knows` says all of it
        value = readings - sensor.readings(parameters, known)
        return Residual(value, sensor.by_parameters(parameters, known), None)


@final
@dataclass(frozen=True)
class Together(Comparison):
    """Several comparisons of the same readings at once, as two magnitudes and an angle.

    Parameters
    ----------
    comparisons : sequence of Comparison

    Raises
    ------
    ArgumentError
        None at all, or something else.
    """

    comparisons: Sequence[Comparison]

    def __post_init__(self) -> None:
        given = self.comparisons
        if not isinstance(given, Sequence) or not given or not all(isinstance(each, Comparison) for each in given):
            raise ArgumentError.of("comparisons", given, "give a list of one or more comparisons")
        keep(self, "comparisons")

    def check(self, sensor: Sensor) -> None:
        """Refuse what one of them refuses."""
        for each in self.comparisons:
            each.check(sensor)

    def count(self, sensor: Sensor) -> int:
        """As many as all of them have."""
        return sum(each.count(sensor) for each in self.comparisons)

    def knows(self, sensor: Sensor) -> tuple[str, ...]:
        """What any of them must know."""
        return tuple(dict.fromkeys(name for each in self.comparisons for name in each.knows(sensor)))

    @property
    def at_once(self) -> bool:
        """Where one of them does."""
        return any(each.at_once for each in self.comparisons)

    def of_length_one(self, sensor: Sensor) -> tuple[str, ...]:
        """What any of them does."""
        return tuple(dict.fromkeys(name for each in self.comparisons for name in each.of_length_one(sensor)))

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """Their residuals side by side."""
        parts = [each.residual(sensor, parameters, readings, known) for each in self.comparisons]
        k = len(sensor.channels)
        shape = np.broadcast_shapes(*(part.value.shape[:-1] for part in parts))
        p = parts[0].rows.shape[-1]

        def side(arrays: list[Array], *own: int) -> Array:
            spread = [np.broadcast_to(a, (*shape, a.shape[-1 - len(own)], *own)) for a in arrays]
            return np.concatenate(spread, axis=-1 - len(own))

        by_readings = [np.eye(k) if part.by_readings is None else part.by_readings for part in parts]
        return Residual(
            side([part.value for part in parts]), side([part.rows for part in parts], p), side(by_readings, k)
        )
