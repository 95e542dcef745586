"""A forbidden zone as a user would write it, for the tests."""

from __future__ import annotations

import numpy as np


def cap(alpha1_deg: np.ndarray, alpha2_deg: np.ndarray) -> np.ndarray:
    """All directions of the vertical within 35 degrees of one."""
    first, second = np.radians(alpha1_deg), np.radians(alpha2_deg)
    direction = [np.sin(first), np.cos(first) * np.sin(second), np.cos(first) * np.cos(second)]
    return 0.6 * direction[0] + 0.8 * direction[2] > np.cos(np.radians(35))
