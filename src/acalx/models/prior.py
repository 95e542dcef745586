"""What is known of parameters before anything is measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from acalx.errors import ArgumentError, Option
from acalx.numerics.arrays import Array
from acalx.options import is_number
from acalx.quantities.parameter import Parameter, parameter_groups
from acalx.sensors.polynomial import require_noise

__all__ = ["noise_of", "prior_information", "require_told"]

# Standard deviations between these can be squared, and inverted, with room for what is multiplied by that.
_LEAST, _MOST = 1e-100, 1e100


def prior_information(prior: Mapping[str, float], parameters: tuple[Parameter, ...]) -> Array:
    """1 / sd^2 of each parameter, (p,), from standard deviations by the names of parameters or groups.

    Raises
    ------
    ArgumentError
        A name that there is not, a number that is not positive or can't be squared, anything but a mapping.
    """
    if not isinstance(prior, Mapping):
        raise ArgumentError.of("prior", prior, "give standard deviations by parameter or group", {"bias": 0.01})
    groups, names = parameter_groups(parameters), {one.name: [k] for k, one in enumerate(parameters)}
    information = np.zeros(len(parameters))
    for single in (False, True):  # a parameter's own goes before that of its group
        for name, deviation in prior.items():
            if name not in groups and name not in names:
                raise ArgumentError.of("prior", {name: deviation}, f"give parameters or groups, {', '.join(groups)}")
            if not is_number(deviation) or deviation <= 0:
                raise ArgumentError.of("prior", {name: deviation}, "a standard deviation is a positive number")
            if not _LEAST <= deviation <= _MOST:
                rule = "a standard deviation is a positive number that can be squared, from 1e-100 to 1e100"
                raise ArgumentError.of("prior", {name: deviation}, rule)
            if (name in names) == single:
                information[names[name] if single else groups[name]] = 1.0 / float(deviation) ** 2
    return information


def noise_of(name: str, noise: float | None) -> float:
    """The noise of a reading in an option that need not be told: 1, in units of which results are then."""
    return 1.0 if noise is None else require_noise(name, noise)


def require_told(name: str, noise: float | None, prior: Mapping[str, float] | None, example: float) -> None:
    """Raise ArgumentError for a prior, in the units of the parameters, beside a noise that is not told in any.

    Parameters
    ----------
    name : str
        Of the option that tells the noise.
    noise : float, optional
    prior : mapping, optional
    example : float
        A noise that such sensors have.
    """
    if noise is None and prior:
        raise ArgumentError(
            "{given}: a prior is in the units of the parameters, so the noise of a reading must be told too, "
            "as in {told}",
            given=Option("prior", dict(prior)),
            told=Option(name, example),
        )
