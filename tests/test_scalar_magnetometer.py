from __future__ import annotations

import numpy as np
import pytest

from acalx.bounds import certify
from acalx.criteria import D
from acalx.errors import CompatibilityError
from acalx.models import ScalarAccel
from acalx.models.scalar_magnetometer import ScalarMagnetometer
from acalx.optimizers import Gradient
from acalx.problem import Problem
from acalx.quantities.stimulus import Stimulus
from acalx.stands import TwoAxis


def test_it_sees_the_field_as_an_accelerometer_sees_the_vertical() -> None:
    directions = np.random.default_rng(0).standard_normal((20, 3))
    ours = ScalarMagnetometer().regressors(Stimulus(magnetic_field=directions))
    np.testing.assert_allclose(ours, ScalarAccel().regressors(Stimulus(specific_force=directions)), rtol=1e-14)
    assert [parameter.name for parameter in ScalarMagnetometer().parameters] == [
        parameter.name for parameter in ScalarAccel().parameters
    ]


def test_twelve_positions_are_proved_optimal_wherever_the_field_is() -> None:
    problem = Problem(TwoAxis(dip_deg=65, field_azimuth_deg=30), ScalarMagnetometer(), D(), 12)
    best = Gradient().solve(problem, np.random.default_rng(0)).best
    same = Problem(TwoAxis(), ScalarAccel(), D(), 12)
    assert best.loss == pytest.approx(Gradient().solve(same, np.random.default_rng(0)).best.loss, abs=1e-6)
    assert certify(problem, best.settings).optimal


def test_a_field_along_the_first_axis_is_not_seen_whole() -> None:
    stand = TwoAxis(dip_deg=0, field_azimuth_deg=90)
    information = ScalarMagnetometer().information(stand.stimulus(stand.axes.random(np.random.default_rng(0), (50,))))
    assert "bias_x" in " ".join(information.inestimable())


def test_a_table_that_does_not_know_the_field_is_refused_with_the_remedy() -> None:
    with pytest.raises(CompatibilityError, match=r"needs the magnetic field, .* unless .*dip_deg=65"):
        Problem(TwoAxis(), ScalarMagnetometer(), D(), 12)
