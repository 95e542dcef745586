"""How the positions of a program are divided between the parts of a model."""

from __future__ import annotations

from collections.abc import Mapping

from acalx.errors import ArgumentError, Option
from acalx.options import is_whole

__all__ = ["check_positions", "divide"]


def check_positions(positions: object) -> None:
    """Raise ArgumentError unless it is None or gives whole numbers of positions by names of parts."""
    if positions is None:
        return
    if not isinstance(positions, Mapping) or not positions:
        raise ArgumentError.of("scheme.positions", positions, "give numbers by kind", {"gyros": 10})
    for name, number in positions.items():
        if not is_whole(number) or number < 0:
            raise ArgumentError.of("scheme.positions", {name: number}, "must be a whole number of positions")


def divide(
    n: int, held: int, least: Mapping[str, int], weights: Mapping[str, int], given: Mapping[str, int]
) -> dict[str, int]:
    """Numbers of positions that each part chooses, n together with those that are fixed.

    Parameters
    ----------
    n : int
    held : int
        How many are fixed.
    least : mapping of str to int
        The fewest that each part can do with.
    weights : mapping of str to int
        In proportion to which the positions are divided.
    given : mapping of str to int
        Numbers of some parts, or of all.

    Raises
    ------
    ArgumentError
        Unknown parts, numbers too small, or an n that they don't add up to.
    """
    for name, number in given.items():
        if name not in least:
            raise ArgumentError(f"positions: the model has no part {name!r}; its parts are {', '.join(least)}")
        if number < least[name]:
            raise ArgumentError.of("scheme.positions", {name: number}, f"the {name} need {least[name]} or more")
    divided = {name: given.get(name, fewest) for name, fewest in least.items()}
    need, free = held + sum(divided.values()), [name for name in least if name not in given]
    if need > n or (need < n and not free):
        counts = {"fixed": held, **divided} if held else divided
        listed = ", ".join(f"{name} {number}" for name, number in counts.items())
        rest = ", or leave one of them out" if not free else " or more, or use {joint}"
        raise ArgumentError(
            "{n}: the parts have {need} positions together ({listed}); give {enough}" + rest,
            n=Option("n", n),
            need=need,
            listed=listed,
            enough=Option("n", need),
            joint=Option("scheme", "joint", "Joint()"),
        )
    while held + sum(divided.values()) < n:
        divided[min(free, key=lambda name: divided[name] / weights[name])] += 1
    return divided
