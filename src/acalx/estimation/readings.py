"""What a sensor read in a number of positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import DataError
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Readings"]


@final
@dataclass(frozen=True, eq=False)
class Readings:
    """Means of the readings of a sensor in n positions.

    Parameters
    ----------
    name : str
        Where they come from, for messages.
    means : array (n, k), in the sensor's unit
        Of its k channels, three of a triad.
    deviations : array (n, k), optional
        Standard deviations of the samples of each mean.
    counts : array (n,), optional
        Numbers of the samples.
    stimulus : Stimulus of arrays (n, width), optional
        What is known of what the sensor felt: the vertical in its axes, rates, a temperature.
    labels : tuple of str, length n, optional
        What the file calls the positions; without it they are called 1, 2, ...

    Raises
    ------
    DataError
        No positions, other shapes, numbers that are not finite.
    """

    name: str
    means: Array
    deviations: Array | None = None
    counts: Array | None = None
    stimulus: Stimulus | None = None
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for what in ("means", "deviations", "counts"):
            if (given := getattr(self, what)) is not None:
                object.__setattr__(self, what, _own(self.name, what, given))
        if self.means.ndim != 2 or 0 in self.means.shape:
            raise DataError(
                f"{self.name}: means of shape {self.means.shape}, expected (n, k), k channels of n positions"
            )
        n, k = self.means.shape
        felt = {} if self.stimulus is None else dict(self.stimulus)
        known = {name: (value, (n, *np.shape(value)[1:])) for name, value in felt.items()}
        own = {"means": (self.means, (n, k)), "deviations": (self.deviations, (n, k)), "counts": (self.counts, (n,))}
        for what, (array, shape) in {**own, **known}.items():
            if array is not None and (array.shape != shape or not np.isfinite(array).all()):
                raise DataError(f"{self.name}: {what} must be finite numbers of shape {shape}, got {array.shape}")
        if not self.labels:
            object.__setattr__(self, "labels", tuple(str(k + 1) for k in range(n)))

    @classmethod
    def of(cls, given: Readings | Array, name: str = "readings") -> Readings:
        """Readings as they are, or from an array (n, 3) of means that gets a name for messages."""
        return given if isinstance(given, Readings) else cls(name, given)

    @property
    def n(self) -> int:
        """Number of positions that the sensor was read in."""
        return len(self.means)

    def select(self, positions: Sequence[int] | np.ndarray) -> Readings:
        """The positions of these indices, with all that is known of them."""
        chosen = np.asarray(positions)
        deviations, counts = (None if array is None else array[chosen] for array in (self.deviations, self.counts))
        felt = self.stimulus
        known = None if felt is None else felt.made({name: value[chosen] for name, value in felt.items()})
        labels = tuple(self.labels[k] for k in chosen)
        return Readings(self.name, self.means[chosen], deviations, counts, known, labels)


def _own(name: str, what: str, given: object) -> Array:
    """A copy of what was given, as numbers."""
    try:
        return np.array(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise DataError(f"{name}: {what} must be numbers; {error}") from error
