"""What no program can beat, and how far from it a program is."""

from acalx.bounds.bound import Bound, bound
from acalx.bounds.certificate import Certificate, certify

__all__ = ["Bound", "Certificate", "bound", "certify"]
