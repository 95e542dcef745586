"""How right a calibration is on positions that it has not seen."""
