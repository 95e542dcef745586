"""Optimal approximate designs on large sets of candidate positions."""

from acalx.weights.candidates import Candidates, Positions, Rows
from acalx.weights.interior import Balance, balance, gap_of, sensitivities
from acalx.weights.master import Master, newton_fits
from acalx.weights.rounds import Weights, optimal_weights
from acalx.weights.support import alike, efficient_rounding, random_roundings, thinned

__all__ = [
    "Balance",
    "Candidates",
    "Master",
    "Positions",
    "Rows",
    "Weights",
    "alike",
    "balance",
    "efficient_rounding",
    "gap_of",
    "newton_fits",
    "optimal_weights",
    "random_roundings",
    "sensitivities",
    "thinned",
]
