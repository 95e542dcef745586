"""The errors that acalx raises on purpose; each says what was wrong and what would be right.

An error carries what it speaks of as data. Options in its message are `Option`, which the command line
spells as a user types them there and Python as arguments; nothing else makes sentences of them.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self, TypeVar, final

__all__ = [
    "AcalxError",
    "ArgumentError",
    "CompatibilityError",
    "DataError",
    "NoProgramError",
    "Option",
    "PluginError",
    "ProgramError",
    "SingularError",
    "asked",
]

_Answer = TypeVar("_Answer")


@final
@dataclass(frozen=True)
class Option:
    """An option that a message speaks of, with a value.

    Parameters
    ----------
    key : str
        As in the configuration: ``n``, ``stand.dip_deg``, ``optimizer``.
    value : object
        As in the configuration; of a group the name of the choice.
    python : str, optional
        What a caller from Python writes in the place of the value, ``Gradient()`` for the choice ``gradient``.
    argument : str, optional
        The name of the argument in Python, where it is not the last part of the key.
    """

    key: str
    value: object
    python: str | None = None
    argument: str | None = None

    def as_argument(self) -> str:
        """As an argument in Python: ``dip_deg=65``, ``optimizer=Gradient()``."""
        value = repr(self.value) if self.python is None else self.python
        return f"{self.argument or self.key.rpartition('.')[2]}={value}"


class AcalxError(Exception):
    """Base of every error that a user of acalx can cause and mend.

    Parameters
    ----------
    message : str
        Where there are data, with their names in braces.
    **data
        What the message speaks of. ``error.data`` has it for whoever handles the error.
    """

    def __init__(self, message: str, /, **data: Any) -> None:
        super().__init__(message)
        self.message, self.data = message, data

    def said(self, spell: Callable[[Option], str]) -> str:
        """The message, with options spelled in one way or another."""
        if not self.data:
            return self.message
        return self.message.format_map({name: _said(value, spell) for name, value in self.data.items()})

    def placed(self, place: Callable[[Option], Option]) -> Self:
        """The same error with the options that it speaks of where they are in a configuration."""
        error = type(self).__new__(type(self), *self.args)  # whatever its constructor takes
        error.__dict__.update(self.__dict__)
        error.data = {name: _placed(value, place) for name, value in self.data.items()}
        return error

    def __str__(self) -> str:
        return self.said(Option.as_argument)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self)!r})"


class ArgumentError(AcalxError, ValueError):
    """An option, bound, name or number that is not acceptable."""

    @classmethod
    def of(cls, key: str, value: object, rule: str, example: object = None) -> Self:
        """An option as it was given, ``starts=0``, and what would be right, perhaps with a value as an example."""
        given = Option(key, value)
        if example is None:
            return cls("{given}: {rule}", given=given, rule=rule)
        return cls("{given}: {rule}, as in {example}", given=given, rule=rule, example=Option(key, example))


class CompatibilityError(AcalxError):
    """Parts that do not fit together, e.g. an optimizer that can't handle a stand's steps."""


class NoProgramError(AcalxError):
    """No program that was looked at can estimate all the parameters."""


class ProgramError(AcalxError, ValueError):
    """A calibration program, or a file of one, that can't be used."""


class DataError(AcalxError, ValueError):
    """Measurements, or a file of them, that can't be used."""


class SingularError(DataError):
    """Positions that can't show all the parameters.

    Parameters
    ----------
    message : str
    inestimable : list of str
        The combinations of the parameters that they can't see.
    **data
        As of `AcalxError`.
    """

    def __init__(self, message: str, /, inestimable: list[str], **data: Any) -> None:
        super().__init__(message, **data)
        self.inestimable = inestimable

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (type(self), self.message, self.inestimable, self.data)


class PluginError(AcalxError):
    """A part written by somebody else that broke the contract of its interface."""


def asked(name: str, method: Callable[..., _Answer], *arguments: object) -> _Answer:
    """What a part that somebody else may have written answers; PluginError, with the place, where it raises.

    Parameters
    ----------
    name : str
        Of the method, with that of its class.
    method : callable
    *arguments
        That it is called with.
    """
    try:
        return method(*arguments)
    except AcalxError:
        raise
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        raise PluginError(
            f"{name} raised {type(error).__name__}: {error} ({frame.filename}, line {frame.lineno})"
        ) from error


def _said(value: object, spell: Callable[[Option], str]) -> object:
    """An option in words, or several, an error within an error in the same words; anything else as it is."""
    if isinstance(value, AcalxError):
        return value.said(spell)
    if isinstance(value, list) and value and isinstance(value[0], Option):
        return ", ".join(map(spell, value))
    return spell(value) if isinstance(value, Option) else value


def _placed(value: object, place: Callable[[Option], Option]) -> object:
    """An option, several, or those of an error within an error, elsewhere in a configuration."""
    if isinstance(value, AcalxError):
        return value.placed(place)
    if isinstance(value, list):
        return [_placed(each, place) for each in value]
    return place(value) if isinstance(value, Option) else value


def _rebuilt(kind: type[SingularError], message: str, inestimable: list[str], data: dict[str, Any]) -> SingularError:
    return kind(message, inestimable=inestimable, **data)
