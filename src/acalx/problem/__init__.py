"""What is asked of an optimizer: objective and restrictions."""

from acalx.problem.objective import Linearization, Objective, Placement, Response, comparable
from acalx.problem.problem import Problem
from acalx.problem.restrictions import Restrictions

__all__ = ["Linearization", "Objective", "Placement", "Problem", "Response", "Restrictions", "comparable"]
