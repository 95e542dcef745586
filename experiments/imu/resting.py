"""Gyros that do not turn: what static positions show of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.quantities.parameter import Parameter
from acalx.sensors import Channel, Polynomial, Term
from acalx.sensors.base import suits

__all__ = ["RestingGyros"]


@final
@dataclass(frozen=True)
class RestingGyros(Polynomial):
    """Three gyros at rest: W = bias + g_sensitivity a + drift t, in deg/s, with the specific force a in g.

    The time t since the middle of the session, in sessions, stands where acalx has a temperature: that was not
    recorded, and a sensor that was switched on warms up with time. The Earth's rate is left in the noise.

    Parameters
    ----------
    drift : bool
        Whether the bias drifts.
    """

    usual: ClassVar[Mapping[str, Any]] = suits()
    drift: bool = False

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """gx, gy, gz in deg/s, in units of whose noise standard deviations come."""
        return tuple(Channel(f"g{axis}", "deg/s", 1.0) for axis in "xyz")

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Of each gyro; what one without errors reads is zero."""
        return tuple(term for channel, own in enumerate("xyz") for term in self._of(own, channel))

    def _of(self, own: str, channel: int) -> list[Term]:
        found = [Term(Parameter(f"bias_{own}", "bias", "deg/s", scatter=0.5), (), 1.0, channel)]
        for axis in "xyz":
            one = Parameter(f"g_sensitivity_{own}{axis}", "g_sensitivity", "deg/s/g", scatter=0.05)
            found.append(Term(one, f"f{axis}", 1.0, channel))
        if self.drift:
            found.append(Term(Parameter(f"drift_{own}", "drift", "deg/s", scatter=0.1), "t", 1.0, channel))
        return found
