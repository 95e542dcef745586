"""How far a program is from the best possible: a bound that no program of n positions can beat.

A program of n positions is a measure on the stand's domain with n equal weights; over all
measures the problem is convex. Write Phi(M) = exp(-loss(M) / k) for a criterion whose value
falls with the k-th power of a multiple of M: where Phi is concave, the tangent at any M0 gives

    Phi(M) <= max over positions x of s(x) * Phi(M0),   s(x) = -trace(G h(x)'h(x)) / k,

with G the gradient of the loss at M0. So loss(M) >= loss(M0) - k log(max s) for every measure
M, and k log n less for the sum over n positions. M0 need not be the optimum; the closer it is,
the closer max s is to 1. What has to be proved is max s.

Source: Kiefer, Ann. Statist. 2 (1974) 849; Pukelsheim, Optimal Design of Experiments (1993).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acalx.arrays import Array
from acalx.criteria import Criterion
from acalx.problem import Problem
from acalx.relaxation import Relaxation, relax
from acalx.supremum import Supremum

__all__ = ["Certificate", "certify"]

_PROVED = 1e-6


@dataclass(frozen=True)
class Certificate:
    """A lower bound on the value of a criterion for programs of n positions.

    Parameters
    ----------
    bound : float
        In the units of the criterion's published value: for D a determinant.
    efficiency : float
        Of the program, 0 to 1, on the scale of a variance: (bound / value) to the power 1 / k.
    gap : float
        Loss of the program less the loss of the bound.
    margin : float
        By how much the bound was lowered for what lies between the points at which the
        sensitivity was computed, in loss.
    method : str
        How the bound was proved.
    proved : bool
        Whether the program is proved optimal to an efficiency of 1 - 1e-6.
    part : str
        What is bounded, where it is not the whole criterion; empty otherwise.
    """

    bound: float
    efficiency: float
    gap: float
    margin: float
    method: str
    proved: bool
    part: str = ""
