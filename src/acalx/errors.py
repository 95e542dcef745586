"""The errors that acalx raises on purpose; each message says what was wrong and what would be right."""

from __future__ import annotations

__all__ = [
    "AcalxError",
    "ArgumentError",
    "CompatibilityError",
    "DataError",
    "NoProgramError",
    "PluginError",
    "ProgramError",
]


class AcalxError(Exception):
    """Base of every error that a user of acalx can cause and mend."""


class ArgumentError(AcalxError, ValueError):
    """An option, bound, name or number that is not acceptable."""


class CompatibilityError(AcalxError):
    """Parts that do not fit together, e.g. an optimizer that can't handle a stand's steps."""


class NoProgramError(AcalxError):
    """No program that was looked at can estimate all the parameters."""


class ProgramError(AcalxError, ValueError):
    """A calibration program, or a file of one, that can't be used."""


class DataError(AcalxError, ValueError):
    """Measurements, or a file of them, that can't be used."""


class PluginError(AcalxError):
    """A part written by somebody else that broke the contract of its interface."""
