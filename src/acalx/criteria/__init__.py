"""Criteria: what makes one program better than another."""

from acalx.criteria.alphabetic import A, D, E
from acalx.criteria.base import Ceiling, Criterion
from acalx.criteria.fair import Inequality
from acalx.criteria.objectives import Objectives
from acalx.criteria.product import Product
from acalx.criteria.target import Target

__all__ = ["A", "Ceiling", "Criterion", "D", "E", "Inequality", "Objectives", "Product", "Target"]
