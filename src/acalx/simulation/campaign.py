"""Readings of many simulated sensors, each put through the same program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from acalx.models import Model
from acalx.numerics.arrays import Array, components
from acalx.quantities.stimulus import Stimulus
from acalx.simulation.sources import ErrorSources
from acalx.stands import Stand

__all__ = ["BLOCK", "Campaign", "Trials"]

# Trials come in blocks, each from random streams of its own: trial k is the same however many
# there are, and however many are worked on at a time.
BLOCK = 1024
_STREAMS = ("sign", "size", "gravity", "installation", "setting", "knowledge", "noise", "drift", "order")


@final
@dataclass(frozen=True, eq=False)
class Trials:
    """Some trials of a campaign.

    Parameters
    ----------
    parameters : array (T, p)
        The true ones.
    measurement : array (T, n, k)
        Readings.
    known : Stimulus, arrays (n, 3) or (T, n, 3)
        What those who calibrate take for that which the sensors felt.
    """

    parameters: Array
    measurement: Array
    known: Stimulus


@final
@dataclass(frozen=True, eq=False)
class Campaign:
    """A program, visited with everything that goes wrong.

    Two campaigns with the same seed have the same sensors and, position by position, the same
    noise, so that what differs between them is due to the programs.

    Parameters
    ----------
    model : Model
    stand : Stand
    settings : array (n, d), in rad
        In the order of visit.
    sources : ErrorSources
    seed : int
    shuffled : bool
        Whether each trial visits the positions in a random order of its own; matters with drift.

    Raises
    ------
    CompatibilityError
        Magnitudes that are not those of the model's groups.
    """

    model: Model
    stand: Stand
    settings: Array
    sources: ErrorSources
    seed: int
    shuffled: bool = False

    def __post_init__(self) -> None:
        self.model.check(self.stand.stimulus(self.settings), self.stand)
        self.sources.check(self.model, self.stand)

    @property
    def n(self) -> int:
        """Number of positions that each sensor is put into."""
        return len(self.settings)

    @cached_property
    def nominal(self) -> Stimulus:
        """What a sensor feels where nothing goes wrong, arrays (n, 3)."""
        return self.stand.stimulus(self.settings)

    @cached_property
    def outputs(self) -> int:
        """Number k of readings in a position, as of the axes of a triad."""
        return int(self.model.measurement(np.zeros(len(self.model.parameters)), self.nominal).shape[-1])

    def trials(self, begin: int, end: int) -> Trials:
        """Trials from number `begin`, a multiple of `BLOCK`, to before number `end`."""
        sources, p = self.sources, len(self.model.parameters)

        def draw(stream: str, *shape: int) -> Array:
            return _draw(self.seed, stream, begin, end, shape)

        parameters = sources.true_parameters(self.model.parameters, draw("sign", p), draw("size", p))
        off = self._installation(draw)
        known = self.nominal if off is None or not sources.installation_known else self._installed(off)
        true = self.nominal if off is None else self._installed(off)
        if sources.setting_rad:
            trial = (0, 1) if sources.setting_repeats else (begin, end)
            true = _turned(true, sources.setting_rad * _draw(self.seed, "setting", *trial, (self.n, 3)))
        if sources.knowledge_rad is not None:
            known = _turned(true, sources.knowledge_rad * draw("knowledge", self.n, 3))
        if sources.gravity and true.specific_force is not None:
            factor = 1.0 + sources.gravity * draw("gravity")[:, None, None]
            true = replace(true, specific_force=true.specific_force * factor)
        measurement = self.model.measurement(parameters, true)
        measurement = measurement + sources.noise * draw("noise", self.n, self.outputs)
        if sources.drift:
            measurement += self._warming_up(draw("order", self.n)) * draw("drift", 1, self.outputs)
        return Trials(parameters, measurement, known)

    def _installation(self, draw: Callable[..., Array]) -> Array | None:
        """Angles (T, e) by which the stand's axes are off."""
        if not any(self.sources.installation_arcsec):
            return None
        return self.sources.installation(draw("installation", len(self.stand.axis_errors)))

    def _installed(self, off: Array) -> Stimulus:
        return self.stand.misaligned(self.settings, off[:, None, :])

    def _warming_up(self, order: Array) -> Array:
        """The drift of a unit start at each position, (n, 1) or (T, n, 1)."""
        visit = order.argsort(axis=-1).argsort(axis=-1) if self.shuffled else np.arange(self.n)
        return np.asarray(self.sources.drift * np.exp(-visit / self.sources.drift_positions)[..., None])


def _draw(seed: int, stream: str, begin: int, end: int, shape: tuple[int, ...]) -> Array:
    """Numbers (T, *shape) of a stream, standard normal, or for sizes and orders uniform.

    Along the trials in memory, for that is how they are worked on. The first positions are the
    same whatever their number is.
    """
    out = np.empty((*shape[::-1], end - begin))
    for first in range(begin, end, BLOCK):
        rng = np.random.default_rng([seed, _STREAMS.index(stream), first // BLOCK])
        drawn = (rng.random if stream in ("size", "order") else rng.standard_normal)((*shape, BLOCK))
        count = min(BLOCK, end - first)
        out[..., first - begin : first - begin + count] = np.moveaxis(drawn.T, 0, -1)[..., :count]
    return out.T


def _turned(stimulus: Stimulus, rotation: Array) -> Stimulus:
    """All quantities (n, 3) or (T, n, 3) turned about small rotation vectors (T, n, 3), in rad.

    By Cayley's map, an exact rotation; its angle differs from the vector's length in third order.
    """
    qx, qy, qz = (0.5 * rotation[..., k] for k in range(3))
    factor = 2.0 / (1.0 + qx * qx + qy * qy + qz * qz)
    turned = {}
    for name, vector in stimulus.quantities():
        x, y, z = (vector[..., k] for k in range(3))
        cx, cy, cz = qy * z - qz * y, qz * x - qx * z, qx * y - qy * x
        turned[name] = components(
            x + factor * (cx + qy * cz - qz * cy),
            y + factor * (cy + qz * cx - qx * cz),
            z + factor * (cz + qx * cy - qy * cx),
        )
    return Stimulus(**turned)
