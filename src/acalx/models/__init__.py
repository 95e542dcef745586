"""Measurement models: how a sensor's error parameters show in its readings."""

from acalx.models.base import Model
from acalx.models.scalar_accel import ScalarAccel

__all__ = ["Model", "ScalarAccel"]
