"""Vector calibration of an accelerometer triad, its orientation known."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

from acalx.models.base import Model
from acalx.models.joined import Composite
from acalx.models.polynomial import Polynomial, Term, require_noise
from acalx.quantities.parameter import Parameter

__all__ = ["VectorAccel"]


@final
@dataclass(frozen=True)
class VectorAccel(Composite):
    """Twelve parameters of an accelerometer triad, from three readings in known orientations.

    With the specific force a in sensor axes, in g, the accelerometer along axis i reads

        W_i = bias_i + (1 + scale_i) a_i + misalignment_ij a_j + misalignment_ik a_k.

    Unlike `ScalarAccel` it needs the attitude of the sensor as well as the readings; in return it
    gives all six misalignments, and four positions are enough.

    Parameters
    ----------
    noise_g : float, g
        Standard deviation of a reading. With 1, the default, standard deviations are in units
        of it.

    Raises
    ------
    ArgumentError
        A noise that is not positive.

    Source: IEEE Std 1293-2018, the static model without terms of higher order.
    """

    noise_g: float = 1.0

    def __post_init__(self) -> None:
        require_noise("noise_g", self.noise_g)

    @cached_property
    def models(self) -> tuple[Model, ...]:
        """The x, y and z accelerometer."""
        return tuple(_Axis(own, self.noise_g) for own in range(3))


@final
@dataclass(frozen=True)
class _Axis(Polynomial):
    own: int
    noise_g: float

    @property
    def kind(self) -> str:
        """Accelerometers: the three axes are designed for together."""
        return "accels"

    @property
    def noise(self) -> float:
        return self.noise_g

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        axis = "xyz"[self.own]
        force = [(("specific_force", k),) for k in range(3)]
        return (
            Term(Parameter(f"bias_{axis}", "bias", "g")),
            Term(Parameter(f"scale_{axis}", "scale", "1"), force[self.own]),
            *(
                Term(Parameter(f"misalignment_{axis}{'xyz'[k]}", "misalignment", "rad"), force[k])
                for k in range(3)
                if k != self.own
            ),
        )
