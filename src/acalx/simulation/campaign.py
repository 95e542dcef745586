"""Readings of many simulated sensors, each put through the same program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.models import Model
from acalx.numerics.arrays import Array, components
from acalx.problem.parts import check_readings
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
    readings : array (T, n, k)
        Each channel in its unit.
    known : Stimulus, arrays (n, width) or (T, n, width)
        What those who calibrate take for that which the sensors felt.
    """

    parameters: Array
    readings: Array
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
    dwell_s : float, s
        In each position, for models that ask for it.

    Raises
    ------
    CompatibilityError
        Magnitudes that are not those of the model's groups.
    PluginError
        A sensor that does not give what it must.
    """

    model: Model
    stand: Stand
    settings: Array
    sources: ErrorSources
    seed: int
    shuffled: bool = False
    dwell_s: float = 60.0

    def __post_init__(self) -> None:
        self.model.check(self.nominal, self.stand)
        check_readings(self.model, self.nominal)
        self.sources.check(self.model, self.stand)

    @property
    def n(self) -> int:
        """Number of positions that each sensor is put into."""
        return len(self.settings)

    @cached_property
    def nominal(self) -> Stimulus:
        """What a sensor feels where nothing goes wrong, arrays (n, width)."""
        return self._timed(self.stand.stimulus(self.settings))

    @property
    def channels(self) -> int:
        """Number k of readings in a position, as of the axes of a triad."""
        return len(self.model.channels)

    def trials(self, begin: int, end: int) -> Trials:
        """Trials from number `begin`, a multiple of `BLOCK`, to before number `end`."""
        sources, p = self.sources, len(self.model.parameters)

        def draw(stream: str, *shape: int) -> Array:
            return _draw(self.seed, stream, begin, end, shape)

        parameters = sources.true_parameters(self.model, draw("sign", p), draw("size", p))
        off = self._installation(draw)
        known = self.nominal if off is None or not sources.installation_known else self._installed(off)
        true = self.nominal if off is None else self._installed(off)
        if sources.setting_rad:
            trial = (0, 1) if sources.setting_repeats else (begin, end)
            true = _turned(true, sources.setting_rad * _draw(self.seed, "setting", *trial, (self.n, 3)))
        if sources.knowledge_rad is not None:
            known = _turned(true, sources.knowledge_rad * draw("knowledge", self.n, 3))
        if sources.gravity and "specific_force" in true:
            factor = 1.0 + sources.gravity * draw("gravity")
            true = true.made({**true, "specific_force": _along(factor, true) * true["specific_force"]})
        readings = self.model.readings(parameters, true)
        deviations = self.model.deviations(true)
        noise = self.model.shared_noise(draw("noise", self.n, self.channels), true)
        readings = readings + (sources.noise * deviations) * noise
        if sources.drift:
            readings += self._warming_up(draw("order", self.n)) * (deviations * draw("drift", 1, self.channels))
        return Trials(parameters, readings, known)

    def _installation(self, draw: Callable[..., Array]) -> Array | None:
        """Angles (T, e) by which the stand's axes are off."""
        if not any(self.sources.installation_arcsec):
            return None
        return self.sources.installation(draw("installation", len(self.stand.axis_errors)))

    def _installed(self, off: Array) -> Stimulus:
        return self._timed(self.stand.misaligned(self.settings, off[:, None, :]))

    def _timed(self, stimulus: Stimulus) -> Stimulus:
        return stimulus.timed(self.model.needs, self.dwell_s)

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


def _along(factor: Array, stimulus: Stimulus) -> Array:
    """A factor (T,) of each trial, in front of positions, samples and components."""
    return factor.reshape(-1, *(1,) * (2 if stimulus.weights is None else 3))


def _turned(stimulus: Stimulus, rotation: Array) -> Stimulus:
    """All vectors (n, 3) or (T, n, 3) turned about small rotation vectors (T, n, 3), in rad; the rest as it is.

    By Cayley's map, an exact rotation; its angle differs from the vector's length in third order.
    """
    if stimulus.weights is not None:  # the same in all the samples of a position
        rotation = rotation[..., None, :]
    qx, qy, qz = (0.5 * rotation[..., k] for k in range(3))
    factor = 2.0 / (1.0 + qx * qx + qy * qy + qz * qz)
    turned = dict(stimulus)
    for name, vector in stimulus.items():
        if vector.shape[-1] != 3:
            continue
        x, y, z = (vector[..., k] for k in range(3))
        cx, cy, cz = qy * z - qz * y, qz * x - qx * z, qx * y - qy * x
        turned[name] = components(
            x + factor * (cx + qy * cz - qz * cy),
            y + factor * (cy + qz * cx - qx * cz),
            z + factor * (cz + qx * cy - qy * cx),
        )
    return stimulus.made(turned)
