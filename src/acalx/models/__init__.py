"""Measurement models: how a sensor's error parameters show in its readings; one file each, imported when used."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
