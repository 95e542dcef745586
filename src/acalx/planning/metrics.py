"""Figures of merit of a program, all of them whatever was optimized, and what to compare it with."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.programs import Program, published_for
from acalx.quantities.information import Information
from acalx.quantities.magnitude import from_log

__all__ = ["best_published", "figures_of_merit", "published_losses"]


def figures_of_merit(information: Information) -> dict[str, Any]:
    """D, A, E, theta, inequality and what else is reported for one program.

    A determinant of many parameters, in units of a small noise, may be no number that a double holds: then D is 0 or
    inf, and its logarithm says what it is. All figures are in units of the noise: multiply standard deviations by that of the noise,
    A and E by its square. Where the program is singular they are inf, or nan where they have no
    meaning.

    Parameters
    ----------
    information : Information
        With one matrix (p, p).

    Returns
    -------
    dict
        ``D`` = det K, ``A`` = tr K, ``E`` = largest eigenvalue of K, and ``log_D``, ``log_A``, ``log_E``; ``theta`` and
        ``inequality`` (a fraction, not percent; of two parameters or more) by group; ``standard_deviations`` by
        parameter; ``correlations``, a (p, p) list in the order of the parameters;
        ``condition_number`` of the information matrix.
    """
    log_d, a = -float(information.log_det), float(information.variances.sum())
    e = math.inf if information.singular else 1.0 / float(information.smallest_eigenvalue)
    return {
        "D": from_log(log_d),
        "A": a,
        "E": e,
        "log_D": log_d,
        "log_A": math.log(a),
        "log_E": math.log(e),
        "theta": {group: float(information.theta(group)) for group in information.groups},
        "inequality": {
            group: float(information.inequality(group))
            for group, members in information.groups.items()
            if len(members) > 1
        },
        "standard_deviations": {
            parameter.name: float(deviation)
            for parameter, deviation in zip(information.parameters, information.standard_deviations, strict=True)
        },
        "correlations": information.correlations.tolist(),
        "condition_number": float(information.condition_number),
    }


def best_published(problem: Problem) -> Program | None:
    """The best published program of as many positions, by the problem's criterion."""
    comparable = published_losses(problem)
    return min(comparable, key=lambda pair: pair[1][0])[0] if comparable else None


def published_losses(problem: Problem) -> list[tuple[Program, Array]]:
    """Published programs of as many positions that can estimate all the parameters, with their losses (k,)."""
    found = []
    for program in published_for(problem.stand).values():
        if program.n != problem.n:
            continue
        losses = problem.losses(program.settings_for(problem.stand))
        if np.isfinite(losses).all():
            found.append((program, losses))
    return found
