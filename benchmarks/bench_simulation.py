"""How fast simulated calibrations are beside a plain loop over trials, in one run."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from acalx.estimation import Iterated, Linear
from acalx.models import ScalarAccel
from acalx.programs import find_program
from acalx.simulation import Campaign, ErrorSources, run_campaign
from acalx.stands import TwoAxis

TRIALS, OF_THE_LOOP = 20000, 300
PROGRAM = "egorov_2021_table_2"
STAND, MODEL, SOURCES = TwoAxis(), ScalarAccel(), ErrorSources()
SETTINGS = find_program(PROGRAM).settings_for(STAND)


def turned(vector, rotation):
    angle = math.sqrt(rotation @ rotation)
    axis = rotation / angle
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * vector + sin * np.cross(axis, vector) + (1 - cos) * (axis @ vector) * axis


def one_trial(rng: np.random.Generator, iterations: int) -> np.ndarray:
    """Error of the estimate of one sensor, the plain way: position by position."""
    true = 1e-4 * rng.standard_normal(9)
    bx, by, bz, sx, sy, sz, xy, xz, zy = true
    matrix = np.array([[1 + sx, xy, xz], [0, 1 + sy, 0], [0, zy, 1 + sz]])
    gravity = 1 + 1e-7 * rng.standard_normal()
    readings = []
    for first, second in SETTINGS:
        vertical = np.array([math.sin(first), math.cos(first) * math.sin(second), math.cos(first) * math.cos(second)])
        felt = gravity * turned(vertical, 1e-4 * rng.standard_normal(3))
        readings.append(np.array([bx, by, bz]) + matrix @ felt + 1e-5 * rng.standard_normal(3))
    estimate = np.zeros(9)
    for _ in range(iterations):
        bx, by, bz, sx, sy, sz, xy, xz, zy = estimate
        inverse = np.linalg.inv(np.array([[1 + sx, xy, xz], [0, 1 + sy, 0], [0, zy, 1 + sz]]))
        rows, residuals = [], []
        for reading in readings:
            x, y, z = eta = inverse @ (reading - np.array([bx, by, bz]))
            length = math.sqrt(eta @ eta)
            wx, wy, wz = eta / length @ inverse
            rows.append([wx, wy, wz, wx * x, wy * y, wz * z, wx * y, wx * z, wz * y])
            residuals.append(length - 1)
        estimate = estimate + np.linalg.lstsq(np.array(rows), np.array(residuals), rcond=None)[0]
    return estimate - true


@pytest.mark.parametrize(("estimator", "iterations"), [(Iterated(), 3), (Linear(), 1)], ids=["iterated", "linear"])
def test_simulation_beside_a_loop_over_trials(comparison, estimator, iterations):
    rng = np.random.default_rng(0)
    scale = TRIALS / OF_THE_LOOP

    def loop(_: int) -> np.ndarray:
        return np.array([one_trial(rng, iterations) for _ in range(OF_THE_LOOP)])

    def ours(_: int):
        return run_campaign(Campaign(MODEL, STAND, SETTINGS, SOURCES, 0), estimator, TRIALS, PROGRAM)

    outcome, plain = ours(0), np.concatenate([loop(0) for _ in range(3)])
    np.testing.assert_allclose(plain.std(axis=0), outcome.deviations, rtol=0.12)
    comparison(ours, loop, rounds=9)
    comparison.theirs[:] = [scale * seconds for seconds in comparison.theirs]
    assert comparison.seconds[0] < 0.5
    assert comparison.faster(100, f"{TRIALS} trials; the loop ran {OF_THE_LOOP} of them")


def test_memory_does_not_grow_with_the_trials(note):
    import tracemalloc

    peaks = []
    for trials in (10_000, 200_000):
        tracemalloc.start()
        run_campaign(Campaign(MODEL, STAND, SETTINGS, SOURCES, 0), Iterated(), trials)
        peaks.append(tracemalloc.get_traced_memory()[1] / 2**20)
        tracemalloc.stop()
    started = time.perf_counter()
    run_campaign(Campaign(MODEL, STAND, SETTINGS, SOURCES, 0), Iterated(), 1_000_000)
    note("peak memory, 200,000 trials against 10,000", "<= 1.1 x", f"{peaks[1] / peaks[0]:.2f} x")
    note("a million trials, n=18, iterated", "", f"{time.perf_counter() - started:.1f} s")
    assert peaks[1] <= 1.1 * peaks[0]
