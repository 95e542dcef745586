"""Stands: what turns the sensor."""

from acalx.stands.base import Setting, Stand
from acalx.stands.platform_gimbals import PlatformGimbals
from acalx.stands.rate_table import RateTable
from acalx.stands.two_axis import TwoAxis

__all__ = ["PlatformGimbals", "RateTable", "Setting", "Stand", "TwoAxis"]
