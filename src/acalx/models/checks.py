"""Whether a sensor reads what a stand does to it as it must, and lets be compared what is to be."""

from __future__ import annotations

import numpy as np

from acalx.errors import CompatibilityError, Option
from acalx.models.comparisons import Comparison
from acalx.models.contract import check_sensor
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["check_compared"]

# Relative; a length that is off by as much adds as much to scales, far below what anyone calibrates to.
_SLACK = 1e-6


def check_compared(sensor: Sensor, comparison: Comparison, stimulus: Stimulus, stand: str) -> None:
    """Look at a sensor in what is felt on a stand, and at whether a comparison can be had of it.

    Parameters
    ----------
    sensor : Sensor
    comparison : Comparison
    stimulus : Stimulus
        In some positions, with all that the sensor needs.
    stand : str
        What messages call it.

    Raises
    ------
    PluginError
        A sensor that does not give what it must.
    CompatibilityError
        A comparison that can't be had there.
    """
    felt = stimulus.timed(sensor.needs, 1.0).in_units(sensor.needs)
    check_sensor(sensor, felt.without_samples())
    kind = type(comparison).__name__
    if comparison.at_once and stimulus.weights is not None:
        raise CompatibilityError(
            "what {sensor} feels changes within a position of stand {stand}, of which {kind} needs one: compare its "
            "readings themselves, by Outputs, or take a stand that is at rest, or does not average",
            sensor=type(sensor).__name__,
            stand=stand,
            kind=kind,
        )
    for name, length in comparison.lengths(sensor).items():
        lengths = np.linalg.norm(felt.mean()[name], axis=-1)
        wrong = np.abs(lengths - length) > _SLACK * length
        if wrong.any():
            raise CompatibilityError(
                "{kind} takes the length of the {quantity} for {known:.4g}, but on stand {stand} it is {length:.4g}: "
                "compare the readings of {sensor} themselves, by Outputs, or lengths that differ, by Magnitude with "
                "{varies}",
                kind=kind,
                quantity=name.replace("_", " "),
                stand=stand,
                known=length,
                length=float(lengths[wrong].ravel()[0]),
                sensor=type(sensor).__name__,
                varies=Option("varies", True),
            )
    if comparison.at_once:
        _check_known(sensor, comparison, felt, stand)


def _check_known(sensor: Sensor, comparison: Comparison, felt: Stimulus, stand: str) -> None:
    """Refuse a comparison that leaves something of a sensor without errors: an angle that is another on the stand."""
    with np.errstate(all="ignore"):
        left = np.abs(comparison.rows(sensor, felt).value)
    if (left > _SLACK * max([1.0, *comparison.lengths(sensor).values()])).any():
        raise CompatibilityError(
            f"{type(comparison).__name__} leaves {np.nanmax(left):.3g} of a {type(sensor).__name__} without errors on "
            f"stand {stand}: what is taken as known, such as an angle, is something else there; put it right in one or "
            "the other"
        )
