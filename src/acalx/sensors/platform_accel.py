"""The accelerometers of an inertial platform."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.quantities.parameter import Parameter
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_axis, require_noise

__all__ = ["PlatformAccel"]

# Magnitudes as in simulations of Wang et al. (2016).
_SCATTER = {"bias": 5e-5, "scale": 5e-5, "misalignment": 1.5e-4}


@final
@dataclass(frozen=True)
class PlatformAccel(Polynomial):
    """Four error coefficients of a pendulous accelerometer whose orientation is known.

    With the specific force a in g, the accelerometer along axis i reads

        A = bias + (1 + scale) a_i + misalignment_j a_j + misalignment_k a_k   in g.

    Parameters
    ----------
    axis : str
        x, y or z, the axis along which it lies.
    noise_g : float, g
        Standard deviation of a reading; those of the coefficients are in g and rad then. With
        1, the default, they are in units of it.

    Raises
    ------
    ArgumentError
        An unknown axis, a noise that is not positive.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="platform_gimbals")
    axis: str = "x"
    noise_g: float = 1.0

    def __post_init__(self) -> None:
        require_axis("axis", self.axis)
        require_noise("noise_g", self.noise_g)

    @property
    def kind(self) -> str:
        """Accelerometers: schemes design for them together, apart from gyros."""
        return "accels"

    @property
    def channels(self) -> tuple[Channel, ...]:
        """accel_x, accel_y or accel_z in g."""
        return (Channel(f"accel_{self.axis}", "g", self.noise_g),)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Bias in g, relative scale error, and the misalignments towards the two other axes, in rad."""
        own = "xyz".index(self.axis)
        others = [(own + 1) % 3, (own + 2) % 3]

        def term(name: str, group: str, unit: str, *axes: int) -> Term:
            parameter = Parameter(f"accel_{self.axis}_{name}", f"accel_{group}", unit, scatter=_SCATTER[group])
            return Term(parameter, tuple(("specific_force", axis) for axis in axes))

        return (
            Term(None, (("specific_force", own),)),
            term("bias", "bias", "g"),
            term("scale", "scale", "1", own),
            *(term(f"misalignment_{'xyz'[axis]}", "misalignment", "rad", axis) for axis in others),
        )
