"""What of a sensor's readings is held against what is known: the interface, and the readings themselves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError
from acalx.models.standins import Faultless
from acalx.models.table import Entry
from acalx.numerics.arrays import Array
from acalx.options import keep
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["Comparison", "Outputs", "Residual", "Together", "anything"]


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
        """Whether it asks what was felt, of which a position must have one and not a motion; by default it does."""
        return True

    @property
    def of_readings(self) -> bool:
        """Whether the residuals are those of the readings, channel by channel."""
        return False

    def lengths(self, sensor: Sensor) -> Mapping[str, float]:
        """Vectors whose length it takes as known, with that length in the unit in which the sensor takes them."""
        return {}

    def entries(self, sensor: Sensor, noise: Array) -> list[Entry] | None:
        """The rows of a sensor without errors over noise (k,) as a table of products; None, the default: as `rows`."""
        return None

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

    @property
    def at_once(self) -> bool:
        """A reading may be a mean along a motion."""
        return False

    @property
    def of_readings(self) -> bool:
        """These are the readings."""
        return True

    def entries(self, sensor: Sensor, noise: Array) -> list[Entry] | None:
        """The sensor's own table, where it has one."""
        if sensor.table is None:
            return None
        return [(channel, number, factor / noise[channel], words) for channel, number, factor, words in sensor.table]

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
        """Refuse what one of them refuses, and comparisons of which one follows from the others."""
        for each in self.comparisons:
            each.check(sensor)
        if not self._independent(sensor):
            raise CompatibilityError(
                f"{', '.join(type(each).__name__ for each in self.comparisons)} together count {self.count(sensor)} "
                f"residuals of the {len(sensor.channels)} readings of {type(sensor).__name__}, of which some follow "
                "from the others: leave out what says nothing of its own"
            )

    def _independent(self, sensor: Sensor) -> bool:
        """Whether each residual has noise that the others don't have, where anything may be felt."""
        if self.count(sensor) > len(sensor.channels):
            return False
        by_readings = self.rows(sensor, anything(sensor, 3)).by_readings
        scaled = by_readings * np.array([channel.noise for channel in sensor.channels])
        scaled = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
        return not np.isfinite(scaled).all() or bool((np.linalg.matrix_rank(scaled) == self.count(sensor)).any())

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

    def lengths(self, sensor: Sensor) -> Mapping[str, float]:
        """What any of them takes as known."""
        return {name: length for each in self.comparisons for name, length in each.lengths(sensor).items()}

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


def anything(sensor: Sensor, n: int) -> Stimulus:
    """What no stand does in particular: so many random positions in the units that a sensor takes."""
    rng = np.random.default_rng(0)
    widths = {name: sensor.width(name) for name in sensor.needs}
    felt = {name: rng.standard_normal((n, width)) for name, width in widths.items()}
    positive = {name: value if widths[name] > 1 else 1.0 + np.abs(value) for name, value in felt.items()}
    return Stimulus(positive, units=sensor.needs)
