"""Whether a stand provides what a model needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Protocol

from acalx.errors import CompatibilityError, Option
from acalx.quantities.stimulus import Stimulus, conversion

__all__ = ["Provider", "check_provided"]

# What stand to take where one lacks a quantity and the model does not say.
_GIVEN_BY: Mapping[str, str] = MappingProxyType(
    {
        "angular_rate": "rate_table",
        "angular_acceleration": "two_axis_rate_table",
        "magnetic_field": "magnetic_table",
        "temperature": "chamber",
    }
)


class Provider(Protocol):
    """What a model asks of an `acalx.stands.Stand`."""

    def advice(self, quantity: str) -> tuple[str, Mapping[str, Option]]:
        """What would bring a quantity about, and the options that the words name."""
        ...


def check_provided(needs: Iterable[str], called: str, suits: str | None, stimulus: Stimulus, stand: Provider) -> None:
    """Raise CompatibilityError where a quantity is not there, or comes in a unit that can't be read.

    Parameters
    ----------
    needs : iterable of str, or mapping to units
        Of the model.
    called : str
        What messages call the model.
    suits : str, optional
        The stand that suits it.
    stimulus : Stimulus
        That the stand gives in some positions.
    stand : Provider
    """
    wanted = needs if isinstance(needs, Mapping) else dict.fromkeys(needs)
    for name, unit in wanted.items():
        if name not in stimulus and name in ("dwell", "time"):
            continue  # which the program itself tells
        if name not in stimulus:
            advice, options = stand.advice(name)
            if not advice and (suited := suits or _GIVEN_BY.get(name)):
                advice, options = "; use {suited}", {"suited": Option("stand", suited)}
            raise CompatibilityError(
                "model {model} needs the {quantity}, which stand {stand} does not provide" + advice,
                model=called,
                quantity=name.replace("_", " "),
                stand=type(stand).__name__,
                **options,
            )
        given = stimulus.units[name]
        if unit is not None and conversion(given, unit) is None:
            told = given or "a unit that it does not tell"
            raise CompatibilityError(
                f"model {called} needs the {name.replace('_', ' ')} in {unit}, but stand "
                f"{type(stand).__name__} gives it in {told}: let the stand give it in {unit}, and say so by "
                f"units={{{name!r}: {unit!r}}} of its Stimulus, or let the sensor take it as it comes"
            )
