"""How a program for a model of several kinds of sensors is put together."""

from acalx.schemes.base import Composed, Part, Scheme
from acalx.schemes.joint import Joint
from acalx.schemes.parallel import Parallel
from acalx.schemes.serial import Serial

__all__ = ["Composed", "Joint", "Parallel", "Part", "Scheme", "Serial"]
