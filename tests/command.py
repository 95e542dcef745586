"""Real commands, started as a user starts them, and what they leave."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from forks import run_forked

SCRIPT = str(Path(sys.executable).parent / "acalx")
# without what keeps Python from keeping what it compiled: hundreds of commands would each compile anew
ENVIRONMENT = {
    key: value
    for key, value in os.environ.items()
    if not key.startswith(("HYDRA_", "COMP_", "PYTEST_")) and key != "PYTHONDONTWRITEBYTECODE"
}
SECONDS = 180
PROGRESS = re.compile(r"\d+ s: best loss ")
_T = TypeVar("_T")


@dataclass(frozen=True)
class Outcome:
    """A command that has ended, and the directory of its run."""

    status: int
    out: str
    err: str
    directory: Path

    @property
    def complaints(self) -> str:
        """What was printed beside the answer, without the lines of progress that a slow machine gets."""
        return "".join(line for line in self.err.splitlines(keepends=True) if not PROGRESS.match(line))

    @cached_property
    def result(self) -> dict[str, Any]:
        return json.loads((self.directory / "result.json").read_text(encoding="utf-8"))

    @property
    def metrics(self) -> dict[str, Any]:
        return self.result["metrics"]

    def text(self, name: str = "program.csv") -> str:
        return (self.directory / name).read_text(encoding="utf-8")

    def rows(self, name: str = "program.csv") -> list[dict[str, str]]:
        return list(csv.DictReader(self.text(name).splitlines()))

    @property
    def files(self) -> set[str]:
        return {path.name for path in self.directory.iterdir()}


def start(folder: Path, *command: str, **environment: str) -> subprocess.Popen[str]:
    """Start exactly this command in a folder, without an interpreter's own path where it is `python`."""
    program = [sys.executable, *command[1:]] if command[0] == "python" else list(command)
    return subprocess.Popen(
        program,
        cwd=folder,
        env=ENVIRONMENT | environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
    )


def finish(process: subprocess.Popen[str], directory: Path) -> Outcome:
    out, err = process.communicate(timeout=SECONDS)
    return Outcome(process.returncode, out, err, directory)


def execute(folder: Path, *command: str, **environment: str) -> Outcome:
    """Run exactly this command."""
    return finish(start(folder, *command, **environment), folder)


def run(folder: Path, *arguments: str, into: str = "run", entry: str = "run") -> Outcome:
    """``python -m acalx.run ARGUMENTS`` with a directory of that name in the folder."""
    status, out, err = run_forked(f"acalx.{entry}", [*arguments, f"hydra.run.dir={into}"], folder, ENVIRONMENT)
    return Outcome(status, out, err, folder / into)


def evaluate(folder: Path, *arguments: str, into: str = "evaluation") -> Outcome:
    """The same with ``acalx.evaluate``."""
    return run(folder, *arguments, into=into, entry="evaluate")


def together(calls: Iterable[Callable[[], _T]]) -> list[_T]:
    """Results of several calls that mostly wait for a command, two at a time."""
    with ThreadPoolExecutor(2) as pool:
        return [future.result() for future in [pool.submit(call) for call in calls]]


def assert_refused(outcome: Outcome, *phrases: str) -> None:
    """The command failed with one plain message that holds the phrases, and recorded it."""
    assert outcome.status == 1
    assert "Traceback" not in outcome.err
    assert outcome.err.startswith("acalx: ")
    assert outcome.err.count("\n") == 1
    for phrase in phrases:
        assert phrase in outcome.err
    assert outcome.result["status"] == "failed"
    assert f"acalx: {outcome.result['message']}\n" == outcome.err
    assert outcome.result["metrics"] is None
    assert outcome.out == ""
