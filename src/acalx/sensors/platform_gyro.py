"""The gyros of an inertial platform."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.errors import ArgumentError
from acalx.quantities.parameter import Parameter
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_axis, require_noise

__all__ = ["PlatformGyro"]

_PRODUCTS = ("II", "OO", "SS", "IO", "IS", "OS")

# Magnitudes as in simulations of Wang et al. (2016).
_SCATTER = {"bias": 0.05, "first_order": 0.25, "second_order": 0.025, "misalignment": 2.5e-3}


@final
@dataclass(frozen=True)
class PlatformGyro(Polynomial):
    """Eight error coefficients of a single-degree-of-freedom gyro, from its drift at rest.

    With input, output and spin axis I, O and S, the specific force a in g and the Earth's rate
    w in units of itself, the gyro drifts by

        e = bias + I aI + O aO + S aS + q1 + q2 + misalignment_O wO + misalignment_S wS

    in deg/h, where (q1, q2) are two terms of second order, (IS aI aS, SS aS^2) by default. Which
    two a gyro has depends on its make. A misalignment is in deg/h per Earth rate: over 15.041 it
    is in rad, times 13714 in arc seconds.

    Parameters
    ----------
    axis : str
        x, y or z, the platform axis along which the gyro's input axis lies; output and spin
        axis follow it cyclically, (x, y, z), (y, z, x) or (z, x, y).
    second_order : pair of str
        Two of II, OO, SS, IO, IS and OS.
    noise_deg_h : float, deg/h
        Standard deviation of a reading; standard deviations of the coefficients are in units
        of deg/h, g and the Earth's rate then. With 1, the default, they are in units of it.

    Raises
    ------
    ArgumentError
        An unknown axis or term, a noise that is not positive.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588, for the eight
    coefficients; which second-order terms there are is not printed there, hence the option.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="platform_gimbals")
    axis: str = "x"
    second_order: Sequence[str] = ("IS", "SS")
    noise_deg_h: float = 1.0

    def __post_init__(self) -> None:
        require_axis("axis", self.axis)
        require_noise("noise_deg_h", self.noise_deg_h)
        known = ", ".join(_PRODUCTS)
        pair = self.second_order
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2 or pair[0] == pair[1]:
            raise ArgumentError.of("second_order", pair, f"give two different terms out of {known}", ["IS", "SS"])
        for product in pair:
            if product not in _PRODUCTS:
                raise ArgumentError(f"second_order: there is no term {product!r}; the terms are {known}")
        object.__setattr__(self, "second_order", tuple(pair))

    @property
    def kind(self) -> str:
        """Gyros: schemes design for them together, apart from accelerometers."""
        return "gyros"

    @property
    def channels(self) -> tuple[Channel, ...]:
        """gyro_x, gyro_y or gyro_z in deg/h: the drift, what the gyro would read at rest less the Earth's rate."""
        return (Channel(f"gyro_{self.axis}", "deg/h", self.noise_deg_h),)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Bias in deg/h, terms in g and g^2, and the misalignments by which the Earth's rate comes in."""
        first = "xyz".index(self.axis)
        axes = {letter: (first + k) % 3 for k, letter in enumerate("IOS")}

        def term(name: str, group: str, unit: str, quantity: str = "", letters: str = "") -> Term:
            parameter = Parameter(f"gyro_{self.axis}_{name}", f"gyro_{group}", unit, scatter=_SCATTER[group])
            return Term(parameter, tuple((quantity, axes[letter]) for letter in letters))

        return (
            term("bias", "bias", "deg/h"),
            *(term(letter, "first_order", "deg/h/g", "specific_force", letter) for letter in "IOS"),
            *(term(pair, "second_order", "deg/h/g^2", "specific_force", pair) for pair in self.second_order),
            *(term(f"misalignment_{k}", "misalignment", "deg/h/earth_rate", "angular_rate", k) for k in "OS"),
        )
