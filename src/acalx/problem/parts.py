"""Whether a stand and a model give what they must, looked at before anyone counts on it: they may be a user's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from acalx.errors import ArgumentError, PluginError, asked
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.options import is_number
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.stands import Stand

__all__ = ["check_dwell", "check_parts"]


def check_parts(stand: Stand, model: Model, dwell_s: float) -> None:
    """Look at what a stand gives at the ends of its limits, and what a model makes of it.

    Raises
    ------
    CompatibilityError
        A model that needs what the stand does not provide.
    PluginError
        Where one of them raises, gives something else than finite numbers of the right shape, or changes what it is
        given.
    """
    name = f"{type(stand).__name__}.stimulus"
    stimulus = _felt(name, stand, stand.axes.bounds.T)
    model.check(stimulus, stand)
    _check_model(model, stimulus.timed(model.needs, dwell_s), finite=False)
    if not stand.axes.zones:  # within them the stand may have good reasons
        stimulus = _felt(name, stand, stand.axes.random(np.random.default_rng(0), (2,)))
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


def _felt(name: str, stand: Stand, settings: Array) -> Stimulus:
    """What is felt in two positions, of a shape that it can have."""
    stimulus = _unchanged(name, stand.stimulus, settings)
    if not isinstance(stimulus, Stimulus):
        raise PluginError(f"{name} gave {type(stimulus).__name__}; expected a Stimulus")
    weights = stimulus.weights
    samples = () if weights is None else np.shape(weights)
    if weights is not None and (len(samples) != 1 or abs(float(np.sum(weights)) - 1.0) > 1e-9):
        raise PluginError(f"{name}: weights of shape {samples}; expected one for each sample, with the sum 1")
    for quantity, values in stimulus.items():
        width = 3 if quantity in VECTORS else np.shape(values)[-1] if np.ndim(values) == 2 + len(samples) else 1
        _require(f"{name}: {quantity}", values, (2, *samples, width))
    return stimulus


def _check_model(model: Model, stimulus: Stimulus, *, finite: bool) -> None:
    """Regressors and readings at what is felt in two positions, of a sensor without errors."""
    rows, reads = f"{model.called}.regressors", f"{model.called}.readings"
    found = _unchanged(reads, lambda felt: model.readings(model.nominal, felt), stimulus)
    _require(reads, found, (2, len(model.channels)))
    if finite:
        _require_finite(reads, found)
    found = _unchanged(rows, model.regressors, stimulus)
    _require(rows, found, (2, model.outputs, len(model.parameters)))
    if finite:
        _require_finite(rows, found)


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


def _require_finite(name: str, values: Any) -> None:
    """Raise PluginError unless they are finite."""
    if not np.isfinite(np.asarray(values, dtype=float)).all():
        raise PluginError(f"{name} is not finite")
