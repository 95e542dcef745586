"""Criteria: what makes one program better than another."""

from acalx.criteria.alphabetic import A, D, E
from acalx.criteria.base import Ceiling, Criterion, Product, Terms
from acalx.criteria.concave import Concave, concave_of
from acalx.criteria.fair import Inequality, fair
from acalx.criteria.objectives import Objectives
from acalx.criteria.target import Target

__all__ = [
    "A",
    "Ceiling",
    "Concave",
    "Criterion",
    "D",
    "E",
    "Inequality",
    "Objectives",
    "Product",
    "Target",
    "Terms",
    "concave_of",
    "fair",
]
