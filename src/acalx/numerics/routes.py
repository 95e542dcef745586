"""Shortest open routes through places that may each be entered in several ways."""

from __future__ import annotations

import itertools

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["MOST_EXACT", "exact_route", "searched_route", "shortest_route"]

MOST_EXACT = 12
_STARTS = 8
# The best route is shaken this over n^2 times, which takes about a second.
_EFFORT = 150_000
_LONGEST_MOVED = 3
_ENTERED_ANEW = 3
_NOTHING = 1e-12


def shortest_route(costs: Array, first: Array, n: int, rng: np.random.Generator) -> np.ndarray:
    """Way by which each of n places is entered, in the order of visit, (n,).

    Parameters
    ----------
    costs : array (k n, k n)
        From way to way, with more than `MOST_EXACT` places as long back; way w enters place w modulo n.
    first : array (k n,)
        Of starting with each way.
    n : int
    rng : numpy Generator
    """
    return exact_route(costs, first, n) if n <= MOST_EXACT else searched_route(costs, first, n, rng)


def exact_route(costs: Array, first: Array, n: int) -> np.ndarray:
    """The shortest route, by dynamic programming over sets of places.

    Source: Held, Karp, J. Soc. Indust. Appl. Math. 10(1), 1962, 196-210.
    """
    place = np.arange(len(costs)) % n
    bits = 1 << place
    best = np.full((1 << n, len(costs)), np.inf)
    before = np.full(best.shape, -1)
    best[bits, np.arange(len(costs))] = first
    for visited in range(1, 1 << n):
        further = np.flatnonzero((visited & bits) == 0)
        if len(further):
            through = best[visited][:, None] + costs[:, further]
            sets = visited | bits[further]
            before[sets, further] = through.argmin(axis=0)
            best[sets, further] = through.min(axis=0)
    route, visited = [], (1 << n) - 1
    way = int(best[visited].argmin())
    while way >= 0:
        route.append(way)
        way, visited = int(before[visited, way]), visited & ~int(bits[way])
    return np.array(route[::-1])


def searched_route(costs: Array, first: Array, n: int, rng: np.random.Generator) -> np.ndarray:
    """A route that no reversal and no move of a few places in a row makes shorter, the best of several.

    The best of several starts is then shaken and improved again (Lin and Kernighan's double
    bridge, and some places entered in another way), as long as a fixed effort allows.
    """
    m = len(costs)
    table = np.zeros((m + 2, m + 2))  # with a start, m, and an end, m + 1, which costs nothing
    table[:m, :m] = costs
    table[m, :m] = table[:m, m] = first
    starts = min(n, _STARTS if n <= 200 else 1)
    routes = [_improved(_nearest(table, n, int(way)), table, n) for way in rng.permutation(n)[:starts]]
    route, length = min(routes, key=lambda pair: pair[1])
    for _ in range(_EFFORT // n**2 if n <= 200 else 0):
        cuts = np.sort(rng.choice(np.arange(1, n + 1), 3, replace=False))
        a, b, c, d = np.split(route, cuts)
        shaken = np.concatenate([a, c, b, d])
        again = rng.choice(np.arange(1, n + 1), min(n, _ENTERED_ANEW), replace=False)
        shaken[again] = shaken[again] % n + n * rng.integers(m // n, size=len(again))
        other = _improved(shaken, table, n)
        if other[1] < length - _NOTHING:
            route, length = other
    return np.asarray(route[1:-1])


def _nearest(table: Array, n: int, way: int) -> np.ndarray:
    """From the start by way of one place always on to the nearest."""
    m = len(table) - 2
    place = np.arange(m) % n
    route, open_ = [m, way], place != place[way]
    while open_.any():
        way = int(np.where(open_, table[way, :m], np.inf).argmin())
        open_ &= place != place[way]
        route.append(way)
    return np.array([*route, m + 1])


def _improved(route: np.ndarray, table: Array, n: int) -> tuple[np.ndarray, float]:
    """The route with every move that makes it shorter made, and its length."""
    while True:
        gain, changed = min((_reversal(route, table), _moved(route, table)), key=lambda pair: pair[0])
        if gain > -_NOTHING:
            before = table[route[:-1], route[1:]].sum()
            changed = _entered(route, table, n)
            if table[changed[:-1], changed[1:]].sum() > before - _NOTHING:
                return route, float(before)
        route = changed


def _reversal(route: np.ndarray, table: Array) -> tuple[float, np.ndarray]:
    """The best reversal of a part, and by how much it changes the length."""
    a, b = route[:-1], route[1:]
    steps = table[a, b]
    change = table[np.ix_(a, a)] + table[np.ix_(b, b)] - steps[:, None] - steps[None, :]
    change[np.tril_indices(len(a))] = 0.0
    i, j = np.unravel_index(change.argmin(), change.shape)
    changed = route.copy()
    changed[i + 1 : j + 1] = route[i + 1 : j + 1][::-1]
    return float(change[i, j]), changed


def _moved(route: np.ndarray, table: Array) -> tuple[float, np.ndarray]:
    """The best move of a few places in a row to elsewhere, turned round or not. Source: Or (1976)."""
    best, changed = 0.0, route
    a, b = route[:-1], route[1:]
    steps = table[a, b]
    for length in range(1, min(_LONGEST_MOVED, len(route) - 3) + 1):
        head, tail = route[1:-length], route[length:-1]
        gained = table[route[: -length - 1], head] + table[tail, route[length + 1 :]]
        gained -= table[route[: -length - 1], route[length + 1 :]]
        # of each part (row) into each step (column)
        forth = table[np.ix_(head, a)] + table[np.ix_(tail, b)]
        back = table[np.ix_(tail, a)] + table[np.ix_(head, b)]
        change = np.minimum(forth, back) - steps - gained[:, None]
        offset = np.arange(len(a)) - np.arange(len(head))[:, None]
        change[(offset >= 0) & (offset <= length)] = 0.0  # steps that it is part of
        i, j = np.unravel_index(change.argmin(), change.shape)
        if change[i, j] < best:
            best = float(change[i, j])
            part = route[i + 1 : i + 1 + length]
            part = part if forth[i, j] <= back[i, j] else part[::-1]
            rest = np.delete(route, np.arange(i + 1, i + 1 + length))
            at = j + 1 if j < i else j + 1 - length
            changed = np.concatenate([rest[:at], part, rest[at:]])
    return best, changed


def _entered(route: np.ndarray, table: Array, n: int) -> np.ndarray:
    """The same places in the same order, each entered in the best way; by dynamic programming."""
    m = len(table) - 2
    ways = route[1:-1, None] % n + n * np.arange(m // n)
    lengths, choices = table[m, ways[0]], []
    for here, there in itertools.pairwise(ways):
        through = lengths[:, None] + table[np.ix_(here, there)]
        choices.append(through.argmin(axis=0))
        lengths = through.min(axis=0)
    chosen = [int(lengths.argmin())]
    for choice in reversed(choices):
        chosen.append(int(choice[chosen[-1]]))
    return np.concatenate([[m], ways[np.arange(n), chosen[::-1]], [m + 1]])
