"""Whether a sensor, somebody's own perhaps, gives what it must, looked at before anyone counts on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from acalx.errors import PluginError, asked
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus, conversion
from acalx.sensors.base import Channel, Sensor
from acalx.sensors.polynomial import Polynomial, components_of, multiplied

__all__ = ["check_declared", "check_sensor"]

# How far derivatives that are given may be from numerical ones: of the largest of a parameter, and of the readings.
_SLACK, _ROUNDING = 1e-5, 1e-8
# Errors of a sensor that is tried, as small as steps of numerical derivatives.
_OFF = 1e-3
# A sensor without errors reads what is felt, or a part of it that is not far less.
_HALF = 0.5


def check_declared(sensor: Sensor) -> None:
    """Look at what a sensor says of itself: parameters, channels, what it needs and senses, correlations.

    Raises
    ------
    PluginError
        None of them, something else than they are, names that are there twice, correlations that there can't be.
    """
    kind = type(sensor).__name__
    needs, senses = sensor.needs, sensor.senses
    if isinstance(needs, Mapping) and not needs:
        raise PluginError(f"{kind} needs nothing that is felt: readings that depend on nothing show no parameter")
    if not isinstance(needs, Mapping) or not all(isinstance(text, str) for pair in needs.items() for text in pair):
        raise PluginError(
            f"{kind}.needs is {needs!r}; give each quantity with the unit in which it is taken, as in "
            "{'specific_force': 'g'}"
        )
    if isinstance(senses, str) or not isinstance(senses, Sequence) or not set(senses) <= set(needs):
        raise PluginError(
            f"{kind}.senses is {senses!r}; give a tuple of quantities that its needs name: {_list(needs)}"
        )
    vectors = sensor.vectors
    if isinstance(vectors, str) or not isinstance(vectors, Sequence) or not set(vectors) <= set(needs):
        raise PluginError(
            f"{kind}.vectors is {vectors!r}; give a tuple of those quantities of its needs that are vectors: "
            f"{_list(needs)}"
        )
    for what, items, one in (("parameters", sensor.parameters, Parameter), ("channels", sensor.channels, Channel)):
        if not items:
            raise PluginError(f"{kind} has no {what}")
        if not all(isinstance(item, one) for item in items):
            raise PluginError(f"{kind}.{what} is {items!r}; give a tuple of {one.__name__}")
        called = [item.name for item in items]
        if twice := sorted({each for each in called if called.count(each) > 1}):
            raise PluginError(f"{kind}.{what}: {_list(twice)} is there twice; each needs a name of its own")
    _check_channels(sensor)
    if not np.isfinite(sensor.nominal).all():
        raise PluginError(f"{kind}.parameters: nominal values must be finite numbers")
    _check_correlation(sensor, f"{kind}.correlation")


def _check_channels(sensor: Sensor) -> None:
    """That products are those of channels that there are, and without errors read what is felt in the unit of these."""
    kind, k = type(sensor).__name__, len(sensor.channels)
    for number in [*(channel for channel, *_ in sensor.table or ()), *(channel for channel, *_ in sensor.ideal)]:
        if not 0 <= number < k:
            raise PluginError(f"{kind}: a product of channel {number}, but there are {k}, counted from 0")
    nominal = sensor.nominal
    scaled = ((channel, factor * nominal[p], product) for channel, p, factor, product in sensor.table or ())
    sizes: dict[tuple[int, tuple[str, int]], float] = {}
    for number, factor, product in (*sensor.ideal, *scaled):
        if len(product) == 1:
            sizes[number, product[0]] = sizes.get((number, product[0]), 0.0) + float(factor)
    squares: dict[tuple[int, str], float] = {}
    for (number, (quantity, _)), size in sizes.items():
        squares[number, quantity] = squares.get((number, quantity), 0.0) + size**2
    for (number, quantity), square in squares.items():
        given, channel = sensor.needs[quantity], sensor.channels[number]
        right = conversion(given, channel.unit)
        if right is not None and square > 0.0 and not _HALF < math.sqrt(square) / right < 1.0 / _HALF:
            raise PluginError(
                f"{kind}: without errors channel {channel.name} in {channel.unit} reads {math.sqrt(square):.4g} times "
                f"the {_words(quantity)} in {given}, where {right:.4g} would be right: put the factor right, or the "
                "unit, in needs or in the channel"
            )


def check_sensor(sensor: Sensor, felt: Stimulus) -> None:
    """Look at readings, their noise, and derivatives that are given, of a sensor without errors.

    Parameters
    ----------
    sensor : Sensor
    felt : Stimulus
        In one position or more, (..., n, width), in the units that the sensor takes.

    Raises
    ------
    PluginError
        Where one of them raises, has another shape than it must, or changes what it is given; a noise that is not
        positive; derivatives that are not those of the readings.
    """
    every = Stimulus({name: felt[name].reshape(-1, felt[name].shape[-1]) for name in sensor.needs}, units=felt.units)
    two = every.made({name: value[[0, -1]] for name, value in every.items()})
    k = len(sensor.channels)
    for stack in ((), (2,)):
        for n in (1, 2):
            at = two.made({name: np.broadcast_to(v[:n], (*stack, *v[:n].shape)).copy() for name, v in two.items()})
            for parameters in (sensor.nominal, np.stack([sensor.nominal, sensor.nominal + _OFF])):
                _check_readings(sensor, parameters, at, (*np.broadcast_shapes(stack, parameters.shape[:-1]), n, k))
    _check_deviations(sensor, every)
    if _given(sensor, "by_parameters"):
        _check_by_parameters(sensor, two)
    if sensor.table is not None and any(_given(sensor, name) for name in ("readings", "table", "ideal")):
        _check_table(sensor, two)
    if _given(sensor, "by_stimulus"):
        _check_by_stimulus(sensor, two)


def _check_readings(sensor: Sensor, parameters: Array, at: Stimulus, shape: tuple[int, ...]) -> None:
    """Their kind and shape, and that nothing changes what was given."""
    name = f"{type(sensor).__name__}.readings"
    before = {"parameters": parameters.copy(), **{quantity: value.copy() for quantity, value in at.items()}}
    found = _answer(sensor, name, sensor.readings, parameters, at)
    for what, value in before.items():
        if not np.array_equal(value, parameters if what == "parameters" else at[what], equal_nan=True):
            raise PluginError(f"{name} changed the {_words(what)} that it was given; it must leave it as it is")
    _require_array(name, found)
    if np.shape(found) != shape:
        given = f"parameters {parameters.shape} and {', '.join(f'{_words(q)} {v.shape}' for q, v in at.items())}"
        raise PluginError(
            f"{name} has shape {np.shape(found)}; expected {shape} from {given}: a number for each channel last, "
            "positions before it, stacks of either in front, as parameters[..., None, 0] and arrays[..., 0] give"
        )


def _check_deviations(sensor: Sensor, felt: Stimulus) -> None:
    """A positive number for each channel, the same in all positions or one for each of them."""
    name, k = f"{type(sensor).__name__}.deviations", len(sensor.channels)
    n = next(iter(felt.values())).shape[0]
    for stack in ((), (2,)):
        at = felt.made({quantity: np.broadcast_to(value, (*stack, *value.shape)) for quantity, value in felt.items()})
        found = _answer(sensor, name, sensor.deviations, at)
        _require_array(name, found)
        if found.shape not in ((k,), (*stack, n, k)):
            of = f" for {(*stack, n)} positions" if stack else ""
            raise PluginError(
                f"{name} has shape {found.shape}{of}; expected {(k,)}, or {(*stack, n, k)} where positions differ"
            )
    if not (np.isfinite(found) & (found > 0.0)).all():
        worst = found[~(np.isfinite(found) & (found > 0.0))].ravel()[0]
        raise PluginError(f"{name} gave {float(worst):g}; a standard deviation is a positive number")


def _check_by_parameters(sensor: Sensor, at: Stimulus) -> None:
    """That they are the derivatives of the readings."""
    name, p, k = f"{type(sensor).__name__}.by_parameters", len(sensor.parameters), len(sensor.channels)
    found = _answer(sensor, name, sensor.by_parameters, sensor.nominal, at)
    _require_array(name, found)
    if found.shape != (2, k, p):
        raise PluginError(f"{name} has shape {found.shape}; expected {(2, k, p)}: positions, channels, parameters")
    expected = _answer(sensor, name, lambda x, s: Sensor.by_parameters(sensor, x, s), sensor.nominal, at)
    _require_close(name, found, expected, [one.name for one in sensor.parameters])


def _check_table(sensor: Sensor, at: Stimulus) -> None:
    """That the products are those of the readings of a sensor without errors, and of their derivatives."""
    name, k, table = f"{type(sensor).__name__}.table", len(sensor.channels), sensor.table or ()
    products = [product for *_, product in table] + [product for *_, product in sensor.ideal]
    components = components_of(at, products)
    rows, reads = np.zeros((2, k, len(sensor.parameters))), np.zeros((2, k))
    for channel, number, factor, product in table:
        rows[..., channel, number] += multiplied(factor, product, components)
    for channel, factor, product in sensor.ideal:
        reads[..., channel] += multiplied(factor, product, components)
    expected = _answer(sensor, name, lambda x, s: Sensor.by_parameters(sensor, x, s), sensor.nominal, at)
    _require_close(name, rows, expected, [one.name for one in sensor.parameters])
    if sensor.ideal and not sensor.nominal.any():
        wanted = sensor.readings(sensor.nominal, at)
        _require_close(f"{type(sensor).__name__}.ideal", reads[..., None], wanted[..., None], ["nothing"])


def _check_by_stimulus(sensor: Sensor, at: Stimulus) -> None:
    """The same by each quantity that is felt."""
    name, k = f"{type(sensor).__name__}.by_stimulus", len(sensor.channels)
    found = _answer(sensor, name, sensor.by_stimulus, sensor.nominal, at)
    if not isinstance(found, Mapping) or not set(sensor.needs) <= set(found):
        raise PluginError(f"{name} must give the derivatives by each of {_list(sensor.needs)}, in a mapping")
    expected = _answer(sensor, name, lambda x, s: Sensor.by_stimulus(sensor, x, s), sensor.nominal, at)
    for quantity, wanted in expected.items():
        _require_array(f"{name}: {_words(quantity)}", found[quantity])
        if found[quantity].shape != wanted.shape:
            raise PluginError(
                f"{name}: {_words(quantity)} has shape {found[quantity].shape}; expected {(2, k, wanted.shape[-1])}: "
                "positions, channels, components"
            )
        axes = "xyz" if wanted.shape[-1] == 3 else range(1, wanted.shape[-1] + 1)
        _require_close(name, found[quantity], wanted, [f"{_words(quantity)} {axis}" for axis in axes])


def _check_correlation(sensor: Sensor, name: str) -> None:
    """That correlations of the noise in two positions, where there are any, are some."""
    found = asked(name, sensor.correlation, np.arange(2.0))
    if found is None:
        return
    if np.shape(found) != (2, 2):
        raise PluginError(f"{name} has shape {np.shape(found)} for 2 times; expected (2, 2), one for each pair of them")
    own, other = np.diag(found), found[0, 1]
    if not (np.allclose(own, 1.0) and abs(other) < 1.0 and np.isclose(other, found[1, 0])):
        raise PluginError(
            f"{name} gave {found.tolist()} for 2 times; correlations are 1 with themselves, less with others, and the "
            "same both ways"
        )
    times = np.array([[0.0, 1.0], [0.0, 2.0]])
    stacked: Any = asked(name, sensor.correlation, times)
    each = np.stack([np.asarray(asked(name, sensor.correlation, one)) for one in times])
    if np.shape(stacked) == (2, 2, 2) and not np.allclose(stacked, each):
        raise PluginError(
            f"{name} gives programs that are asked together, times (2, 2), others than alone; take times along the "
            "last axis, as times[..., :, None] - times[..., None, :] does"
        )
    if np.shape(stacked) != (2, 2, 2):
        raise PluginError(
            f"{name} has shape {np.shape(stacked)} for two programs of 2 times, (2, 2); expected (2, 2, 2), as "
            "times[..., :, None] - times[..., None, :] has it"
        )


def _answer(sensor: Sensor, name: str, method: Callable[..., Any], *given: Any) -> Any:
    """What a method answers; a quantity that it asks for and that is not among its needs is named."""
    try:
        with np.errstate(all="ignore"):  # at the ends of limits it may have good reasons
            return asked(name, method, *given)
    except PluginError as error:
        cause = error.__cause__
        if isinstance(cause, KeyError) and cause.args and cause.args[0] not in sensor.needs:
            raise PluginError(
                f"{name} asks for {cause.args[0]!r}, but {type(sensor).__name__}.needs names {_list(sensor.needs)}: "
                "name it there too, with its unit"
            ) from error
        raise


def _given(sensor: Sensor, name: str) -> bool:
    """Whether a sensor gives derivatives of its own; those of a table are exact."""
    return getattr(type(sensor), name) not in (getattr(Sensor, name), getattr(Polynomial, name))


def _require_array(name: str, found: Any) -> None:
    if isinstance(found, np.ndarray) and found.dtype.kind == "f" and found.dtype.itemsize < np.dtype(float).itemsize:
        raise PluginError(f"{name} gave an array of {found.dtype}; derivatives and estimates need double precision")
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
        what = f"an array of {found.dtype}" if isinstance(found, np.ndarray) else type(found).__name__
        raise PluginError(f"{name} gave {what}; expected an array of real numbers")


def _require_close(name: str, found: Array, expected: Array, names: Sequence[str]) -> None:
    """Raise PluginError, with the column that is farthest off, unless derivatives (n, k, columns) agree."""
    good = np.isfinite(expected)
    size = np.abs(np.where(good, expected, 0.0))
    limit = _SLACK * size.max(axis=(0, 1)) + _ROUNDING * max(1.0, float(size.max()))
    off = np.where(good, np.abs(found - expected), 0.0) / limit
    worst = tuple(map(int, np.unravel_index(np.argmax(np.where(np.isnan(off), np.inf, off)), off.shape)))
    if not off[worst] <= 1.0:
        raise PluginError(
            f"{name} is not the derivative of the readings: by {names[worst[-1]]} it is {found[worst]:.6g}, and "
            f"{expected[worst]:.6g} by differences; put it right, or leave it out, and it is found by differences"
        )


def _list(names: Sequence[str] | Mapping[str, str]) -> str:
    return ", ".join(names)


def _words(quantity: str) -> str:
    return quantity.replace("_", " ")
