"""acalx designs calibration programs for inertial sensors and says how good they are."""

__version__ = "0.1.0"
