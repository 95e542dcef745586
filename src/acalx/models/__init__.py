"""Measurement models: how a sensor's error parameters show in its readings."""

from typing import TYPE_CHECKING

from acalx.lazy import names_from

if TYPE_CHECKING:
    from acalx.models.base import Model
    from acalx.models.gyro_rate_table import GyroRateTable
    from acalx.models.joined import Composite, Joined
    from acalx.models.platform import Platform
    from acalx.models.platform_accel import PlatformAccel
    from acalx.models.platform_gyro import PlatformGyro
    from acalx.models.polynomial import Polynomial, Term
    from acalx.models.scalar_accel import ScalarAccel
    from acalx.models.scalar_accel_quadratic import ScalarAccelQuadratic
    from acalx.models.vector_accel import VectorAccel

__all__ = [
    "Composite",
    "GyroRateTable",
    "Joined",
    "Model",
    "Platform",
    "PlatformAccel",
    "PlatformGyro",
    "Polynomial",
    "ScalarAccel",
    "ScalarAccelQuadratic",
    "Term",
    "VectorAccel",
]

__getattr__ = names_from(
    __name__,
    {
        "acalx.models.base": ("Model",),
        "acalx.models.gyro_rate_table": ("GyroRateTable",),
        "acalx.models.joined": (
            "Composite",
            "Joined",
        ),
        "acalx.models.platform": ("Platform",),
        "acalx.models.platform_accel": ("PlatformAccel",),
        "acalx.models.platform_gyro": ("PlatformGyro",),
        "acalx.models.polynomial": (
            "Polynomial",
            "Term",
        ),
        "acalx.models.scalar_accel": ("ScalarAccel",),
        "acalx.models.scalar_accel_quadratic": ("ScalarAccelQuadratic",),
        "acalx.models.vector_accel": ("VectorAccel",),
    },
)
