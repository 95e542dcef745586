"""Regressors that are sums of products of components of the stimulus: evaluated and differentiated from a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.numerics.arrays import Array, empty_as
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.polynomial import Components, Factors, components_of, multiplied

__all__ = ["Entry", "Table"]

# Output, parameter, constant and product.
Entry = tuple[int, int, float, Factors]


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
        return tuple(found)

    @cached_property
    def products(self) -> dict[Factors, list[tuple[int, int, float]]]:
        """Each product once, with the outputs and parameters that it is an entry of, and the constants."""
        found: dict[Factors, list[tuple[int, int, float]]] = {}
        for output, number, factor, product in self.entries:
            found.setdefault(product, []).append((output, number, factor))
        return found

    def rows(self, stimulus: Stimulus) -> Array:
        """The entries at what is felt, (..., n, m, p): means of the products over the samples in a position."""
        first = self._first(stimulus)
        first = first if stimulus.weights is None else first[..., 0]
        rows = empty_as(first, (*first.shape, self.outputs, self.count))
        rows[...] = 0.0
        components = self._components(stimulus)
        for product, places in self.products.items():
            value = multiplied(1.0, product, components)
            if stimulus.weights is not None and product:
                value = np.asarray(value) @ stimulus.weights
            for output, number, factor in places:
                rows[..., output, number] += factor * value
        return rows

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows by each quantity, (..., n, m, p, width), or of the means by each sample."""
        first = self._first(stimulus)
        slopes = {}
        for name in self.needs:
            slopes[name] = empty_as(first, (*first.shape, self.outputs, self.count, stimulus[name].shape[-1]))
            slopes[name][...] = 0.0
        components = self._components(stimulus)
        for output, number, factor, product in self.entries:
            for i, (quantity, component) in enumerate(product):  # the product rule
                others = product[:i] + product[i + 1 :]
                slopes[quantity][..., output, number, component] += multiplied(factor, others, components)
        if stimulus.weights is not None:
            slopes = {name: slope * stimulus.weights[:, None, None, None] for name, slope in slopes.items()}
        return stimulus.made(slopes)

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the mean rows, (..., n, m, p), to the stimulus, as it comes."""
        weights, components = stimulus.weights, self._components(stimulus)
        totals = {name: np.empty_like(stimulus[name]) for name in self.needs}
        for total in totals.values():
            total[...] = 0.0
        for product, places in self.products.items():
            if not product:
                continue
            (output, number, factor), *more = places
            by_product = factor * rows[..., output, number]
            for output, number, factor in more:
                by_product = by_product + factor * rows[..., output, number]
            if weights is not None:
                by_product = by_product[..., None] * weights
            for i, (quantity, component) in enumerate(product):
                others = product[:i] + product[i + 1 :]
                totals[quantity][..., component] += by_product * multiplied(1.0, others, components)
        return stimulus.made(totals)

    def _components(self, stimulus: Stimulus) -> Components:
        return components_of(stimulus, self.products)

    def _first(self, stimulus: Stimulus) -> Array:
        return np.asarray(stimulus[self.needs[0]][..., 0])
