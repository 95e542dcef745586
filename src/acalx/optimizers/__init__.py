"""Optimizers: what searches for the best program; one file each."""

from typing import TYPE_CHECKING

from acalx.lazy import names_from

if TYPE_CHECKING:
    from acalx.optimizers.base import Optimizer
    from acalx.optimizers.convex import Convex
    from acalx.optimizers.de import DifferentialEvolution
    from acalx.optimizers.exchange import Exchange
    from acalx.optimizers.gradient import Gradient
    from acalx.optimizers.nsga2 import NSGA2
    from acalx.optimizers.scalarized import Scalarized
    from acalx.optimizers.traversal import Traversal

__all__ = [
    "NSGA2",
    "Convex",
    "DifferentialEvolution",
    "Exchange",
    "Gradient",
    "Optimizer",
    "Scalarized",
    "Traversal",
]

__getattr__ = names_from(
    __name__,
    {
        "acalx.optimizers.base": ("Optimizer",),
        "acalx.optimizers.convex": ("Convex",),
        "acalx.optimizers.de": ("DifferentialEvolution",),
        "acalx.optimizers.exchange": ("Exchange",),
        "acalx.optimizers.gradient": ("Gradient",),
        "acalx.optimizers.nsga2": ("NSGA2",),
        "acalx.optimizers.scalarized": ("Scalarized",),
        "acalx.optimizers.traversal": ("Traversal",),
    },
)
