"""How long the search for a program of an inertial measurement unit takes, beside ten starts of scipy's L-BFGS-B.

Both in processor time, in a process of its own with as many threads as people have who set nothing.
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from acalx.criteria import D
from acalx.models import as_model
from acalx.optimizers import Gradient
from acalx.problem import Problem
from acalx.sensors import IMU
from acalx.stands import TwoAxisRateTable

# 5 s of processor time on a machine where those ten starts take 0.7 s
MOST = 5.0 / 0.7
ROUNDS = 5


def plain_loss(vector: np.ndarray) -> float:
    """Log D of one program of an accelerometer triad, the plain way."""
    first, second = vector.reshape(-1, 2).T
    x, y, z = np.sin(first), np.cos(first) * np.sin(second), np.cos(first) * np.cos(second)
    rows = np.stack([x, y, z, x * x, y * y, z * z, x * y, x * z, z * y], axis=-1)
    return -np.linalg.slogdet(rows.T @ rows)[1]


def ten_starts(seed: int) -> None:
    for start in np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, (10, 2 * 18)):
        minimize(plain_loss, start, method="L-BFGS-B")


def seconds(function: Callable[[int], object], seed: int) -> float:
    started = time.process_time()
    function(seed)
    return time.process_time() - started


def measured(n: int) -> tuple[float, float]:
    """Processor seconds of a search with the options that suit the sensor, and of the ten starts, medians."""
    sensor = IMU()
    problem = Problem(TwoAxisRateTable(), as_model(sensor), D(), n)
    optimizer = Gradient(starts=sensor.usual["optimizer.starts"])

    def search(seed: int) -> None:
        optimizer.solve(problem, np.random.default_rng(seed))

    search(ROUNDS)  # imports
    times = [(seconds(search, seed), seconds(ten_starts, seed)) for seed in range(ROUNDS)]
    ours, theirs = zip(*times, strict=True)
    return statistics.median(ours), statistics.median(theirs)


@pytest.mark.parametrize("n", [20, 24, 30, 40])
def test_imu_by_gradient(note, n):
    settings = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    command = [sys.executable, __file__, str(n)]
    printed = subprocess.run(command, env=settings, check=True, capture_output=True, text=True).stdout
    ours, theirs = map(float, printed.split())
    note(f"imu by gradient, n={n}, in times of ten starts", f"<= {MOST:.1f} x", f"{ours / theirs:.1f} x, {ours:.2f} s")
    assert ours <= MOST * theirs


if __name__ == "__main__":
    print(*measured(int(sys.argv[1])))
