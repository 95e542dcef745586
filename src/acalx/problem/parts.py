"""Whether a stand and a model give what they must, looked at before anyone counts on it: they may be a user's."""

from __future__ import annotations

from typing import Any

import numpy as np

from acalx.errors import PluginError, asked
from acalx.models import Model
from acalx.quantities.stimulus import Stimulus
from acalx.stands import Stand

__all__ = ["check_parts"]


def check_parts(stand: Stand, model: Model) -> None:
    """Look at what a stand gives at the ends of its limits, and what a model makes of it.

    Raises
    ------
    CompatibilityError
        A model that needs what the stand does not provide.
    PluginError
        Where one of them raises, or gives something else than finite numbers of the right shape.
    """
    settings = stand.axes.bounds.T
    name = f"{type(stand).__name__}.stimulus"
    stimulus = asked(name, stand.stimulus, settings)
    if not isinstance(stimulus, Stimulus):
        raise PluginError(f"{name} gave {type(stimulus).__name__}; expected a Stimulus")
    model.check(stimulus, stand)
    for quantity, values in stimulus.quantities():
        _require(f"{name}: {quantity}", values, (2, 3))
    rows = f"{type(model).__name__}.regressors"
    shape = (2, model.outputs, len(model.parameters))
    _require(rows, asked(rows, model.regressors, stimulus), shape)
    if not stand.axes.zones:  # within them the stand may have good reasons
        settings = stand.axes.random(np.random.default_rng(0), (2,))
        stimulus = asked(name, stand.stimulus, settings)
        for quantity, values in stimulus.quantities():
            _require_finite(f"{name}: {quantity}", values)
        _require_finite(rows, asked(rows, model.regressors, stimulus))


def _require(name: str, values: Any, shape: tuple[int, ...]) -> None:
    """Raise PluginError unless they are of this shape."""
    if np.shape(values) != shape:
        raise PluginError(f"{name} has shape {np.shape(values)}; expected {shape}")


def _require_finite(name: str, values: Any) -> None:
    """Raise PluginError unless they are finite."""
    if not np.isfinite(np.asarray(values, dtype=float)).all():
        raise PluginError(f"{name} is not finite")
