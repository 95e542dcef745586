"""Information in blocks, where outputs share no parameters with others."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter

__all__ = ["Blocks", "Places", "in_blocks", "in_places", "runs", "side_by_side", "touched"]

# Outputs and parameters of each, as indices.
Blocks = tuple[tuple[np.ndarray, np.ndarray], ...]
# Of the parameters of a part among those of the whole.
Places = slice | np.ndarray


def in_blocks(blocks: Blocks, rows: Sequence[Array], parameters: tuple[Parameter, ...]) -> Information:
    """Information of programs from the rows of each block, (..., n, its outputs, its parameters)."""
    p = len(parameters)
    matrix = np.zeros((*rows[0].shape[:-3], p, p))
    for (_, numbers), of_block in zip(blocks, rows, strict=True):
        own = tuple(parameters[number] for number in numbers)
        matrix[..., numbers[:, None], numbers] = Information.from_regressors(of_block, own).matrix
    return Information(matrix, parameters, tuple(numbers for _, numbers in blocks))


def side_by_side(parts: Sequence[Information], places: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Blocks of a whole, from the indices that the parameters of each part have there: those in it, or the part."""
    found = list[np.ndarray]()
    for part, place in zip(parts, places, strict=True):
        found += [place[block] for block in part.blocks] or [place]
    return tuple(found)


def in_places(
    parts: Sequence[tuple[Array, Array]], places: Sequence[tuple[slice, Places]], n: int, outputs: int, p: int
) -> tuple[Array, Array]:
    """Residuals (..., n m) and rows (..., n m, p) of n positions, from those of parts with outputs and parameters."""
    stack = np.broadcast_shapes(*(value.shape[:-1] for value, _ in parts), *(rows.shape[:-2] for _, rows in parts))
    value, rows = np.empty((*stack, n, outputs)), np.zeros((*stack, n, outputs, p))
    for (part, own_rows), (of_outputs, own) in zip(parts, places, strict=True):
        m = of_outputs.stop - of_outputs.start
        value[..., of_outputs] = part.reshape((*part.shape[:-1], n, m))
        rows[..., of_outputs, own] = own_rows.reshape((*own_rows.shape[:-2], n, m, own_rows.shape[-1]))
    return value.reshape((*stack, n * outputs)), rows.reshape((*stack, n * outputs, p))


def touched(blocks: Blocks, outputs: int, count: int) -> np.ndarray:
    """Which outputs each parameter shows in, (m, p), as far as blocks say it."""
    found = np.zeros((outputs, count), dtype=bool)
    for own, numbers in blocks:
        found[own[:, None], numbers] = True
    return found


def runs(sizes: Sequence[int]) -> list[tuple[int, int]]:
    """Where each of so many things of these sizes begins and ends, one behind the other."""
    return list(pairwise(np.cumsum([0, *sizes]).tolist()))
