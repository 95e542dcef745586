"""Whether a criterion adds up what has different units."""

from __future__ import annotations

from collections.abc import Sequence

from acalx.criteria import A, Criterion, E
from acalx.problem import Problem
from acalx.quantities.parameter import Parameter

__all__ = ["mixed_units"]

# Shares of what is measured: of gravity, of the field, of a rate, and small angles.
_SHARES = {"g", "field", "1", "rad"}


def mixed_units(problem: Problem) -> str:
    """What to say of a criterion that adds variances of parameters in units of different kinds; empty where none does.

    A and E depend on the units of the parameters. Biases in g beside scale errors and angles are all shares of
    gravity, and of the same size; deg/s beside g are not.
    """
    kinds = _kinds(problem.parameters)
    if len(kinds) < 2:
        return ""
    found = [
        one for single in problem.singles if isinstance(single.criterion, Criterion) for one in _of(single.criterion)
    ]
    if not found:
        return ""
    units = ", ".join(dict.fromkeys(one.unit for one in problem.parameters))
    return (
        f"{' and '.join(dict.fromkeys(found))} adds up variances in {units}: which parameters count is a matter of "
        "these units; D does not depend on them, and criterion=target says what is needed of each group"
    )


def _of(criterion: Criterion) -> list[str]:
    """Labels of the factors that depend on units."""
    terms = criterion.terms()
    factors = [factor for _, factor in (*terms.smooth, *terms.ceilings)]
    return [factor.label for factor in factors if isinstance(factor, A | E)]


def _kinds(parameters: Sequence[Parameter]) -> list[str]:
    """Units that have nothing to do with each other, in the order of the parameters."""
    return list(dict.fromkeys("share" if one.unit in _SHARES else one.unit for one in parameters))
