"""Regressors that are sums of products of components of the stimulus: evaluated and differentiated from a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.numerics.arrays import Array, empty_as
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.polynomial import Factors, components_of, multiplied

__all__ = ["Entry", "Table"]

# Output, parameter, constant and product.
Entry = tuple[int, int, float, Factors]
# Of each product the entries that it is in: block, output, parameter, constant.
Products = Mapping[Factors, Sequence[tuple[int, int, int, float]]]


@final
@dataclass(frozen=True)
class Table:
    """Rows (..., n, m, p) as a table of their entries.

    Parameters
    ----------
    outputs, count : int
        m and p.
    entries : sequence of Entry
        Those of the same output and parameter are added up.
    """

    outputs: int
    count: int
    entries: Sequence[Entry]

    @property
    def degree(self) -> int:
        """Number of factors of the longest product."""
        return max(len(product) for *_, product in self.entries)

    @cached_property
    def needs(self) -> tuple[str, ...]:
        """The quantities that occur in the products."""
        return tuple(dict.fromkeys(quantity for *_, product in self.entries for quantity, _ in product))

    @cached_property
    def blocks(self) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
        """Outputs and parameters that have nothing to do with the others, as pairs of indices."""
        places = {(output, number) for output, number, *_ in self.entries}
        left, found = set(range(self.outputs)), []
        while left:
            outputs, numbers = {left.pop()}, set[int]()
            while True:
                more = {number for output, number in places if output in outputs}
                reached = {output for output, number in places if number in more}
                if more == numbers and reached <= outputs:
                    break
                numbers, outputs = more, outputs | reached
            left -= outputs
            found.append((np.array(sorted(outputs)), np.array(sorted(numbers), dtype=int)))
        unseen = sorted(set(range(self.count)) - {number for _, number in places})
        if unseen:  # which nothing shows
            found.append((np.zeros(0, dtype=int), np.array(unseen)))
        return tuple(found)

    def least(self, known: Array) -> int:
        """So few positions can't show all the parameters of a block: more are needed than outputs give in fewer.

        `known` (p,) is positive for those of which something is known before.
        """
        shown = [(len(outputs), int(np.count_nonzero(known[numbers] == 0.0))) for outputs, numbers in self.blocks]
        return max((-(-unknown // count) for count, unknown in shown if count), default=1)

    @cached_property
    def _in_whole(self) -> Products:
        """Each product once, with the places of the entries that it is in, as in one block."""
        found: dict[Factors, list[tuple[int, int, int, float]]] = {}
        for output, number, factor, product in self.entries:
            found.setdefault(product, []).append((0, output, number, factor))
        return found

    @cached_property
    def _in_blocks(self) -> Products:
        """The same with the number of the block and the places in it."""
        of = {
            (output, number): (k, i, j)
            for k, (outputs, numbers) in enumerate(self.blocks)
            for i, output in enumerate(outputs.tolist())
            for j, number in enumerate(numbers.tolist())
        }
        return {
            product: [(*of[output, number], factor) for _, output, number, factor in places]
            for product, places in self._in_whole.items()
        }

    def rows(self, stimulus: Stimulus) -> Array:
        """The entries at what is felt, (..., n, m, p): means of the products over the samples in a position."""
        return self._filled(stimulus, [(self.outputs, self.count)], self._in_whole)[0]

    def in_blocks(self, stimulus: Stimulus) -> list[Array]:
        """The same of each block alone, (..., n, its outputs, its parameters)."""
        sizes = [(len(outputs), len(numbers)) for outputs, numbers in self.blocks]
        return self._filled(stimulus, sizes, self._in_blocks)

    def _filled(self, stimulus: Stimulus, sizes: Sequence[tuple[int, int]], products: Products) -> list[Array]:
        first = np.asarray(next(iter(stimulus.values()))[..., 0])
        first = first if stimulus.weights is None else first[..., 0]
        blocks = [empty_as(first, (*first.shape, *size)) for size in sizes]
        for each in blocks:
            each[...] = 0.0
        components = components_of(stimulus, self._in_whole)
        for product, places in products.items():
            value = multiplied(1.0, product, components)
            if stimulus.weights is not None and product:
                value = np.asarray(value) @ stimulus.weights
            for block, output, number, factor in places:
                blocks[block][..., output, number] += factor * value
        return blocks

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows by each quantity, (..., n, m, p, width), or of the means by each sample."""
        first = np.asarray(next(iter(stimulus.values()))[..., 0])
        slopes = {}
        for name in self.needs:
            slopes[name] = empty_as(first, (*first.shape, self.outputs, self.count, stimulus[name].shape[-1]))
            slopes[name][...] = 0.0
        components = components_of(stimulus, self._in_whole)
        for output, number, factor, product in self.entries:
            for i, (quantity, component) in enumerate(product):  # the product rule
                others = product[:i] + product[i + 1 :]
                slopes[quantity][..., output, number, component] += multiplied(factor, others, components)
        if stimulus.weights is not None:
            slopes = {name: slope * stimulus.weights[:, None, None, None] for name, slope in slopes.items()}
        return stimulus.made(slopes)

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the mean rows, (..., n, m, p), to the stimulus, as it comes."""
        return self._pulled(stimulus, [rows], self._in_whole)

    def pull_blocks(self, stimulus: Stimulus, blocks: Sequence[Array]) -> Stimulus:
        """The same from gradients with respect to the rows of each block."""
        return self._pulled(stimulus, blocks, self._in_blocks)

    def _pulled(self, stimulus: Stimulus, blocks: Sequence[Array], products: Products) -> Stimulus:
        weights, components = stimulus.weights, components_of(stimulus, self._in_whole)
        totals = {name: np.empty_like(stimulus[name]) for name in self.needs}
        for total in totals.values():
            total[...] = 0.0
        for product, places in products.items():
            if not product:
                continue
            (block, output, number, factor), *more = places
            by_product = factor * blocks[block][..., output, number]
            for block, output, number, factor in more:
                by_product = by_product + factor * blocks[block][..., output, number]
            if weights is not None:
                by_product = by_product[..., None] * weights
            for i, (quantity, component) in enumerate(product):
                others = product[:i] + product[i + 1 :]
                totals[quantity][..., component] += by_product * multiplied(1.0, others, components)
        return stimulus.made(totals)
