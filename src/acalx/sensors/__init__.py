"""Sensors: what they read, given their errors and what they feel; one file each, imported when used."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
