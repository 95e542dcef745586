"""Optimal approximate designs on large sets of candidate positions."""

from acalx.weights.candidates import Candidates, Positions, Rows
from acalx.weights.rounds import Weights, optimal_weights

__all__ = ["Candidates", "Positions", "Rows", "Weights", "optimal_weights"]
