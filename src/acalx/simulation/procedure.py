"""From a program to what calibrations with it are worth, by simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import ArgumentError, Option
from acalx.estimation import Estimator
from acalx.models import Model, as_model
from acalx.numerics.arrays import Array
from acalx.options import require_part, require_seed
from acalx.planning.itinerary import Itinerary, check_order, itinerary
from acalx.problem.parts import check_dwell
from acalx.programs import Program, find_program
from acalx.sensors import Sensor
from acalx.simulation.campaign import Campaign
from acalx.simulation.monte_carlo import default_estimator, run_campaign
from acalx.simulation.outcome import Outcome
from acalx.simulation.sources import ErrorSources
from acalx.stands import Stand

__all__ = ["Simulated", "find_programs", "simulate"]


@final
@dataclass(frozen=True, eq=False)
class Simulated:
    """Outcomes of one or several programs with the same sensors and noise, and what was asked for.

    Parameters
    ----------
    outcomes : mapping
        From the name of each program to its outcome.
    itineraries : mapping
        From the name of each program to its positions in the order of visit.
    model, stand, errors, estimator
        As they were given; the estimator that suits the model where none was.
    trials : int
        Simulated with each program, also those that ended without an estimate.
    order, dwell_s, confidence, seed
        As they were given.
    """

    outcomes: Mapping[str, Outcome]
    itineraries: Mapping[str, Itinerary]
    model: Model
    stand: Stand
    errors: ErrorSources
    estimator: Estimator
    trials: int
    order: str
    dwell_s: float
    confidence: float
    seed: int

    @property
    def agrees(self) -> dict[str, bool]:
        """By program: whether bias and covariance are what theory predicts, as far as so many trials can tell."""
        return {name: outcome.agrees for name, outcome in self.outcomes.items()}

    @property
    def visits(self) -> dict[str, dict[str, float]]:
        """By program: travel of the stand in degrees, and seconds on the way and in all."""
        return {name: visit.entries(self.dwell_s) for name, visit in self.itineraries.items()}

    def summary(self) -> str:
        """The verdict on each program, in one line."""
        return "; ".join(outcome.summary() for outcome in self.outcomes.values())


def simulate(
    programs: Program | str | Array | Sequence[Program | str | Array],
    stand: Stand,
    model: Model | Sensor,
    errors: ErrorSources,
    *,
    trials: int = 20000,
    estimator: Estimator | None = None,
    order: str = "given",
    dwell_s: float = 60,
    confidence: float = 0.95,
    seed: int = 0,
) -> Simulated:
    """Simulate calibrations with one or several programs, and hold what comes out against theory.

    All programs get the same sensors and, position by position, the same noise, so that what
    differs between their outcomes is due to the programs.

    Parameters
    ----------
    programs : Program, name or file of one, array (n, d) of settings, or a sequence of these
        Settings in rad or the SI unit, as the stand has them.
    stand : Stand
    model : Model or Sensor
    errors : ErrorSources
    trials : int
        Two or more with each program; 20000 tell standard deviations to 0.5 %.
    estimator : Estimator, optional
        `default_estimator` where it is not given.
    order : str
        Of visit, which matters with drift: ``given``, ``random`` (anew in each trial), ``shortest``.
    dwell_s : float, s, in each position
    confidence : float
        Of limits, intervals and verdicts.
    seed : int
        The same seed gives the same sensors and noise.

    Raises
    ------
    ArgumentError, ProgramError
        Options that are not acceptable; a program that there is not, or that is there twice.
    CompatibilityError
        Programs, errors or an estimator that do not go with the stand or the model.
    SingularError
        A program that can't show all the parameters.
    """
    model = as_model(model)
    for name, part, kind in (("stand", stand, Stand), ("errors", errors, ErrorSources)):
        require_part(name, part, kind)
    estimator = default_estimator(model) if estimator is None else estimator
    require_part("estimator", estimator, Estimator)
    require_seed(seed)
    check_order(order, dwell_s, ordered=model.ordered)
    check_dwell(model, dwell_s)
    outcomes, itineraries = {}, {}
    for name, settings in _settings_of(programs, stand).items():
        itineraries[name] = visit = itinerary(stand, settings, order, np.random.default_rng(seed))
        campaign = Campaign(model, stand, visit.settings, errors, seed, order == "random", dwell_s)
        outcomes[name] = run_campaign(campaign, estimator, trials, name, confidence)
    return Simulated(outcomes, itineraries, model, stand, errors, estimator, trials, order, dwell_s, confidence, seed)


def find_programs(names: Sequence[str], stand: Stand | None = None) -> list[Program]:
    """Published programs, or those in files, perhaps in units that a stand has, each once.

    Raises
    ------
    ArgumentError, ProgramError
        None at all, one that is there twice, one that there is not.
    """
    _check_names(names)
    return [find_program(name, stand) for name in names]


def _check_names(names: Sequence[str]) -> None:
    if not names:
        raise ArgumentError(
            "{nothing}: give one program or more, as in {some}",
            nothing=Option("program", []),
            some=Option("program", ["icosahedron_12", "mine.csv"]),
        )
    for k, name in enumerate(names):
        if name in names[:k]:
            raise ArgumentError(f"program: {name} is there twice; once is right")


def _settings_of(programs: Program | str | Array | Sequence[Program | str | Array], stand: Stand) -> dict[str, Array]:
    """Settings (n, d) of each program on the stand, by name; those of an array are checked as a program's are."""
    given = [programs] if isinstance(programs, (Program, str, np.ndarray)) else list(programs)
    found = []
    for k, one in enumerate(given, 1):
        if isinstance(one, np.ndarray):
            name = "program" if len(given) == 1 else f"program {k}"
            units = tuple(setting.unit for setting in stand.settings)
            one = Program(name, name, name, one, stand.axes.names, settings_units=units)
        found.append(find_program(one, stand) if isinstance(one, str) else one)
    _check_names([program.name for program in found])
    return {program.name: program.settings_for(stand) for program in found}
