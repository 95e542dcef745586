"""The front of several objectives by pymoo's NSGA-II, polished by gradient."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, final

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.options import is_number, require_count, require_points, require_positive, require_switch
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.encoding import Encoding
from acalx.search.ending import front_of
from acalx.search.front import FrontSearch
from acalx.search.pareto import nondominated, spread
from acalx.search.regularity import no_regular_program
from acalx.search.result import Front
from acalx.search.settle import settle
from acalx.search.starts import regular_starts

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.repair import Repair

__all__ = ["NSGA2"]

# Members of the last population from which the polish seeks goals, and on stands with steps
# from which it seeks the ends.
_SEEDS, _END_STARTS = 28, 8
# The front so far is looked at every so many generations.
_EVERY = 10
# The share of the work that is evolution, for the progress shown.
_EVOLUTION = 0.7


@final
@dataclass(frozen=True)
class NSGA2(Optimizer[Front]):
    """pymoo's NSGA-II, then a polish by gradient.

    A whole population is evaluated in one call. Evolution alone stays some thousandths above
    the front and does not reach its ends; the polish goes on from its programs as
    `Scalarized` does, so that the ends are as good as under each objective alone. On a
    stand with steps the ends are polished from stop to stop and the rest is as it evolved; what
    has steps varies by whole numbers of them, what has none beside it freely.

    Parameters
    ----------
    population : int
        Members of the population.
    generations : int
    points : int
        Most points of the front.
    crossover : float
        Probability of the simulated binary crossover.
    crossover_eta, mutation_eta : float
        Distribution indices: with larger ones children are closer to their parents.
    mutation : float or None
        Probability that an angle mutates; None: one angle of a program on the average.
    polish : bool
        Whether descent ends the search.

    Source: Deb, Pratap, Agarwal, Meyarivan, IEEE Trans. Evol. Comput. 6 (2002) 182.
    """

    population: int = 100
    generations: int = 200
    points: int = 50
    crossover: float = 0.9
    crossover_eta: float = 15.0
    mutation: float | None = None
    mutation_eta: float = 20.0
    polish: bool = True

    several: ClassVar[bool] = True

    def __post_init__(self) -> None:
        require_count("generations", self.generations)
        for name in ("population", "points"):
            require_points(name, getattr(self, name))
        for name in ("crossover_eta", "mutation_eta"):
            require_positive(name, getattr(self, name))
        for name in ("crossover", "mutation"):
            value = getattr(self, name)
            if not (is_number(value) and 0 < value <= 1) and (name == "crossover" or value is not None):
                raise ArgumentError.of(name, value, "must be a probability above 0 and up to 1")
        require_switch("polish", self.polish)

    def check(self, problem: Problem) -> None:
        """Refuses fewer points than objectives."""
        require_points("points", self.points, len(problem.singles))

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Front:
        """Evolution, then the polish."""
        self._evolve(problem, rng, account)
        if account.front is None:
            raise no_regular_program(problem)
        settled, polish = True, ""
        if self.polish and problem.stand.axes.stepped:
            self._polish_stops(problem, account)
            polish = ", its ends polished from stop to stop"
        elif self.polish:
            programs, losses = account.front
            chosen = spread(losses, _SEEDS)
            search = FrontSearch(self.points)
            settled = search.run(problem, rng, account, programs[chosen])
            polish = ", polished" if settled else ", polished; the starts under one objective alone did not agree"
        programs, losses = account.front
        chosen = spread(losses, self.points)
        account.hold(programs[chosen], losses[chosen])
        count = f"{len(chosen)} points on the front" if len(chosen) > 1 else "one program is best in all objectives"
        message = f"{count} after {self.generations} generations{polish}"
        return front_of(problem, account, status="ok" if settled else "limit", message=message)

    def _evolve(self, problem: Problem, rng: np.random.Generator, account: Account) -> None:
        """Generations of pymoo's algorithm; the account holds the front of the last."""
        from pymoo.config import Config
        from pymoo.core.problem import Problem as PymooProblem

        Config.warnings["not_compiled"] = False
        encoding = Encoding(problem.restrictions)

        class Programs(PymooProblem):  # type: ignore[misc]
            """The problem as pymoo sees it; singular programs break a constraint."""

            def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
                losses = problem.losses(encoding.settings(x))
                singular = np.asarray(~np.isfinite(losses).all(axis=-1))
                out["F"] = np.where(singular[:, None], 0.0, losses)
                out["G"] = np.where(singular, 1.0, -1.0)[:, None]

        lower, upper = encoding.bounds.T
        programs = Programs(
            n_var=len(lower), n_obj=len(problem.singles), n_ieq_constr=1, xl=lower, xu=upper, vtype=float
        )
        first = encoding.vectors(regular_starts(problem, rng, self.population))
        algorithm = self._algorithm(first, encoding.integral)
        algorithm.setup(programs, termination=("n_gen", self.generations), seed=int(rng.integers(2**31)), verbose=False)
        while algorithm.has_next():
            algorithm.next()
            members = algorithm.pop
            account.evaluations += self.population
            account.fraction = _EVOLUTION * min(algorithm.n_iter / self.generations, 1.0)
            if algorithm.has_next() and algorithm.n_iter % _EVERY != 1:
                account.tick()
                continue
            feasible = members.get("CV")[:, 0] <= 0
            losses = members.get("F")[feasible]
            best = nondominated(losses)
            account.hold(encoding.settings(members.get("X")[feasible][best]), losses[best])

    def _algorithm(self, sampling: Array, integral: np.ndarray) -> Algorithm:
        from pymoo.algorithms.moo.nsga2 import NSGA2 as Evolution  # noqa: N811
        from pymoo.operators.crossover.sbx import SBX
        from pymoo.operators.mutation.pm import PM

        repair = {"vtype": float, "repair": _rounding(integral)} if integral.any() else {}
        return Evolution(
            pop_size=self.population,
            sampling=sampling,
            crossover=SBX(prob=self.crossover, eta=self.crossover_eta, **repair),
            mutation=PM(prob=1.0, prob_var=self.mutation, eta=self.mutation_eta, **repair),
        )

    def _polish_stops(self, problem: Problem, account: Account) -> None:
        """Each objective alone from stop to stop, from the members best in it."""
        assert account.front is not None
        programs, losses = account.front
        for k, single in enumerate(problem.singles):
            inner = Account(lambda _: account.tick())
            starts = programs[np.argsort(losses[:, k], kind="stable")[:_END_STARTS]]
            ends = settle(single, starts, account=inner)
            account.evaluations += inner.evaluations
            programs = np.concatenate([programs, ends.settings])
            losses = np.concatenate([losses, problem.losses(ends.settings)])
            best = nondominated(losses)
            programs, losses = programs[best], losses[best]
            account.hold(programs, losses)


def _rounding(integral: np.ndarray) -> Repair:
    """What rounds those of pymoo's numbers that are numbers of stops."""
    from pymoo.core.repair import Repair

    class Rounding(Repair):  # type: ignore[misc]
        """Rounds some of the columns."""

        def _do(self, problem: object, x: Array, **kwargs: Any) -> Array:
            return np.where(integral, np.around(x), x)

    return Rounding()
