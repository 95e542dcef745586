"""The main use case: a calibration program for a problem, with all that can be asked of it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.bounds import Certificate, certify
from acalx.criteria import Criterion, Target
from acalx.errors import ArgumentError, CompatibilityError, Option, PluginError
from acalx.numerics.arrays import Array
from acalx.optimizers import Optimizer
from acalx.options import require_count, require_part, require_seed, require_switch
from acalx.planning.contradictions import contradiction
from acalx.planning.defaults import default_optimizer
from acalx.planning.itinerary import Itinerary, check_order, itinerary, shorter
from acalx.planning.metrics import best_published, figures_of_merit
from acalx.planning.mixed_units import mixed_units
from acalx.planning.orientation import Orientation, check_orientation, orient
from acalx.planning.smallest import Smallest, smallest_program
from acalx.problem import Problem
from acalx.programs import Program
from acalx.schemes import Composed, Joint, Part, Scheme
from acalx.search.account import Watch
from acalx.search.result import Found, Front, Result

__all__ = ["Designed", "Request", "design"]


@final
@dataclass(frozen=True)
class Request:
    """How a problem is to be solved, and what is wanted beside the program.

    Parameters
    ----------
    optimizer : Optimizer, optional
        None: one that suits the problem (see `acalx.planning.defaults`).
    scheme : Scheme
        How a model of several kinds of sensors is designed for.
    target : Target, optional
        Find the smallest number of positions that reaches it; the problem's own n plays no part then.
    n_most : int
        The most positions for a target.
    orient : Criterion, optional
        A second criterion, by which a rotation is chosen that costs the first one nothing.
    order : str
        Of visit: ``given``, ``random`` or ``shortest``.
    dwell_s : float, s
        Time in each position, for the total time.
    seed : int
        The same seed gives the same program.
    """

    optimizer: Optimizer[Any] | None = None
    scheme: Scheme = field(default_factory=Joint)
    target: Target | None = None
    n_most: int = 500
    orient: Criterion | None = None
    order: str = "given"
    dwell_s: float = 60.0
    seed: int = 0

    def __post_init__(self) -> None:
        require_seed(self.seed)
        require_part("scheme", self.scheme, Scheme)
        require_count("n_most", self.n_most)
        for name, kind in (("optimizer", Optimizer), ("target", Target), ("orient", Criterion)):
            if getattr(self, name) is not None:
                require_part(name, getattr(self, name), kind)
        check_order(self.order, self.dwell_s)

    def optimizer_for(self, problem: Problem) -> Optimizer[Any]:
        """The optimizer that was asked for, or the one that suits."""
        return default_optimizer(problem) if self.optimizer is None else self.optimizer


@final
@dataclass(frozen=True, eq=False)
class Designed:
    """A program, how it was found, and how good it is.

    Parameters
    ----------
    problem : Problem
        With as many positions as the program has.
    request : Request
    result : Result or Front
        Of the search; its program is rotated and in the order of visit where that was asked for.
    parts : tuple of Part
        What a scheme designed separately.
    visit : Itinerary
    smallest : Smallest or None
        What was tried to find the number of positions.
    orientation : Orientation or None
        Which rotation was chosen, and what that gained.
    certificate : Certificate or None
        What bounds all programs; None where it was not asked for, or is not to be had together.
    seconds : mapping of str to float
        Wall time of ``search``, ``orientation`` and ``certificate``.
    """

    problem: Problem
    request: Request
    result: Found
    parts: tuple[Part, ...]
    visit: Itinerary
    smallest: Smallest | None = None
    orientation: Orientation | None = None
    certificate: Certificate | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)

    @property
    def program(self) -> Array:
        """Settings of the positions in the order of visit, (n, d) in rad or the SI unit."""
        return self.result.program

    @property
    def status(self) -> str:
        """How the search ended: ``ok``, ``limit`` or ``interrupted`` (see `acalx.search.result.Found`)."""
        return self.result.status

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """All figures of merit of the program (see `acalx.figures_of_merit`)."""
        return figures_of_merit(self.problem.information(self.program))

    @cached_property
    def remarks(self) -> list[str]:
        """What somebody who relies on the program should know beside its figures."""
        problem, order = self.problem, "" if self.problem.model.ordered else self.request.order
        found = mixed_units(problem), shorter(self.visit, order, self.request.dwell_s, problem.held)
        return [remark for remark in found if remark]

    @cached_property
    def reference(self) -> Program | None:
        """The best published program of as many positions; None for several objectives."""
        return None if isinstance(self.result, Front) else best_published(self.problem)

    def contradiction(self, settings: Array) -> str:
        """How the loss of a program, looked at anew, contradicts the search; nothing where none does.

        A model that depends on the order of the positions, or a stand on more than its settings,
        has another loss for a program than the search found. All that are as good, and all points
        of a front, are looked at, the program itself as it is given: (n, d) in rad.
        """
        return contradiction(self.problem, self.result, settings)

    def certified(self) -> Designed:
        """The same with a certificate.

        An interrupt while it is computed ends the design as interrupted, and the program stays.

        Raises
        ------
        CompatibilityError
            Several objectives, which have no bound together.
        """
        started = time.perf_counter()
        certificate, result = None, self.result
        try:
            certificate = certify(self.problem, self.program)
        except KeyboardInterrupt:
            result = result.ended("interrupted", f"{result.message}; interrupted while bounding it")
        seconds = {**self.seconds, "certificate": time.perf_counter() - started}
        return replace(self, result=result, certificate=certificate, seconds=seconds)


def design(
    problem: Problem,
    optimizer: Optimizer[Any] | None = None,
    *,
    scheme: Scheme | None = None,
    target: Target | Mapping[str, float] | None = None,
    n_most: int = 500,
    orient: Criterion | None = None,
    order: str = "given",
    dwell_s: float | None = None,
    certificate: bool | None = None,
    seed: int = 0,
    watch: Watch | None = None,
) -> Designed:
    """Design a calibration program: the positions of a stand that determine a sensor's parameters best.

    Parameters
    ----------
    problem : Problem
        Stand, model, criterion or objectives, number of positions, fixed positions.
    optimizer, scheme, n_most, orient, order, dwell_s, seed : as of `Request`, where each is explained
    target : Target, or mapping of str to float, optional
        Largest standard error of each group that matters, as ``{"bias": 0.5}``: finds the smallest
        number of positions that reaches it. The problem's own n plays no part then.
    certificate : bool, optional
        Whether to bound what any program of as many positions could reach; None: with one criterion.
    watch : callable, optional
        Called with the running `Account` after each step of the search, e.g. to show progress.

    Raises
    ------
    ArgumentError, CompatibilityError
        What is not acceptable or does not fit together; before any work.
    NoProgramError
        No program of the problem can estimate all the parameters.
    PluginError
        The program has another loss than the search found (see `Designed.contradiction`).

    Examples
    --------
    >>> from acalx import D, Gradient, Problem, ScalarAccel, TwoAxis
    >>> designed = design(Problem(TwoAxis(), ScalarAccel(), D(), n=12), Gradient())
    >>> designed.program.shape, designed.certificate.optimal
    ((12, 2), True)
    """
    require_part("problem", problem, Problem)
    several = len(problem.singles) > 1
    require_switch("certificate", certificate is not None and certificate)
    if several and certificate:
        raise ArgumentError.of("certificate", True, "several objectives have no bound together; ask it of one alone")
    wanted = Target(target) if isinstance(target, Mapping) else target
    whole = Joint() if scheme is None else scheme
    problem = problem if dwell_s is None else replace(problem, dwell_s=dwell_s)
    request = Request(optimizer, whole, wanted, n_most, orient, order, problem.dwell_s, seed)
    designed = searched(problem, request, watch)
    if wrong := designed.contradiction(designed.program):
        raise PluginError(wrong)
    if designed.status == "interrupted" or certificate is False or several:
        return designed
    return designed.certified()


def searched(problem: Problem, request: Request, watch: Watch | None = None) -> Designed:
    """All of a design but the certificate, which may take longer than the search."""
    if request.target is not None and len(problem.singles) > 1:
        raise CompatibilityError(
            "several objectives have no smallest number of positions for a target; give one criterion, or {n}",
            n=Option("n", "NUMBER", "a number"),
        )
    least = request.scheme.smallest_n(problem)
    free = (problem.n if request.target is None else least) - problem.held
    check_order(request.order, free=free, ordered=problem.model.ordered)
    if request.orient is not None:
        check_orientation(problem, request.orient, np.random.default_rng(request.seed))
    started = time.perf_counter()
    composed, smallest = _composed(problem, request, watch)
    result, seconds = composed.result, {"search": time.perf_counter() - started}
    if len(result.program) != problem.n:  # where the optimizer, the scheme or a target chooses how many
        problem = replace(problem, n=len(result.program))
    orientation = None
    if request.orient is not None and isinstance(result, Result) and result.status != "interrupted":
        started = time.perf_counter()
        try:
            orientation = orient(problem, result.solutions, request.orient, np.random.default_rng(request.seed))
            message = f"{result.message}; {orientation}"
            result = replace(result, message=message, solutions=(orientation.solution, *result.solutions))
        except KeyboardInterrupt:  # the program is there, and is not to be lost
            result = result.ended("interrupted", f"{result.message}; interrupted while choosing its rotation")
        seconds["orientation"] = time.perf_counter() - started
    rng = np.random.default_rng(request.seed)
    try:
        visit = itinerary(problem.stand, result.program, request.order, rng, problem.held)
    except KeyboardInterrupt:
        visit = itinerary(problem.stand, result.program, "given", rng, problem.held)
        result = result.ended("interrupted", f"{result.message}; interrupted while its order of visit was sought")
    result = result.with_program(visit.settings)
    return Designed(problem, request, result, composed.parts, visit, smallest, orientation, seconds=seconds)


def _composed(problem: Problem, request: Request, watch: Watch | None) -> tuple[Composed, Smallest | None]:
    """The program for a number of positions, or for the smallest that meets a target."""
    optimizer, scheme = request.optimizer_for(problem), request.scheme
    if request.target is None:
        return scheme.solve(problem, optimizer, np.random.default_rng(request.seed), watch), None

    def solve(at: Problem) -> Composed:
        return scheme.solve(at, optimizer.exact(), np.random.default_rng(request.seed), watch)

    smallest = smallest_program(problem, request.target, scheme, solve, request.n_most)
    return smallest.composed, smallest
