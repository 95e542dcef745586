"""Stands: what turns the sensor."""

from acalx.stands.base import Setting, Stand
from acalx.stands.two_axis import TwoAxis

__all__ = ["Setting", "Stand", "TwoAxis"]
