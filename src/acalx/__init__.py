"""acalx designs calibration programs for inertial sensors and says how good they are.

Its public names are listed in ``__init__.pyi``, the one place, with the rooms that they are in; each is imported
when it is first used, so that ``import acalx`` costs nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

__version__ = "0.1.0"
