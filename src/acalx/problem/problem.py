"""What is asked: stand, model, criterion and n bound together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from acalx.criteria import Criterion, Objectives
from acalx.errors import ArgumentError, CompatibilityError
from acalx.models import Model, as_model
from acalx.numerics.arrays import Array
from acalx.options import is_whole, require_part, require_switch
from acalx.problem.objective import Objective, Response
from acalx.problem.parts import check_dwell, check_parts
from acalx.problem.restrictions import Restrictions
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.stands import Stand

__all__ = ["Problem"]

_MEMORY_LIMIT_BYTES = 4 * 2**30


@dataclass(frozen=True, eq=False)
class Problem:
    """Choose n positions of a stand so that a criterion of a model's information is least.

    Two problems are equal where all that is asked is, the fixed positions too.

    Parameters
    ----------
    stand : Stand
    model : Model or Sensor
        Of a sensor alone the outputs are compared.
    criterion : Criterion or Objectives
        One criterion, or several objectives whose front is sought.
    n : int
        Number of positions.
    fixed : array (f, d), in rad, optional
        Positions that must be in the program, measured already perhaps; the stand's limits do
        not bind them. They come first in every program. A copy is kept that can't be changed.
    replicates : bool
        Whether positions may occur more than once. Otherwise any two differ: by one stop, or where
        the stand has no steps by one degree in what the sensor feels.
    dwell_s : float, s
        Time in each position, for models whose noise or readings depend on it.

    Raises
    ------
    ArgumentError
        An n that is not a whole number, too small for the model or for the fixed positions, or
        too large for memory; fixed positions of another shape, or not finite.
    CompatibilityError
        A model that needs what the stand does not provide; fewer stops than positions without
        replicates.
    """

    stand: Stand
    model: Model
    criterion: Criterion | Objectives
    n: int
    fixed: Array | None = None
    replicates: bool = True
    dwell_s: float = 60.0

    def __post_init__(self) -> None:
        require_part("stand", self.stand, Stand)
        object.__setattr__(self, "model", as_model(self.model))
        require_part("criterion", self.criterion, (Criterion, Objectives))
        check_dwell(self.model, self.dwell_s)
        check_parts(self.stand, self.model, self.dwell_s)
        _check_n(self.n, self.model)
        object.__setattr__(self, "n", int(self.n))
        object.__setattr__(self, "replicates", require_switch("replicates", self.replicates))
        if self.fixed is not None:
            object.__setattr__(self, "fixed", _checked(self.fixed, len(self.stand.settings)))
        if self.held >= self.n:
            raise ArgumentError(
                f"n={self.n} with {self.held} fixed positions leaves nothing to choose: "
                f"n counts them too, so give n={self.held + 1} or more"
            )
        self.criterion.check(self.model.parameters)

    @property
    def _asked(self) -> tuple[object, ...]:
        fixed = None if self.fixed is None else (self.fixed.shape, self.fixed.tobytes())
        return self.stand, self.model, self.criterion, self.n, fixed, self.replicates, self.dwell_s

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Problem) and self._asked == other._asked

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if self.fixed is not None:
            self.fixed.flags.writeable = False  # which no copy keeps by itself

    def __hash__(self) -> int:
        return hash((self.n, self.held, self.replicates, type(self.stand), type(self.model)))

    @property
    def held(self) -> int:
        """Number f of positions that are fixed, the first ones of every program."""
        return 0 if self.fixed is None else len(self.fixed)

    @property
    def d(self) -> int:
        """Number of settings of a position."""
        return len(self.stand.settings)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The p parameters that are to be estimated, in the order of the information matrix."""
        return self.model.parameters

    @cached_property
    def response(self) -> Response:
        """What settings show of the parameters."""
        return Response(self.stand, self.model, self.dwell_s)

    @cached_property
    def objective(self) -> Objective:
        """How good programs are by the criterion.

        Raises
        ------
        CompatibilityError
            Several objectives, which have no single loss.
        """
        if isinstance(self.criterion, Objectives):
            raise CompatibilityError(
                f"the objectives {self.criterion.label} have no single loss; take one criterion alone, or multiply "
                "them to a product"
            )
        return Objective(self.response, self.criterion)

    @cached_property
    def restrictions(self) -> Restrictions:
        """Which programs there are to choose from."""
        feels = tuple(name for name in self.model.needs if name not in ("dwell", "time"))
        return Restrictions(self.stand, feels, self.n, self.fixed, self.replicates, self.model.ordered)

    @cached_property
    def singles(self) -> tuple[Problem, ...]:
        """The same problem under each objective alone; itself where there is one criterion."""
        if not isinstance(self.criterion, Objectives):
            return (self,)
        return tuple(self.with_criterion(single) for single in self.criterion.criteria)

    def with_criterion(self, criterion: Criterion) -> Problem:
        """The same problem for another criterion."""
        return replace(self, criterion=criterion)

    def information(self, settings: Array) -> Information:
        """Information of programs: settings (..., n, d) in rad to matrices (..., p, p)."""
        return self.response.information(settings)

    def loss(self, settings: Array) -> Array:
        """Loss of programs, +inf where singular or not permitted: settings (..., n, d) in rad to (...).

        Raises
        ------
        PluginError
            Where a criterion raises or returns something other than one number a program.
        """
        losses = self.objective.loss(settings)
        return np.where(self.restrictions.permits(settings), losses, np.inf) if self.restrictions.active else losses

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        """Loss (...), as above, and its gradient (..., n, d) with respect to the settings in rad."""
        loss, gradient = self.objective.loss_and_gradient(settings)
        if self.restrictions.active:
            loss = np.where(self.restrictions.permits(settings), loss, np.inf)
        return loss, gradient

    def losses(self, settings: Array) -> Array:
        """Loss of programs under each of the k objectives: (..., n, d) in rad to (..., k)."""
        return np.stack([single.loss(settings) for single in self.singles], axis=-1)

    @cached_property
    def base_share(self) -> Array:
        """Of the information of the fixed positions, and the prior, what falls to each of the others, (p, p)."""
        prior = np.diag(self.model.prior_information)
        held = prior if self.fixed is None else self.information(self.fixed).matrix
        return held / (self.n - self.held)

    @property
    def based(self) -> bool:
        """Whether there is information before any position is chosen: of fixed ones, or of a prior."""
        return self.held > 0 or self.model.informed


