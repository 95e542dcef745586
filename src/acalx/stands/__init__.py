"""Stands: what turns the sensor."""

from acalx.stands.base import Setting, Stand
from acalx.stands.grid import Grid, grid_over
from acalx.stands.platform_gimbals import PlatformGimbals
from acalx.stands.rate_table import RateTable
from acalx.stands.rotary import Rotary
from acalx.stands.two_axis import TwoAxis

__all__ = ["Grid", "PlatformGimbals", "RateTable", "Rotary", "Setting", "Stand", "TwoAxis", "grid_over"]
