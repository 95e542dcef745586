"""How long this checkout takes beside another one, in one run: each case in turn, ratios of medians.

    python benchmarks/beside.py OTHER_PYTHON [CASE ...]

OTHER_PYTHON is the interpreter of an environment in which the other checkout is installed. Each
side works in a process of its own that stays; both do the same case one after the other, so that a busy machine
slows both, and what counts is processor time. Ends with exit status 1 where a ratio is above what is allowed.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

ALLOWED = 1.05
# Cases that take less are done several times, until they have taken so many seconds.
LONG_ENOUGH = 0.4
# Runs of a command on each side; the first does not count.
_RUNS = 21
# Commands are dominated by imports, and their times scatter more than a search does.
COMMANDS = {
    "command run": ["run", "criterion=d", "optimizer=gradient", "n=9", "figures=false"],
    "command run, default": ["run", "figures=false"],
    "command evaluate": ["evaluate", "program=icosahedron_12", "figures=false"],
    "command simulate": ["simulate", "program=icosahedron_12", "trials=20000", "figures=false"],
}
IMPORTS = "import numpy, scipy.optimize, hydra"
# What each worker prepares once, with names that both checkouts have.
PREPARED = """
import sys, time, json
import numpy as np
from acalx import *
from acalx.criteria import A, D, E, Inequality, Product

fair = Product([D(), *map(Inequality, ("bias", "scale", "nonorthogonality"))], [1.0, 0.1, 0.1, 0.1])
full, band, table = TwoAxis(), TwoAxis(alpha2_deg=(-45, 45)), TwoAxis(step_deg=30)


def problem(criterion, n, stand=full, model=None):
    return Problem(stand, model or ScalarAccel(), criterion, n)


def solve(optimizer, asked):
    return lambda k: optimizer.solve(asked, np.random.default_rng(k))


def repeated(function, times):
    def call(k):
        for _ in range(times):
            function()
    return call


nine = problem(D(), 9)
programs = np.random.default_rng(0).uniform(0, 2 * np.pi, (1000, 9, 2))
few = programs[:8]
platform = Problem(PlatformGimbals(), Platform(), D(), 16)
turns = np.random.default_rng(0).uniform(0, 2 * np.pi, (200, 16, 2))
CASES = {
    "loss, 1000 programs": repeated(lambda: nine.loss(programs), 40),
    "loss and gradient, 8 programs": repeated(lambda: nine.loss_and_gradient(few), 300),
    "loss and gradient, 1000 programs": repeated(lambda: nine.loss_and_gradient(programs), 15),
    "loss of the platform": repeated(lambda: platform.loss(turns), 8),
    "gradient d n=9": solve(Gradient(), nine),
    "gradient d n=18": solve(Gradient(), problem(D(), 18)),
    "gradient d_fair n=9": solve(Gradient(), problem(fair, 9)),
    "gradient e n=11": solve(Gradient(starts=24), problem(E(), 11)),
    "gradient d within limits": solve(Gradient(starts=64), problem(D(), 12, band)),
    "de d n=9": solve(DifferentialEvolution(), nine),
    "exchange d 30 degrees": solve(Exchange(starts=30), problem(D(), 10, table)),
    "convex d": solve(Convex(candidates=20000, roundings=8), problem(D(), 12, band)),
    "front d,a": solve(Scalarized(points=20, starts=16), problem(Objectives([D(), A()]), 9)),
    "platform d": solve(Gradient(starts=8), platform),
}
"""
WORKER = (
    PREPARED
    + """
for line in sys.stdin:
    name, k = json.loads(line)
    started = time.process_time()
    CASES[name](k)
    print(time.process_time() - started, flush=True)
"""
)


class Side:
    """One checkout: a process that does cases when told to, and its commands."""

    def __init__(self, python: str) -> None:
        self.python = python
        self.environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)  # as where people work
        self.process = subprocess.Popen(
            [python, "-c", WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=self.environment
        )

    def seconds(self, name: str, k: int) -> float:
        """Of a case."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps([name, k]) + "\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())

    def command(self, arguments: list[str], folder: Path) -> float:
        """Of a whole command."""
        before = getrusage(RUSAGE_CHILDREN)  # to the microsecond, where os.times counts ticks
        entry = ["-m", f"acalx.{arguments[0]}", *arguments[1:]] if arguments[0] != "-c" else arguments
        subprocess.run([self.python, *entry], cwd=folder, check=True, capture_output=True, env=self.environment)
        after = getrusage(RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def paired(ours: list[float], theirs: list[float], name: str, allowed: float = ALLOWED) -> bool:
    """Print a row; whether the ratio is allowed."""
    ratio = median(a / b for a, b in zip(ours, theirs, strict=True))
    good = ratio <= allowed
    print(
        f"{name:36} {median(ours):9.4f} s {median(theirs):9.4f} s {ratio:7.3f} {'' if good else 'SLOWER'}", flush=True
    )
    return good


def main() -> int:
    """Time all the cases, or those that are named."""
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    ours, theirs = Side(sys.executable), Side(str(Path(sys.argv[1]).absolute()))
    named, good = sys.argv[2:], True
    cases = [line.split('"')[1] for line in PREPARED.splitlines() if line.startswith('    "')]
    print(f"{'':36} {'this':>11} {'other':>11} {'ratio':>7}")
    for name in cases:
        if named and name not in named:
            continue
        first, second = [], []
        for k in range(-1, 7):
            tries = [(ours.seconds(name, max(k, 0)), theirs.seconds(name, max(k, 0)))]
            while k >= 0 and sum(a for a, _ in tries) < LONG_ENOUGH:
                tries.append((ours.seconds(name, k), theirs.seconds(name, k)))
            if k >= 0:  # the first time does not count; of several the least is the least disturbed
                first.append(min(a for a, _ in tries))
                second.append(min(b for _, b in tries))
        good &= paired(first, second, name)
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in COMMANDS.items():
            if named and name not in named:
                continue
            both = [
                (ours.command(arguments, Path(folder)), theirs.command(arguments, Path(folder))) for _ in range(_RUNS)
            ]
            good &= paired([a for a, _ in both[1:]], [b for _, b in both[1:]], name)
        if not named or "beside imports" in named:
            for side, label in ((ours, "this command beside its imports"), (theirs, "the other beside its imports")):
                both = [
                    (side.command(COMMANDS["command run"], Path(folder)), side.command(["-c", IMPORTS], Path(folder)))
                    for _ in range(_RUNS)
                ]
                paired([a for a, _ in both[1:]], [b for _, b in both[1:]], label, 1.25)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
