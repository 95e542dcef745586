"""What residuals are called, and what they are in."""

from __future__ import annotations

from acalx.models import Model

__all__ = ["OF_MODEL", "names_of_residuals", "suffix", "unit_of_residuals"]

# What residuals are in that have no unit of their own.
OF_MODEL = "times the model's noise"


def unit_of_residuals(model: Model) -> str:
    """What residuals are in, as names in files end: the channels' unit where that, with noise 1, is all they have."""
    alike = {(channel.unit, channel.noise) for channel in model.channels}
    unit, noise = alike.pop() if len(alike) == 1 else (OF_MODEL, 1.0)
    return suffix(unit if noise == 1.0 else OF_MODEL)


def names_of_residuals(model: Model) -> list[str]:
    """Names of the residuals of a position: those of the channels where these are compared, else numbers."""
    if model.outputs == len(model.channels):
        return [channel.name for channel in model.channels]
    return [str(k + 1) for k in range(model.outputs)]


def suffix(unit: str) -> str:
    """A unit as the end of a name in files: ``deg_s`` of deg/s."""
    return "relative" if unit == OF_MODEL else "".join(c if c.isalnum() else "_" for c in unit).strip("_") or "1"
