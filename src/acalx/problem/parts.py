"""Whether a stand and a model give what they must, looked at before anyone counts on it: they may be a user's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError, PluginError, asked
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.options import is_number
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.stands import Stand

__all__ = ["check_dwell", "check_parts", "check_readings"]

# Random positions in which a sensor must read something: what is nan somewhere is so in one of them, as a rule.
_TRIED = 64


def check_parts(stand: Stand, model: Model, dwell_s: float) -> None:
    """Look at what a stand gives at the ends of its limits, and what a model makes of it.

    Raises
    ------
    CompatibilityError
        A model that needs what the stand does not provide, or sets otherwise than it can bear.
    PluginError
        Where one of them raises, gives something else than finite numbers of the right shape, or changes what it is
        given.
    """
    name = f"{type(stand).__name__}.stimulus"
    stimulus = _felt(name, stand, stand.axes.bounds.T)
    model.check(stimulus, stand)
    if model.coupled and "dwell" in stimulus:
        raise CompatibilityError(
            f"the noise of {model.called} is shared by positions according to their times, which stand "
            f"{type(stand).__name__} sets: take a stand that leaves the time in a position to dwell_s"
        )
    _check_model(model, stimulus.timed(model.needs, dwell_s), finite=False)
    if not stand.axes.zones:  # within them the stand may have good reasons
        stimulus = _felt(name, stand, stand.axes.random(np.random.default_rng(0), (_TRIED,)))
        for quantity, values in stimulus.items():
            _require_finite(f"{name}: {quantity}", values)
        model.check(stimulus, stand)
        _check_model(model, stimulus.timed(model.needs, dwell_s), finite=True)


def check_dwell(model: Model, dwell_s: object) -> None:
    """Raise ArgumentError for a time in a position that is none, or zero where the model depends on it."""
    depends = bool({"dwell", "time"} & set(model.needs))
    if not is_number(dwell_s) or dwell_s < 0.0 or (depends and dwell_s == 0.0):
        rule = "give the seconds in each position, 0 or more"
        if depends:
            rule = f"give the seconds in each position, more than 0, since what {model.called} reads depends on them"
        raise ArgumentError.of("dwell_s", dwell_s, rule)


def check_readings(model: Model, stimulus: Stimulus) -> None:
    """Raise PluginError unless a sensor without errors reads something in each of some positions."""
    name = f"{model.called}.readings"
    found = asked(name, lambda felt: model.readings(model.nominal, felt), stimulus)
    _require_finite(name, found, stimulus)


def _felt(name: str, stand: Stand, settings: Array) -> Stimulus:
    """What is felt in some positions, of a shape that it can have."""
    stimulus = _unchanged(name, stand.stimulus, settings)
    if not isinstance(stimulus, Stimulus):
        raise PluginError(f"{name} gave {type(stimulus).__name__}; expected a Stimulus")
    weights = stimulus.weights
    samples = () if weights is None else np.shape(weights)
    if weights is not None and (len(samples) != 1 or abs(float(np.sum(weights)) - 1.0) > 1e-9):
        raise PluginError(f"{name}: weights of shape {samples}; expected one for each sample, with the sum 1")
    for quantity, values in stimulus.items():
        width = 3 if quantity in VECTORS else np.shape(values)[-1] if np.ndim(values) == 2 + len(samples) else 1
        _require(f"{name}: {quantity}", values, (len(settings), *samples, width))
    return stimulus


def _check_model(model: Model, stimulus: Stimulus, *, finite: bool) -> None:
    """Regressors and readings at what is felt in some positions, of a sensor without errors."""
    rows, reads = f"{model.called}.regressors", f"{model.called}.readings"
    n = len(next(iter(stimulus.values())))
    found = _unchanged(reads, lambda felt: model.readings(model.nominal, felt), stimulus)
    _require(reads, found, (n, len(model.channels)))
    if finite:
        _require_finite(reads, found, stimulus)
    with np.errstate(all="ignore"):  # at the ends of limits it may have good reasons
        found = _unchanged(rows, model.regressors, stimulus)
    _require(rows, found, (n, model.outputs, len(model.parameters)))
    if finite:
        _require_finite(rows, found, stimulus)


def _unchanged(name: str, method: Callable[[Any], Any], given: Any) -> Any:
    """What a method answers, which must leave what it is given as it is."""
    arrays = dict(given) if isinstance(given, Stimulus) else {"settings": given}
    before = {key: np.array(array) for key, array in arrays.items()}
    answer = asked(name, method, given)
    for key, array in before.items():
        if not np.array_equal(array, arrays[key], equal_nan=True):
            raise PluginError(
                f"{name} changed the {key.replace('_', ' ')} that it was given; it must leave it as it is"
            )
    return answer


def _require(name: str, values: Any, shape: tuple[int, ...]) -> None:
    """Raise PluginError unless they are of this shape."""
    if np.shape(values) != shape:
        raise PluginError(f"{name} has shape {np.shape(values)}; expected {shape}")


def _require_finite(name: str, values: Any, felt: Stimulus | None = None) -> None:
    """Raise PluginError, with what is felt in the first position where they are not, unless they are finite."""
    good = np.isfinite(np.asarray(values, dtype=float))
    if good.all():
        return
    if felt is None:
        raise PluginError(f"{name} is not finite")
    first = int(np.argmin(good.reshape(len(good), -1).all(axis=1)))
    words = (f"the {quantity.replace('_', ' ')} {_numbers(value[first])}" for quantity, value in felt.mean().items())
    raise PluginError(
        f"{name} is not finite in a position with {' and '.join(words)}: it must be wherever the stand goes; mend it, "
        "or keep the stand from going there by its limits or forbidden zones"
    )


def _numbers(values: Array) -> str:
    texts = [f"{value:.4g}" for value in values]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"
