from .base import Setting as Setting
from .base import Stand as Stand
from .grid import Grid as Grid
from .grid import grid_over as grid_over
from .platform_gimbals import PlatformGimbals as PlatformGimbals
from .rate_table import RateTable as RateTable
from .rotary import Rotary as Rotary
from .two_axis import TwoAxis as TwoAxis
