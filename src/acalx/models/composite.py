"""Several models read at the same positions, as one."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from itertools import starmap
from typing import Any

import numpy as np

from acalx.models.base import Model, Noises, noises_of
from acalx.models.blocks import Places, in_places, runs
from acalx.models.comparisons import Comparison
from acalx.models.jacobian import Jacobian, PartByPart, placed
from acalx.numerics.arrays import Array, empty_as
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Channel

__all__ = ["Composite"]


class Composite(Model):
    """Models that are each read in every position; a new composite gives `models`.

    Regressors stack the outputs of the parts. Where no parameter is common to several of them, the information is
    block-diagonal, each block that of a part.
    """

    @property
    @abstractmethod
    def models(self) -> tuple[Model, ...]:
        """The parts, in the order of their parameters and outputs."""

    @property
    def usual(self) -> Mapping[str, Any]:  # type: ignore[override]
        """What suits the part that needs most."""
        most = max(self.models, key=lambda model: len(tuple(model.needs)))
        return {option: choice for option, choice in most.usual.items() if option != "n"}

    @property
    def prefixes(self) -> tuple[str, ...]:
        """What stands before the names of the parameters and channels of each part."""
        return ("",) * len(self.models)

    @property
    def shared(self) -> tuple[str, ...]:
        """Names of parameters that are the same one in all the parts that have it; without prefix."""
        return ()

    @cached_property
    def _named(self) -> tuple[tuple[Parameter, ...], ...]:
        """The parameters of each part as they are called here, each part a sensor of its own, or several."""
        parts = enumerate(zip(self.models, self.prefixes, strict=True))
        return tuple(tuple(self._called_here(o, prefix, k) for o in one.parameters) for k, (one, prefix) in parts)

    def _called_here(self, one: Parameter, prefix: str, number: int) -> Parameter:
        if one.name in self.shared:
            return one
        sensor = f"{number}.{one.sensor}" if one.sensor else f"{number}"
        return replace(one, name=prefix + one.name, group=prefix + one.group, sensor=sensor)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters of all the parts, those that are shared once."""
        return tuple({one.name: one for part in self._named for one in part}.values())

    @property
    def needs(self) -> Mapping[str, str | None]:
        """The quantities of the stimulus that any of the parts reads, each once, with the unit of the first."""
        needs: dict[str, str | None] = {}
        for model in self.models:
            own = model.needs if isinstance(model.needs, Mapping) else dict.fromkeys(model.needs)
            needs = {**own, **needs}
        return needs

    @property
    def widths(self) -> Mapping[str, int]:
        """Those of the parts."""
        return {name: width for model in reversed(self.models) for name, width in model.widths.items()}

    @property
    def outputs(self) -> int:
        """Number m of residuals in a position, those of all the parts together."""
        return sum(model.outputs for model in self.models)

    @property
    def degree(self) -> int | None:
        """Degree of the rows as polynomials in the stimulus, the largest of the parts; None if one of them has none."""
        degrees = [model.degree for model in self.models]
        return max((degree for degree in degrees if degree is not None), default=None) if None not in degrees else None

    @property
    def coupled(self) -> bool:
        """Where that of a part does."""
        return any(model.coupled for model in self.models)

    @property
    def entries(self) -> int:
        """Number of entries of the rows of a position that are not zero in every position: the blocks of the parts."""
        return sum(model.entries for model in self.models)

    @property
    def smallest_n(self) -> int:
        """The fewest positions that determine the parameters of every part: they are read in the same positions."""
        return super().smallest_n if self.shared else max(model.smallest_n for model in self.models)

    @property
    def prior_information(self) -> Array:
        """What is known before, that of the parts; of a shared parameter by all of them."""
        total = np.zeros(len(self.parameters))
        for model, (_, own) in zip(self.models, self._blocks, strict=True):
            total[own] += model.prior_information
        return total

    def check(self, stimulus: Stimulus, stand: object) -> None:
        """Raise CompatibilityError where the stand does not provide what one of the parts needs."""
        super().check(stimulus, stand)  # type: ignore[arg-type]
        for model in self.models:
            model.check(stimulus, stand)  # type: ignore[arg-type]

    # ---- design

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows (..., n, m, p), zero where an output does not depend on a parameter."""
        return self.jacobian(stimulus).regressors

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows, (..., n, m, p, width)."""
        derivatives: dict[str, Array] = {}
        for model, (outputs, own) in zip(self.models, self._blocks, strict=True):
            for name, part in model.derivative(stimulus).items():
                if name not in derivatives:
                    shape = (*part.shape[:-3], self.outputs, len(self.parameters), part.shape[-1])
                    derivatives[name] = empty_as(part, shape)
                    derivatives[name][...] = 0.0
                derivatives[name][..., outputs, own, :] = part
        return stimulus.made(derivatives)

    def jacobian(self, stimulus: Stimulus) -> Jacobian:
        """Those of the parts, each in its place."""
        parts = [model.jacobian(stimulus) for model in self.models]
        return PartByPart(self, stimulus, parts, self._blocks, bool(self.shared))

    def information_of(self, regressors: Array) -> Information:
        """Information of programs whose rows (..., n, m, p) are there already."""
        parts = zip(self.models, self._blocks, strict=True)
        found = [model.information_of(regressors[..., out, own]) for model, (out, own) in parts]
        return placed(found, [own for _, own in self._blocks], self.parameters, shared=bool(self.shared))

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the rows, (..., n, m, p), to the stimulus, summed over parts."""
        total: dict[str, Array] = {}
        for model, (outputs, own) in zip(self.models, self._blocks, strict=True):
            for name, part in model.pull(stimulus, rows[..., outputs, own]).items():
                total[name] = total[name] + part if name in total else part
        return stimulus.made(total)

    @cached_property
    def _blocks(self) -> tuple[tuple[slice, Places], ...]:
        """Outputs and parameters of each part."""
        outputs = list(starmap(slice, runs([model.outputs for model in self.models])))
        if not self.shared:
            own: list[Places] = list(starmap(slice, runs([len(model.parameters) for model in self.models])))
        else:
            numbers = {one.name: k for k, one in enumerate(self.parameters)}
            own = [np.array([numbers[one.name] for one in part]) for part in self._named]
        return tuple(zip(outputs, own, strict=True))

    # ---- simulation and estimation

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Those of all the parts."""
        parts = zip(self.models, self.prefixes, strict=True)
        return tuple(replace(one, name=prefix + one.name) for model, prefix in parts for one in model.channels)

    @property
    def knows(self) -> tuple[str, ...]:
        """What any of the parts must know of each position."""
        return tuple(dict.fromkeys(name for model in self.models for name in model.knows))

    @property
    def corrects_with(self) -> tuple[str, ...]:
        """What any of the parts must know of a reading to correct it."""
        return tuple(dict.fromkeys(name for model in self.models for name in model.corrects_with))

    @cached_property
    def _readings(self) -> tuple[slice, ...]:
        return tuple(starmap(slice, runs([len(model.channels) for model in self.models])))

    @cached_property
    def singles(self) -> tuple[tuple[Model, slice], ...]:
        """Those of the parts, with their channels among all of them."""
        parts = zip(self.models, self._readings, strict=True)
        return tuple(
            (one, slice(place.start + own.start, place.start + own.stop))
            for model, place in parts
            for one, own in model.singles
        )

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """What each of the parts reads, side by side."""
        parts = zip(self.models, self._blocks, strict=True)
        return np.concatenate([model.readings(parameters[..., own], stimulus) for model, (_, own) in parts], axis=-1)

    def deviations(self, stimulus: Stimulus) -> Array:
        """Standard deviations of the readings of all the parts."""
        each = [model.deviations(stimulus) for model in self.models]
        shape = np.broadcast_shapes(*(one.shape[:-1] for one in each))
        return np.concatenate([np.broadcast_to(one, (*shape, one.shape[-1])) for one in each], axis=-1)

    def shared_noise(self, noise: Array, stimulus: Stimulus) -> Array:
        """The noise of each part as its positions share it."""
        parts = zip(self.models, self._readings, strict=True)
        return np.concatenate([model.shared_noise(noise[..., place], stimulus) for model, place in parts], axis=-1)

    def residual(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """What parameters leave of the comparison of each part."""
        return self._side_by_side(lambda model, *given: model.residual(*given), parameters, readings, known)

    def linearized(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """The same to first order in the parameters."""
        return self._side_by_side(lambda model, *given: model.linearized(*given), parameters, readings, known)

    def _side_by_side(
        self, of: Callable[..., tuple[Array, Array]], parameters: Array, readings: Array, known: Stimulus | None
    ) -> tuple[Array, Array]:
        found = [
            of(model, parameters[..., own], readings[..., place], known)
            for model, (_, own), place in zip(self.models, self._blocks, self._readings, strict=True)
        ]
        return in_places(found, self._blocks, readings.shape[-2], self.outputs, len(self.parameters))

    @cached_property
    def noises(self) -> Noises:
        """Those of the parts; sensors of the same kind have the same."""
        numbers: dict[tuple[str, int], int] = {}
        each = [(one.kind, int(k)) for one, _ in self.singles for k in one.noises.of_outputs]
        return noises_of(np.array([numbers.setdefault(pair, len(numbers)) for pair in each]), self.shows)

    @property
    def shows(self) -> np.ndarray:
        """Those of the parts, each in its place."""
        found = np.zeros((self.outputs, len(self.parameters)), dtype=bool)
        for model, (outputs, own) in zip(self.models, self._blocks, strict=True):
            found[outputs, own] = model.shows
        return found

    def residual_deviations(self, parameters: Array, readings: Array, known: Stimulus | None, own: Array) -> Array:
        """Those of the parts, position by position."""
        parts = zip(self.models, self._blocks, self._readings, strict=True)
        each = [
            model.residual_deviations(parameters[place], readings[..., reads], known, own[..., reads])
            for model, (_, place), reads in parts
        ]
        return np.concatenate([one.reshape(len(readings), -1) for one in each], axis=-1).reshape(-1)

    def compares(self, comparison: Comparison) -> bool:
        """Whether that is what all of the parts compare."""
        return all(model.compares(comparison) for model in self.models)

    def start(self, readings: Array, known: Stimulus | None) -> Array:
        """Where the estimate of each part starts."""
        start = np.empty((*readings.shape[:-2], len(self.parameters)))
        for model, (_, own), place in zip(self.models, self._blocks, self._readings, strict=True):
            start[..., own] = model.start(readings[..., place], known)
        return start

    def felt(self, parameters: Array, readings: Array, known: Stimulus | None) -> Stimulus | None:
        """What any of the parts says of it, where together they say all."""
        known = Stimulus() if known is None else known.mean()
        found, units = dict(known), known.units
        for model, (_, own), place in zip(self.models, self._blocks, self._readings, strict=True):
            felt = model.felt(parameters[..., own], readings[..., place], known)
            if felt is not None:
                units = {**felt.units, **units}
                found = {**felt, **found}
        return super().felt(parameters, readings, Stimulus(found, units=units))

    def corrected(self, parameters: Array, readings: Array, known: Stimulus | None) -> Array:
        """What sensors without errors would have read, part by part."""
        parts = zip(self.models, self._blocks, self._readings, strict=True)
        each = [model.corrected(parameters[..., own], readings[..., place], known) for model, (_, own), place in parts]
        return np.concatenate(each, axis=-1)