def _checked(fixed: object, d: int) -> Array:
    """Fixed positions as an array of their own, which nothing can change."""
    try:
        array = np.array(fixed, dtype=float) + 0.0  # no negative zeros, which are equal and look different
    except (TypeError, ValueError) as error:
        raise ArgumentError.of("fixed", fixed, f"give an array of positions (f, {d}), in rad") from error
    if array.ndim != 2 or array.shape[1] != d or not len(array):
        raise ArgumentError(f"fixed: positions of shape {array.shape}; the stand takes (f, {d}), in rad")
    if not np.isfinite(array).all():
        raise ArgumentError("fixed: positions must be finite numbers")
    array.flags.writeable = False
    return array


def _check_n(n: int, model: Model) -> None:
    name, p, least = model.called, len(model.parameters), model.smallest_n
    if not is_whole(n):
        raise ArgumentError.of("n", n, f"the number of positions must be a whole number, such as n={2 * least}")
    if n < least:
        raise ArgumentError.of("n", n, f"the {p} parameters of {name} need {least} positions or more")
    # the rows and their derivatives, for several programs at a time
    each = model.outputs * p * 8 * 128
    need = n * each
    if need > _MEMORY_LIMIT_BYTES:
        most = _MEMORY_LIMIT_BYTES // each
        raise ArgumentError.of("n", n, f"would take about {need / 2**30:.0f} GB of memory; n={most} is the most")
