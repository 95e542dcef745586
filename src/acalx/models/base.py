"""The interface of a model: which parameters are to be estimated, and the regressors that show them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from acalx.models.jacobian import Jacobian, Whole
from acalx.models.numerical import numerical_derivative
from acalx.models.provided import Provider, check_provided
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.sensors.base import Channel, suits

if TYPE_CHECKING:
    from acalx.models.comparisons import Comparison

__all__ = ["Model", "Noises", "noises_of"]


class Noises(NamedTuple):
    """Residuals by the size of their noise, which is estimated for each where it is not known.

    Parameters
    ----------
    of_outputs : array (m,) of int
        The number, from 0, of the noise of each residual of a position.
    parameters : array (g,)
        How many parameters are fitted to the residuals of each.
    shared : bool
        Whether a parameter shows in residuals of several: then the sizes decide what the parameters come out as.
    """

    of_outputs: np.ndarray
    parameters: Array
    shared: bool = False


def noises_of(of_outputs: np.ndarray, touched: np.ndarray) -> Noises:
    """Noises from the number of each output, (m,), and which outputs each parameter shows in, (m, p).

    A parameter that shows in residuals of several is shared out between them.
    """
    count = int(of_outputs.max()) + 1
    shows = np.stack([touched[of_outputs == k].any(axis=0) for k in range(count)])
    in_each = shows.sum(axis=0)
    return Noises(of_outputs, (shows / np.maximum(in_each, 1)).sum(axis=1), bool((in_each > 1).any()))


class Model(ABC):
    """What is compared in each position, linear in the errors: m residuals for p parameters.

    As a rule a sensor and what of its readings is compared make a model, `Compared`. One that is given by
    `parameters`, `needs` and `regressors` alone has readings that are linear in its parameters, in units of
    their noise. Concrete models are frozen dataclasses.
    """

    # What suits the model where a user does not say: options by their groups, and `n`.
    usual: ClassVar[Mapping[str, Any]] = suits()
    # The option that tells the noise, where it may be left out; told, the errors that suit are those of the sensor.
    tells_noise: ClassVar[str] = ""

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """The p parameters, in the order of the regressors."""

    @property
    @abstractmethod
    def needs(self) -> Iterable[str]:
        """Names of the quantities of the stimulus that the regressors read; a mapping gives their units too."""

    @property
    def widths(self) -> Mapping[str, int]:
        """How many components each of the quantities that it needs has: three of a vector, one of others."""
        return {name: 3 if name in VECTORS else 1 for name in self.needs}

    @property
    def outputs(self) -> int:
        """Number m of residuals in a position."""
        return 1

    @property
    def kind(self) -> str:
        """What sensors like it are called; those of a kind are designed for together."""
        return type(self).__name__

    @property
    def by_kind(self) -> tuple[Model, ...]:
        """The model taken apart by kinds of sensors, in the order of its parameters; itself where it is of one kind."""
        return (self,)

    @property
    def degree(self) -> int | None:
        """Degree of the regressors as polynomials in the stimulus; None if they are none."""
        return None

    @property
    def smallest_n(self) -> int:
        """The fewest positions that can determine all the parameters; 1 or more, as few as a prior leaves to show."""
        return max(1, -(-(len(self.parameters) - int(np.count_nonzero(self.prior_information))) // self.outputs))

    @property
    def entries(self) -> int:
        """Number of entries of the rows of a position that are not zero in every position: m p, or fewer."""
        return self.outputs * len(self.parameters)

    @property
    def ordered(self) -> bool:
        """Whether the order of the positions matters: where what is read depends on the time since the start."""
        return "time" in tuple(self.needs)

    @property
    def coupled(self) -> bool:
        """Whether rows of a position depend on what is felt in others, or when: by noise that they share."""
        return False

    # ---- what design asks

    @abstractmethod
    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows h of H, (..., n, m, p), each divided by the noise standard deviation of its output."""

    @property
    def prior_information(self) -> Array:
        """What is known of each parameter before anything is measured, 1 / sd^2, (p,); zeros where nothing is."""
        return np.zeros(len(self.parameters))

    @cached_property
    def informed(self) -> bool:
        """Whether anything is known before."""
        return bool(self.prior_information.any())

    def jacobian(self, stimulus: Stimulus) -> Jacobian:
        """The rows, kept as information and its gradient take them best; by default as one array."""
        return Whole(self, stimulus, self.regressors(stimulus))

    def information(self, stimulus: Stimulus) -> Information:
        """Information of programs, matrices (..., p, p), with that of the prior."""
        return self.jacobian(stimulus).information

    def information_of(self, regressors: Array) -> Information:
        """Information of programs whose rows (..., n, m, p) are there already, with that of the prior."""
        return self.with_prior(Information.from_regressors(regressors, self.parameters))

    def with_prior(self, information: Information) -> Information:
        """The same with what is known before, where something is."""
        if not self.informed:
            return information
        return Information(information.matrix + np.diag(self.prior_information), self.parameters, information.blocks)

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the regressors with respect to the stimulus, arrays (..., n, m, p, width).

        Of means over K samples by each of them, (..., n, K, m, p, width). The default differentiates `regressors`
        numerically.
        """
        return numerical_derivative(self.regressors, stimulus, self.needs)

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the regressors, (..., n, m, p), to the stimulus, (..., n, width)."""
        by_stimulus = self.derivative(stimulus).items()
        if stimulus.weights is not None:
            rows = rows[..., None, :, :]
        return stimulus.made({name: np.einsum("...mp,...mpk->...k", rows, each) for name, each in by_stimulus})

    def check(self, stimulus: Stimulus, stand: Provider) -> None:
        """Raise CompatibilityError where the stand does not provide what the model needs, or in another unit."""
        check_provided(self.needs, self.called, self.usual.get("stand"), stimulus, stand)

    @property
    def called(self) -> str:
        """What messages call it."""
        return type(self).__name__

    # ---- what simulation and estimation ask; by default of a model that is linear, its outputs its readings

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What is read in each position, k numbers; by default the m outputs in units of their noise."""
        return tuple(Channel(f"reading_{k + 1}", "1") for k in range(self.outputs))

    @property
    def nominal(self) -> Array:
        """The parameters of a sensor without errors, (p,)."""
        return np.array([parameter.nominal for parameter in self.parameters])

    @property
    def knows(self) -> tuple[str, ...]:
        """The quantities that must be known of each position to estimate; by default all that the regressors read."""
        return tuple(self.needs)

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Noise-free readings (..., n, k) of a sensor with these parameters (..., p), each channel in its unit."""
        return np.asarray((self.regressors(stimulus) @ parameters[..., None, :, None])[..., 0])

    def deviations(self, stimulus: Stimulus) -> Array:
        """Standard deviations of the readings, (k,) or (..., n, k)."""
        return np.array([channel.noise for channel in self.channels])

    def shared_noise(self, noise: Array, stimulus: Stimulus) -> Array:
        """Independent noise (..., n, k) of unit variance as positions share it; by default they share none."""
        return noise

    def residual(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """What parameters leave of the comparison, over its noise, and the rows there.

        Parameters
        ----------
        parameters : array (..., p)
        readings : array (..., n, k)
        known : arrays (n, width) or (..., n, width), or None
            What is known of the stimulus.

        Returns
        -------
        residual, array (..., n m), and rows, array (n m, p) or (..., n m, p): the residual is
        rows (true - assumed), to first order
        """
        return self.linearized(parameters, readings, known)

    def linearized(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """The same to first order in the parameters, with the rows of a sensor without errors."""
        assert known is not None  # `knows` says all of it
        rows = self.regressors(known)
        *stack, n, m, p = rows.shape
        rows = rows.reshape((*stack, n * m, p))
        whole = readings.reshape((*readings.shape[:-2], n * m))
        return whole - np.einsum("...np,...p->...n", rows, parameters), rows

    def start(self, readings: Array, known: Stimulus | None) -> Array:
        """Parameters (..., p) from which to estimate, from readings (..., n, k); by default the nominal ones."""
        return np.broadcast_to(self.nominal, (*readings.shape[:-2], len(self.parameters)))

    def felt(self, parameters: Array, readings: Array, known: Stimulus | None) -> Stimulus | None:
        """What was felt in positions (n, k), as far as it is known or follows from the readings; None where not all."""
        return known if known is not None and all(name in known for name in self.needs) else None

    def corrected(self, parameters: Array, readings: Array, known: Stimulus | None) -> Array:
        """Readings (..., n, k) as a sensor without errors would have given them."""
        assert known is not None  # `corrects_with` says what it takes
        return readings - self.readings(parameters, known) + self.readings(self.nominal, known)

    @property
    def by_length(self) -> bool:
        """Whether readings of three channels lie on a sphere, nearly, whose radius tells their unit."""
        return False

    def compares(self, comparison: Comparison) -> bool:
        """Whether that is what it compares of its readings."""
        return False

    def residual_deviations(self, parameters: Array, readings: Array, known: Stimulus | None, own: Array) -> Array:
        """Standard deviations (n m,) of the residuals, in units of the model's, of readings with their own (n, k)."""
        return np.asarray(own / self.deviations(Stimulus() if known is None else known)).reshape(-1)

    @property
    def shows(self) -> np.ndarray:
        """Which residuals of a position each parameter may show in, (m, p)."""
        return np.ones((self.outputs, len(self.parameters)), dtype=bool)

    @property
    def noises(self) -> Noises:
        """Which residuals of a position have noise of the same size, or of a size that is told relative to theirs."""
        return Noises(np.zeros(self.outputs, dtype=int), np.array([float(len(self.parameters))]))

    @property
    def lengths(self) -> Mapping[str, float]:
        """Vectors whose length it takes as known, with that length in the unit in which it takes them."""
        return {}

    @property
    def singles(self) -> tuple[tuple[Model, slice], ...]:
        """The models of one sensor each that it is made of, with their channels among its own; by default itself."""
        return ((self, slice(0, len(self.channels))),)

    @property
    def corrects_with(self) -> tuple[str, ...]:
        """The quantities that must be known of a reading to correct it."""
        return tuple(self.needs)
