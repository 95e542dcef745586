"""The best approximate design on a grid of candidates, rounded to n positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from acalx.criteria import Concave, concave_of
from acalx.errors import AcalxError, ArgumentError, CompatibilityError, Option
from acalx.optimizers.base import Optimizer
from acalx.options import require_count, require_positive
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.agreement import judge
from acalx.search.ending import result_of
from acalx.search.result import ApproximateDesign, Result
from acalx.search.roundings import roundings
from acalx.search.settle import settle
from acalx.weights import (
    Candidates,
    Positions,
    Weights,
    alike,
    newton_fits,
    optimal_weights,
)
from acalx.weights.conic import Conic, SolverError, choose_solvers, installed_solvers

__all__ = ["Convex"]

# cvxpy's solvers stop near a relative gap of 1e-5; its rounds end above that, Newton's method goes on.
_CONIC_GAP = 1e-4


@final
@dataclass(frozen=True)
class Convex(Optimizer[Result]):
    """Convex optimization of the weights of candidate positions, then rounding.

    Weights in place of whole numbers of measurements make the problem convex, so that its
    solution comes with a proof. cvxpy solves it on a few active candidates; those whose
    sensitivity is then too high join them, round by round; Newton's method on the weights ends it.
    The weights are shares of the measurements, or of the time where that is what is given.
    Several roundings of them to n positions are polished, by descent along the gradient or from
    stop to stop where the stand has steps.

    Parameters
    ----------
    candidates : int
        About so many positions from which weights choose.
    kind : str
        ``structured``: a grid over the limits of the stand; ``random``.
    solver : str, optional
        cvxpy's name of a solver, e.g. ``CLARABEL`` or ``SCS``. None: the first that is installed
        and solves it; Newton's method alone, where none does.
    tolerance : float
        The relative gap at which the weights are good enough: their efficiency among all on the
        candidates is at least 1 / (1 + tolerance).
    rounds : int
        Most rounds over all candidates, of cvxpy and of Newton's method each.
    roundings : int
        So many roundings are polished.
    agreement : float
        Losses of programs that differ by less are the same.

    Source: Kiefer (1974) for the weights; Pukelsheim and Rieder, Biometrika 79 (1992) 763 for
    rounding; Yang, Biedermann, Tang, J. Amer. Statist. Assoc. 108 (2013) 1411 for the rounds.
    """

    by_position: ClassVar[bool] = True
    candidates: int = 10_000
    kind: str = "structured"
    solver: str | None = None
    tolerance: float = 1e-6
    rounds: int = 60
    roundings: int = 32
    agreement: float = 1e-5

    def __post_init__(self) -> None:
        for name in ("candidates", "rounds", "roundings"):
            require_count(name, getattr(self, name))
        for name in ("tolerance", "agreement"):
            require_positive(name, getattr(self, name))
        if self.kind not in ("structured", "random"):
            raise ArgumentError.of("kind", self.kind, "must be structured or random")
        if not isinstance(self.solver, str | None):
            raise ArgumentError(
                "{given}: must be the name of a solver, such as CLARABEL, or {none}",
                given=Option("solver", self.solver),
                none=Option("solver", None),
            )

    def check(self, problem: Problem) -> None:
        """Refuses criteria without a convex form, and a named solver that is not installed."""
        _concave(problem)
        if self.solver is not None and self.solver not in (installed := installed_solvers()):
            have = f"installed are {', '.join(installed)}" if installed else "cvxpy is not installed at all"
            raise ArgumentError(
                "{given}: cvxpy has no such solver here; {have}, or take {none}",
                given=Option("optimizer.solver", self.solver),
                have=have,
                none=Option("optimizer.solver", None),
            )

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Optimal weights of the candidates, roundings of them to n positions, and their polish."""
        positions = problem.stand.axes.candidates(self.candidates, self.kind, rng)
        candidates = Positions(problem.stand, problem.model, positions, problem.dwell_s)
        criterion = _concave(problem)
        found, how = self._weights(problem, criterion, candidates)
        rows, settings = candidates.regressors(found.index), candidates.settings[found.index]
        points = alike(rows, found.weights, found.information.covariance)
        design = ApproximateDesign(settings, found.weights, points, found.loss, found.gap, len(candidates), how)
        descent = settle(problem, roundings(problem, design, rng, self.roundings), account=account)
        verdict = judge(descent.loss, self.agreement)
        reached = found.gap <= self.tolerance
        message = (
            f"{design.count} support points among {len(candidates)} candidates, gap {found.gap:.1e} "
            f"{'' if reached else f'instead of {self.tolerance:g} '}({how}); of the roundings, {verdict}"
        )
        return result_of(
            problem,
            account,
            descent.settings,
            descent.loss,
            status="ok" if reached else "limit",
            message=message,
            agreement=self.agreement,
            design=design,
        )

    def _weights(self, problem: Problem, criterion: Concave, candidates: Candidates) -> tuple[Weights, str]:
        """Weights by cvxpy and Newton's method, and in words how they came about."""
        failures: list[str] = []
        for solver in choose_solvers() if self.solver is None else [self.solver]:
            conic = Conic(criterion, problem.parameters, solver)
            if not conic.fits:
                failures.append(f"{criterion.label} gives cvxpy no expression")
                break
            try:
                rough = optimal_weights(
                    candidates,
                    criterion,
                    base=problem.base_share if problem.based else None,
                    tolerance=max(_CONIC_GAP, self.tolerance),
                    rounds=self.rounds,
                    master=conic,
                )
            except SolverError as failure:
                if self.solver is not None:
                    installed = ", ".join(installed_solvers())
                    raise AcalxError(f"solver={self.solver}: {failure}; installed are {installed}") from failure
                failures.append(str(failure))
                continue
            ended = f"{solver} to {rough.gap:.0e}{', inaccurately' if conic.inaccurate else ''}"
            how = "; ".join([*failures, ended])
            if rough.gap <= self.tolerance or not newton_fits(criterion, len(problem.parameters)):
                return rough, how
            fine = self._newton(problem, criterion, candidates, rough.index)
            return (fine, f"{how}, then Newton's method") if fine.gap < rough.gap else (rough, how)
        return self._newton(problem, criterion, candidates, None), "; ".join([*failures, "Newton's method alone"])

    def _newton(
        self, problem: Problem, criterion: Concave, candidates: Candidates, start: np.ndarray | None
    ) -> Weights:
        return optimal_weights(
            candidates,
            criterion,
            base=problem.base_share if problem.based else None,
            tolerance=self.tolerance,
            rounds=self.rounds,
            start=start,
        )


def _concave(problem: Problem) -> Concave:
    """The problem's criterion as one whose weights are a convex problem."""
    concave = concave_of(problem.objective.criterion)
    if concave is None:
        raise CompatibilityError(
            "optimizer Convex needs a convex criterion, and {label} does not say that it is one; use {d}, {a} or {e}, "
            "derive the criterion from acalx.criteria.Concave with its `degree` and `convex`, or use {gradient} or "
            "{de}",
            label=problem.criterion.label,
            d=Option("criterion", "d", "D()"),
            a=Option("criterion", "a", "A()"),
            e=Option("criterion", "e", "E()"),
            gradient=Option("optimizer", "gradient", "Gradient()"),
            de=Option("optimizer", "de", "DifferentialEvolution()"),
        )
    return concave
