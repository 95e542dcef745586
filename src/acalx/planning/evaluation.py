"""How good a program is that somebody uses already."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.bounds import Certificate, certify
from acalx.criteria import Criterion, D
from acalx.errors import ProgramError
from acalx.models import Model, as_model
from acalx.numerics.arrays import Array
from acalx.options import require_part, require_switch
from acalx.planning.metrics import best_published, figures_of_merit
from acalx.planning.mixed_units import mixed_units
from acalx.problem import Problem, Response
from acalx.problem.parts import check_dwell, check_readings
from acalx.programs import Program, find_program
from acalx.quantities.information import Information
from acalx.sensors import Sensor
from acalx.stands import Stand

__all__ = ["Evaluation", "evaluate"]

# Limits are printed with a few digits; a position within this of one, in rad, is on it.
_TOLERANCE = 1e-6


@final
@dataclass(frozen=True, eq=False)
class Evaluation:
    """Figures of a given program.

    Parameters
    ----------
    program : Program
    stand : Stand
    model : Model
    criterion : Criterion
    settings : array (n, d), in rad or the SI unit
        Of the program on the stand.
    information : Information
    inestimable : list of str
        Combinations of the parameters that it can't see; empty where it can estimate all.
    outside : list of int
        Numbers of positions, from 1, that the stand can't take.
    certificate : Certificate or None
        None where it was not asked for, or the stand can't take the program.
    dwell_s : float, s
    """

    program: Program
    stand: Stand
    model: Model
    criterion: Criterion
    settings: Array
    information: Information
    inestimable: list[str] = field(default_factory=list)
    outside: list[int] = field(default_factory=list)
    certificate: Certificate | None = None
    dwell_s: float = 60.0

    @property
    def status(self) -> str:
        """``ok``, or ``singular`` where some parameters can't be estimated."""
        return "singular" if self.inestimable else "ok"

    @cached_property
    def problem(self) -> Problem:
        """The problem that the program is an answer to."""
        return Problem(self.stand, self.model, self.criterion, self.program.n, dwell_s=self.dwell_s)

    @property
    def loss(self) -> float:
        """Loss of the program by the criterion, a logarithm; inf where the program is singular."""
        return np.inf if self.inestimable else float(self.problem.objective.loss(self.settings))

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """All figures of merit (see `acalx.figures_of_merit`)."""
        return figures_of_merit(self.information)

    @property
    def remarks(self) -> list[str]:
        """What somebody who relies on the figures should know."""
        mixed = "" if self.inestimable else mixed_units(self.problem)
        return [mixed] if mixed else []

    @cached_property
    def reference(self) -> Program | None:
        """The best published program of as many positions, where it is another one."""
        if self.program.n < self.model.smallest_n:  # too few to ask for others
            return None
        best = best_published(self.problem)
        return None if best is None or best.name == self.program.name else best

    def certified(self) -> Evaluation:
        """The same with a certificate, where the program is one that the stand can take."""
        if self.outside or self.inestimable:
            return self
        return replace(self, certificate=certify(self.problem, self.settings))


def evaluate(
    program: Program | str | os.PathLike[str] | Array,
    stand: Stand,
    model: Model | Sensor,
    criterion: Criterion | None = None,
    *,
    certificate: bool = True,
    dwell_s: float = 60.0,
) -> Evaluation:
    """Figures of merit of a program, and how far from the best possible it is.

    Parameters
    ----------
    program : Program, str, path or array (n, d)
        A program, the name of a published one or the path of a file, or settings in rad.
    stand : Stand
    model : Model or Sensor
    criterion : Criterion, optional
        By which it is compared; D where none is given.
    certificate : bool
        Whether to bound what any program of as many positions could reach.
    dwell_s : float, s
        In each position, for models that ask for it.

    Raises
    ------
    ProgramError
        A program that there is not, or that can't be used.
    CompatibilityError
        Parts that don't fit together.
    PluginError
        A sensor that does not give what it must.

    Examples
    --------
    >>> from acalx import ScalarAccel, TwoAxis
    >>> evaluate("egorov_2021_table_1", TwoAxis(), ScalarAccel()).certificate.efficiency > 0.97
    True
    """
    criterion = D() if criterion is None else criterion
    model = as_model(model)
    for name, part, kind in (("stand", stand, Stand), ("criterion", criterion, Criterion)):
        require_part(name, part, kind)
    require_switch("certificate", certificate)
    check_dwell(model, dwell_s)
    given = _program(program, stand)
    criterion.check(model.parameters)
    settings = given.settings_for(stand)
    felt = stand.stimulus(settings)
    model.check(felt, stand)
    check_readings(model, felt.timed(model.needs, dwell_s))
    information = Response(stand, model, dwell_s).information(settings)
    allowed = stand.axes.allows(settings, tolerance=_TOLERANCE)
    outside = [int(k) + 1 for k in np.flatnonzero(~allowed)]
    unseen = information.inestimable()
    evaluation = Evaluation(given, stand, model, criterion, settings, information, unseen, outside, dwell_s=dwell_s)
    return evaluation.certified() if certificate else evaluation


def _program(program: Program | str | os.PathLike[str] | Array, stand: Stand) -> Program:
    if isinstance(program, Program):
        return program
    if isinstance(program, str | os.PathLike):
        return find_program(os.fspath(program), stand)
    try:
        settings = np.array(program, dtype=float)
    except (TypeError, ValueError) as error:
        raise ProgramError(f"program={program!r}: give a program, its name or file, or settings in rad") from error
    if settings.ndim != 2 or settings.shape[1] != len(stand.settings):
        raise ProgramError(f"program: settings of shape {settings.shape}; the stand takes (n, {len(stand.settings)})")
    units = tuple(setting.unit for setting in stand.settings)
    title = f"{len(settings)} positions"
    return Program("program", title, "given", settings=settings, settings_names=stand.axes.names, settings_units=units)
