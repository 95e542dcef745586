"""The order in which the positions of a program are visited, and how long that takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.numerics.routes import MOST_EXACT, shortest_route
from acalx.options import is_number
from acalx.stands import Stand

__all__ = ["ORDERS", "Itinerary", "check_order", "itinerary", "shorter"]

_MOST_SORTED = 500
# With more it takes too long to say in passing what the shortest order would need.
_MOST_LOOKED_AT = 100
# Of two ways that take as long, the one with less travel.
_TRAVEL_WEIGHT = 1e-6


@final
@dataclass(frozen=True, eq=False)
class Itinerary:
    """Positions in the order of visit.

    All axes of the stand turn at the same time, so that a move takes as long as the slowest of
    them; an angle that goes all around takes the shorter way.

    Parameters
    ----------
    stand : Stand
    settings : array (n, d), in rad or the SI unit
    """

    stand: Stand
    settings: Array

    @property
    def travel(self) -> float:
        """Sum of what all the angles turn by, in rad."""
        moves = _between(self.stand, self.settings[:-1], self.settings[1:])
        angles = [setting.unit.turn is not None for setting in self.stand.settings]
        return float(moves[:, angles].sum())

    @property
    def seconds(self) -> float:
        """Time that the moves between the positions take, in s, without that spent in them."""
        moves = _between(self.stand, self.settings[:-1], self.settings[1:])
        return float((moves / self.stand.speeds).max(axis=1).sum())

    def entries(self, dwell_s: float) -> dict[str, float]:
        """Travel and total time, where the table stays so many seconds in each position, for a file."""
        total = self.seconds + dwell_s * len(self.settings)
        return {"travel_deg": math.degrees(self.travel), "travel_s": self.seconds, "total_s": total}

    def summary(self, dwell_s: float) -> str:
        """Travel and times of `entries` as a sentence for whoever reads the terminal."""
        entries = self.entries(dwell_s)
        return (
            f"the table turns by {entries['travel_deg']:.0f} degrees in {entries['travel_s']:.0f} s; "
            f"{entries['total_s']:.0f} s in all with {dwell_s:g} s in each position"
        )


def itinerary(stand: Stand, settings: Array, order: str, rng: np.random.Generator, held: int = 0) -> Itinerary:
    """Put positions into the order of visit.

    Parameters
    ----------
    stand : Stand
        Its `speeds` say how long a move takes, its `equivalents` which settings are as good.
    settings : array (n, d)
    order : str
        ``given``; ``random``, so that no drift favours some parameters; ``shortest``, the least
        time on the way, proved for up to 12 positions and by local search from several starts for
        more. It may take other settings for the same attitude.
    rng : numpy Generator
    held : int
        So many first positions stay where they are.

    Raises
    ------
    ArgumentError
        An order that there isn't; too many positions to sort.
    """
    check_order(order, free=len(settings) - held)
    return Itinerary(stand, np.concatenate([settings[:held], ORDERS[order](stand, settings, held, rng)]))


def shorter(visit: Itinerary, order: str, dwell_s: float, held: int = 0) -> str:
    """A remark on a given order that is on the way for longer than in the positions; empty where none is much shorter.

    Parameters
    ----------
    visit : Itinerary
    order : str
        That was asked for.
    dwell_s : float
        In each position.
    held : int
        So many first positions stay where they are.
    """
    way, n = visit.seconds, len(visit.settings)
    if order != "given" or n > _MOST_LOOKED_AT or way < dwell_s * n:
        return ""
    least = itinerary(visit.stand, visit.settings, "shortest", np.random.default_rng(0), held).seconds
    return f"most of the time is on the way; order=shortest makes that {least:.0f} s" if least < 0.5 * way else ""


def check_order(order: object, dwell_s: object = 0.0, free: int = 0, *, ordered: bool = False) -> None:
    """Raise ArgumentError for an order that there isn't, a time that is none, or too many free positions to sort."""
    if not isinstance(order, str) or order not in ORDERS:
        raise ArgumentError.of("order", order, f"the order of visit is {', '.join(ORDERS)}")
    if not is_number(dwell_s) or dwell_s < 0.0:
        raise ArgumentError.of("dwell_s", dwell_s, "give the seconds in each position, 0 or more")
    if ordered and order != "given":
        raise ArgumentError.of("order", order, "the model depends on the order of the positions, which must be given")
    if order == "shortest" and free > _MOST_SORTED:
        raise ArgumentError.of("order", order, f"{free} positions are too many to sort; {_MOST_SORTED} are the most")


def _given(stand: Stand, settings: Array, held: int, rng: np.random.Generator) -> Array:
    return settings[held:]


def _random(stand: Stand, settings: Array, held: int, rng: np.random.Generator) -> Array:
    return rng.permutation(settings[held:])


def _shortest(stand: Stand, settings: Array, held: int, rng: np.random.Generator) -> Array:
    free = settings[held:]
    nodes = stand.equivalents(free)  # (k, n, d)
    ways = nodes.reshape(-1, nodes.shape[-1])
    costs = _cost(stand, ways[:, None, :], ways[None, :, :])
    costs = costs if len(free) <= MOST_EXACT else 0.5 * (costs + costs.T)  # beyond, ways there and back are taken alike
    first = _cost(stand, settings[held - 1], ways) if held else np.zeros(len(ways))
    return np.asarray(ways[shortest_route(costs, first, len(free), rng)])


ORDERS: Mapping[str, Callable[[Stand, Array, int, np.random.Generator], Array]] = MappingProxyType(
    {"given": _given, "random": _random, "shortest": _shortest}
)


def _cost(stand: Stand, start: Array, end: Array) -> Array:
    """Seconds of moves, (...), with a little for the travel of all axes."""
    seconds = _between(stand, start, end) / stand.speeds
    return np.asarray(seconds.max(axis=-1) + _TRAVEL_WEIGHT * seconds.sum(axis=-1))


def _between(stand: Stand, position: Array, following: Array) -> Array:
    """By how much each setting changes between positions, (..., d); where every angle can be set, by the shorter way.

    From the end of the one to the beginning of the other.
    """
    moves = np.abs(stand.starts(following) - stand.ends(position))
    around = np.array([setting.full_turn for setting in stand.settings])
    turned = moves % (2.0 * math.pi)
    return np.where(around, np.minimum(turned, 2.0 * math.pi - turned), moves)
