"""How fast acalx is beside the plain ways of doing the same, in one run.

What is compared runs in turn, so that a busy machine slows both; medians are compared.
scipy's differential evolution takes so long that it runs once, in the middle of our rounds.
"""

from __future__ import annotations

import math
import subprocess
import sys
import time

import numpy as np
import pytest
from scipy.optimize import differential_evolution, minimize

from acalx.criteria import D
from acalx.models import ScalarAccel
from acalx.optimizers import DifferentialEvolution, Gradient
from acalx.problem import Problem
from acalx.stands import TwoAxis

# the best known D, of 9 positions by Womersley and Sloan; of 18 the bound, which is reached
BEST = {9: 0.04893152, 18: 7.752269e-5}
WITHIN = 1e-6
# figures that are printed with seven digits
LIMIT = {9: 0.04893153, 18: 7.752269e-5 * (1 + WITHIN)}
SIZES = pytest.mark.parametrize("n", [9, 18])


def regressors(angles: np.ndarray) -> np.ndarray:
    """H of programs (..., n, 2), the plain way."""
    first, second = angles[..., 0], angles[..., 1]
    x, y, z = np.sin(first), np.cos(first) * np.sin(second), np.cos(first) * np.cos(second)
    return np.stack([x, y, z, x * x, y * y, z * z, x * y, x * z, z * y], axis=-1)


def plain_loss(vector: np.ndarray) -> float:
    """Log D of one program, the plain way."""
    rows = regressors(vector.reshape(-1, 2))
    return -np.linalg.slogdet(rows.T @ rows)[1]


def problem(n: int) -> Problem:
    return Problem(TwoAxis(), ScalarAccel(), D(), n)


@pytest.fixture(scope="module")
def scipy_de():
    """Seconds and D of scipy's differential evolution with default options; it runs once for each n."""
    kept: dict[int, tuple[float, float]] = {}

    def once(n: int) -> tuple[float, float]:
        if n not in kept:
            started = time.perf_counter()
            result = differential_evolution(plain_loss, [(0.0, 2.0 * math.pi)] * (2 * n), rng=0)
            kept[n] = time.perf_counter() - started, math.exp(result.fun)
        return kept[n]

    return once


def solve(optimizer, n: int, seed: int) -> None:
    """The whole search with default options; it must end within 1e-6 of the best."""
    result = optimizer.solve(problem(n), np.random.default_rng(seed))
    assert math.exp(result.best.loss) <= LIMIT[n]


def faster_than_scipy_de(comparison, scipy_de, optimizer, n: int, times: float) -> bool:
    rounds = 10
    solve(optimizer, n, rounds)  # imports

    def in_the_middle(seed: int) -> None:
        if seed == rounds // 2:
            scipy_de(n)

    comparison(lambda seed: solve(optimizer, n, seed), in_the_middle, rounds)
    seconds, reached = scipy_de(n)
    comparison.theirs[:] = [seconds]
    return comparison.faster(times, f"scipy ended {max(0.0, reached / BEST[n] - 1):.0e} above the best D")


@SIZES
def test_gradient_beside_scipy_de(comparison, scipy_de, n):
    assert faster_than_scipy_de(comparison, scipy_de, Gradient(), n, 300)


@SIZES
def test_de_beside_scipy_de(comparison, scipy_de, n):
    assert faster_than_scipy_de(comparison, scipy_de, DifferentialEvolution(), n, 20)


@SIZES
def test_gradient_beside_ten_starts_of_scipy_lbfgsb(comparison, n):
    reached = []

    def ten_starts(seed: int) -> None:
        starts = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, (10, 2 * n))
        reached.append(math.exp(min(minimize(plain_loss, start, method="L-BFGS-B").fun for start in starts)))

    comparison(lambda seed: solve(Gradient(), n, seed), ten_starts, rounds=9)
    assert comparison.faster(3, f"scipy ended {max(0.0, np.median(reached) / BEST[n] - 1):.0e} above the best D")


def test_batched_loss_beside_slogdet_at_9_positions(comparison):
    bound = problem(9)
    programs = bound.restrictions.random(np.random.default_rng(0), 1000)
    calls = range(20)  # in a row, as an optimizer makes them

    def plain(_: int) -> np.ndarray:
        for _ in calls:
            rows = regressors(programs)
            losses = -np.linalg.slogdet(rows.swapaxes(-1, -2) @ rows)[1]
        return losses

    def ours(_: int) -> np.ndarray:
        for _ in calls:
            losses = bound.loss(programs)
        return losses

    np.testing.assert_allclose(ours(0), plain(0), rtol=1e-6)
    comparison(ours, plain, rounds=40)
    assert comparison.faster(1.5, f"{len(calls)} calls with 1000 programs each")


def test_whole_command_beside_its_imports(comparison, tmp_path):
    job = [sys.executable, "-m", "acalx.run", "criterion=d", "optimizer=gradient", "n=9", "figures=false"]
    imports = [sys.executable, "-c", "import numpy, scipy.optimize, hydra"]

    def command(arguments):
        return lambda _: subprocess.run(arguments, cwd=tmp_path, check=True, capture_output=True)

    ours, theirs = command(job), command(imports)
    ours(0), theirs(0)  # files come from the disk the first time
    comparison(ours, theirs, rounds=15)
    assert comparison.at_most(1.25)


@pytest.mark.parametrize("criterion", ["d", "d_fair"])
def test_memory_of_a_thousand_positions(benchmark, note, tmp_path, criterion):
    code = (
        "import sys; from acalx.commands.run import main; status = main();"
        # not ru_maxrss, which begins with that of the process that started this one
        "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')));"
        "sys.exit(status)"
    )
    job = [sys.executable, "-c", code, f"criterion={criterion}", "optimizer=gradient", "n=1000", "figures=false"]
    outcome = benchmark.pedantic(
        lambda: subprocess.run(job, cwd=tmp_path, check=True, capture_output=True, text=True), rounds=1
    )
    peak = int(outcome.stdout.splitlines()[-1]) / 2**20
    note(f"peak memory, n=1000, criterion={criterion}, optimizer=gradient", "< 1 GB", f"{peak:.2f} GB")
    assert peak < 1.0
