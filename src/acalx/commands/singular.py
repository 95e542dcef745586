"""Positions that can't show all the parameters: an answer of its own, the same for every entry point."""

from __future__ import annotations

import functools
import sys
import time

from omegaconf import DictConfig

from acalx.commands.explain import explain
from acalx.commands.launch import FAILED, Task
from acalx.errors import SingularError
from acalx.recording import RunDirectory

__all__ = ["answers_singular"]


def answers_singular(task: Task) -> Task:
    """The task of an entry point that records and says what can't be estimated, with the status ``singular``."""

    @functools.wraps(task)
    def answered(config: DictConfig, directory: RunDirectory) -> int:
        started = time.perf_counter()
        try:
            return task(config, directory)
        except SingularError as error:
            message = explain(error)
            seconds = time.perf_counter() - started
            directory.write_result("singular", message, inestimable=error.inestimable, seconds=seconds)
            print(f"acalx: {message}", file=sys.stderr)
            return FAILED

    return answered
