"""Means over a motion have as many samples as they need, and no more."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate

from acalx.errors import ArgumentError
from acalx.stands import Turntable, TwoAxisRateTable
from acalx.stands.motion import MOST_HALF, TOLERANCES


def table_of(half: float) -> TwoAxisRateTable:
    """One that turns by up to twice this angle within a reading."""
    return TwoAxisRateTable(averaging_s=2.0 * half / math.radians(200.0))


def error(places: np.ndarray, weights: np.ndarray, t: float) -> float:
    return float(abs(weights @ np.exp(1j * t * places) - np.sinc(t / np.pi)))


@pytest.mark.parametrize("half", [0.01, 0.17, 1.745, 2.5, 3.1, 5.2, 9.0, 17.45, 30.0, MOST_HALF])
def test_harmonics_of_products_have_their_means_and_fewer_samples_would_not_do(half: float) -> None:
    samples = table_of(half).samples
    count = len(samples)
    for slower in (1.0, 0.9, 0.5, 0.1):
        found = [error(samples.places, samples.weights, q * slower * half) for q in (1, 2, 3)]
        assert all(value <= most for value, most in zip(found, TOLERANCES, strict=True))
    if count > 4:
        places, sizes = np.polynomial.legendre.leggauss(count - 1)
        found = [error(places, sizes / 2.0, q * half) for q in (1, 2, 3)]
        assert any(value > most for value, most in zip(found, TOLERANCES, strict=True))


def test_few_samples_do_by_default() -> None:
    assert len(TwoAxisRateTable().samples) == 6
    assert len(TwoAxisRateTable(averaging_s=0.1).samples) == 4
    assert len(Turntable().samples) == 9
    assert len(table_of(MOST_HALF).samples) == 64


@pytest.mark.parametrize("averaging_s", [1.0, 3.0, 10.0])
def test_a_component_and_its_powers_have_their_means(averaging_s: float) -> None:
    """The vertical component at 100 deg/s about the level axis: cos(0.3 + rate t)."""
    rate = math.radians(100.0)
    stimulus = TwoAxisRateTable(averaging_s=averaging_s).stimulus(np.array([[0.3, 0.4, rate, 0.0]]))
    assert stimulus.weights is not None
    for power, most in enumerate(TOLERANCES, 1):
        half = 0.5 * averaging_s
        expected = integrate.quad(lambda t: math.cos(0.3 + rate * t) ** power, -half, half, epsabs=1e-12, limit=500)[0]  # noqa: B023
        found = stimulus.weights @ stimulus["specific_force"][0, :, 2] ** power
        assert found == pytest.approx(expected / averaging_s, abs=most)


@pytest.mark.parametrize("turns", [1.0, 2.0, 12.0])
def test_means_over_turns_of_a_turntable_are_those_of_the_motion(turns: float) -> None:
    table, most = Turntable(turn_deg=(-360.0 * turns, 360.0 * turns)), math.radians(360.0 * turns)
    for turn in (most, 0.99 * most, -0.4 * most):
        stimulus = table.stimulus(np.array([[turn, 0.5, 1.0]]))
        still = table.stimulus(np.array([[0.0, 0.5, 1.0]]))  # at the beginning, all along
        rate = stimulus["angular_rate"][0] - stimulus["specific_force"][0] * turn / table.turn_s / 7.292115e-5
        assert stimulus.weights is not None
        up, earth = (still[name][0, 0] for name in ("specific_force", "angular_rate"))
        level = earth - (earth @ up) * up
        aside, constant = np.cross(level, up), (earth @ up) * up[0]
        for power, within in enumerate(TOLERANCES, 1):
            expected = integrate.quad(
                lambda x: (constant + math.cos(turn * x) * level[0] + math.sin(turn * x) * aside[0]) ** power,  # noqa: B023
                *(0.0, 1.0),
                epsabs=1e-12,
                limit=500,
            )[0]
            assert stimulus.weights @ rate[:, 0] ** power == pytest.approx(expected, abs=within)


def test_motions_of_too_many_turns_are_refused() -> None:
    with pytest.raises(
        ArgumentError, match=r"^averaging_s=30\.0: .* 6000 degrees, .* over 4320 at most; .* averaging_s=21$"
    ):
        TwoAxisRateTable(averaging_s=30)
    with pytest.raises(ArgumentError, match=r"^averaging_s=3600\.0: "):
        TwoAxisRateTable(averaging_s=3600)
    TwoAxisRateTable(averaging_s=21.6)
    slow = {"outer_rate_deg_s": (-0.5, 0.5), "inner_rate_deg_s": (0, 0.2)}
    assert len(TwoAxisRateTable(averaging_s=3600, **slow).samples) > 20  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"^turn_deg=.*5000.*turn_deg=\[-100\.0, 4320\]$"):
        Turntable(turn_deg=(-100, 5000))
