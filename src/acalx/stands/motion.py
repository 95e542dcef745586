"""Samples of a motion within a position, as many as means over it need."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np

from acalx.errors import ArgumentError, Option
from acalx.numerics.arrays import Array

__all__ = ["MOST_HALF", "TOLERANCES", "Samples", "samples"]

# How far a mean over the motion may be off, of what is felt itself, of products of two of its components and of
# three: relative to their amplitudes. Second-order terms need products of two, third-order ones those of three.
TOLERANCES = (1e-8, 1e-5, 1e-3)
_FEWEST, _MOST = 4, 64
# Half of the angle, in rad, over which so many samples are enough: it is twelve turns.
MOST_HALF = 12.0 * math.pi


@final
@dataclass(frozen=True, eq=False)
class Samples:
    """When within a motion what is felt is looked at.

    Parameters
    ----------
    places : array (K,)
        From -1, its beginning, to 1, its end.
    weights : array (K,)
        Their sum is 1.
    """

    places: Array
    weights: Array

    def __len__(self) -> int:
        return len(self.places)


def samples(half: float, option: str, given: object, possible: object) -> Samples:
    """The fewest samples, by the rule of Gauss and Legendre, for a motion of up to twice this angle.

    What is felt turns by an angle h x, x from -1 to 1; its products of q components have harmonics up to exp(i q h x),
    whose mean is sin(q h) / (q h). That is met within `TOLERANCES` for every smaller angle too.

    Parameters
    ----------
    half : float, in rad
        Half of the largest angle, about all axes together.
    option : str
        What makes the motion so long.
    given, possible : object
        Its value, and one that would do.

    Raises
    ------
    ArgumentError
        A motion over more turns than can be followed.
    """
    if half > MOST_HALF * (1.0 + 1e-9):
        raise ArgumentError(
            "{given}: within a reading the sensor would turn by up to {angle:.0f} degrees, and its means are computed "
            "over {most:.0f} at most; give slower or shorter turns, as in {possible}",
            given=Option(option, given),
            angle=math.degrees(2.0 * half),
            most=math.degrees(2.0 * MOST_HALF),
            possible=Option(option, possible),
        )
    return _fewest(half)


@lru_cache(maxsize=256)
def _fewest(half: float) -> Samples:
    for count in range(_FEWEST, _MOST + 1):
        places, sizes = np.polynomial.legendre.leggauss(count)
        if all(_error(places, sizes, q * half) <= most for q, most in enumerate(TOLERANCES, 1)):
            break
    for array in (places, sizes):
        array.flags.writeable = False
    return Samples(places, sizes / 2.0)


def _error(places: Array, sizes: Array, most: float) -> float:
    """The largest error of the mean of exp(i t x) over x from -1 to 1, for t up to the most."""
    t = np.linspace(0.0, most, 200)
    exact = np.sinc(t / np.pi)
    return float(np.abs(np.cos(t[:, None] * places) @ sizes / 2.0 - exact).max())
