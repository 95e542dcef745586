"""The contract of a model."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from acalx.models import Model
from acalx.quantities.stimulus import Stimulus
from acalx.stands import Stand
from acalx.testing.rules import STACKS, N, require, require_close, require_derivative, require_shape, require_stacked

__all__ = ["check_model"]


def check_model(model: Model, stand: Stand, *, seed: int = 0) -> None:
    """Check a model on the stimulus of a stand: parameters, regressors, derivative.

    Parameters
    ----------
    model : Model
    stand : Stand
        One that provides what the model needs.
    seed : int
        Of the random settings.
    """
    p, m = len(model.parameters), model.outputs
    names = [parameter.name for parameter in model.parameters]
    require(p > 0 and m > 0, model, "there are parameters and outputs")
    require(len(set(names)) == p, model, f"each parameter has its own name, got {names}")
    known = {field.name for field in fields(Stimulus)}
    require(bool(model.needs) and set(model.needs) <= known, model, f"needs names quantities among {sorted(known)}")
    require(model.smallest_n * m >= p, model, f"smallest_n={model.smallest_n} gives fewer readings than parameters")
    for stack in STACKS:
        angles = stand.axes.random(np.random.default_rng(seed), (*stack, N))
        stimulus = stand.stimulus(angles)
        model.check(stimulus, stand)
        require_shape(model, "regressors", model.regressors(stimulus), (*stack, N, m, p))
        require_stacked(model, "regressors", lambda x: [model.regressors(stand.stimulus(x))], angles)
        turned = Stimulus(**{name: value[..., ::-1, :] for name, value in stimulus.quantities()})
        rule = "a position's rows depend on it alone, not on its place among the others"
        require_close(model, rule, model.regressors(turned), model.regressors(stimulus)[..., ::-1, :, :], 1e-9)
        exact, numerical = model.derivative(stimulus), Model.derivative(model, stimulus)
        require_derivative(model, exact, numerical, (*stack, N, m, p, 3))
