"""Triads on one board that lie any way are calibrated together without a word of how they lie."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from acalx import Readings, calibrate
from acalx.models.agreement import Agreement
from acalx.models.compared import Compared
from acalx.sensors.accel_array import AccelArray

NOISE_G = 1e-4
UPSIDE_DOWN = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@pytest.mark.parametrize("case", range(8))
def test_a_turned_triad_is_found_where_it_lies(case: int) -> None:
    random = np.random.default_rng(case)
    force = random.normal(size=(24, 3))
    force /= np.linalg.norm(force, axis=1, keepdims=True)
    turned = Rotation.random(rng=random).as_matrix() if case else UPSIDE_DOWN
    upright, other = np.eye(3) + 0.05 * random.normal(size=(2, 3, 3))
    readings = np.concatenate([force @ np.triu(upright).T + 0.02, force @ (other @ turned).T - 0.05], axis=1)
    readings += NOISE_G * random.normal(size=readings.shape)
    found = calibrate(Readings("board", readings), Compared(AccelArray(triads=2, noise_g=NOISE_G), Agreement()))
    assert found.estimate.converged.all()
    assert found.noise == pytest.approx(NOISE_G, rel=0.35)
    across = [k for k, each in enumerate(found.estimate.model.parameters) if each.group == "misalignment"]
    assert np.abs(found.estimate.standard_errors[across]).max() < 3.0 * NOISE_G
