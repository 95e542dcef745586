"""The way from the command line to a job and back: all that the entry points share of Hydra.

A job that fails, and also a command line that Hydra can't compose, ends in one plain message,
a result.json that says the same, and a non-zero exit status.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import sys
import threading
import traceback
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Any

import hydra
from hydra.core.config_store import ConfigStore
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from acalx.commands.composition import placed
from acalx.commands.explain import explain, suggestion
from acalx.commands.former import renewed
from acalx.commands.usual import with_usual
from acalx.errors import AcalxError, ArgumentError
from acalx.recording import RunDirectory
from acalx.reporting.tables import align

__all__ = ["Entry", "SweepReport", "launch", "record_refusal", "suited"]

FAILED, INTERRUPTED = 1, 130
_SWEEP = {"-m", "--multirun"}
_TRACEBACK = re.compile(r"traceback ?= ?(true|1|yes|on)")
Task = Callable[[DictConfig, RunDirectory], int]


@dataclass(frozen=True)
class Entry:
    """What `launch` must know of a command: its name, its configuration, what it does.

    Parameters
    ----------
    name : str
        As in ``python -m acalx.NAME``.
    config_name : str
        Its primary configuration.
    schema : type
        Dataclass of the configuration's root; registered as ``NAME_schema``.
    task : callable
        Takes the configuration and the run's directory, returns the exit status.
    """

    name: str
    config_name: str
    schema: type
    task: Task


class _State:
    """The entry point of this process and the exit statuses of its jobs."""

    config_name = "config"
    groups: Sequence[str] = ()
    traceback = False
    statuses: list[int] = []  # noqa: RUF012 - one process, one command line


def launch(entry: Entry) -> int:
    """Run an entry point with the arguments of the command line; returns the exit status."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # a batch system's limit is an interrupt too
    _State.traceback = False
    if "" not in sys.path and os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())  # a criterion beside the user, with the console script too
    ConfigStore.instance().store(name=f"{entry.name}_schema", node=entry.schema)
    OmegaConf.register_new_resolver("acalx_unique", lambda: uuid.uuid4().hex[:8], use_cache=True, replace=True)
    _State.config_name, _State.statuses = entry.config_name, []
    _State.groups = [field.name for field in fields(entry.schema)]
    given = renewed(sys.argv[1:])
    # jobs of a sweep may have several models
    sys.argv[1:] = given if _SWEEP & set(given) else suited(given)

    @hydra.main(version_base="1.3", config_path="pkg://acalx.conf", config_name=entry.config_name)
    def job(config: DictConfig) -> None:
        settings = HydraConfig.get()
        status = _run_job(entry, config, Path(settings.runtime.output_dir), list(settings.overrides.task))
        _State.statuses.append(status)
        if status == INTERRUPTED and settings.mode == RunMode.MULTIRUN:
            raise KeyboardInterrupt

    try:
        with _errors_come_here():
            job()
    except KeyboardInterrupt:
        print("acalx: interrupted", file=sys.stderr)
        return INTERRUPTED
    except (HydraException, OmegaConfBaseException, TypeError, ValueError, OSError, YAMLError) as error:
        if isinstance(error, OSError) and not isinstance(error, HydraException):
            _say(explain(error), error)  # there is no directory to record it in
            return FAILED
        overrides = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
        directory = _directory_of(overrides)
        try:
            record_refusal(directory, error, overrides)
        except AcalxError as other:
            _say(str(other), other)
            return FAILED
    return max(_State.statuses, default=0)


def suited(arguments: Sequence[str]) -> list[str]:
    """The command line of a job with what suits its model, where it is a job and not a question."""
    if any(argument.startswith("-") and argument not in ("--config-dir", "-cd") for argument in arguments):
        own = [argument for argument in arguments if argument.startswith("-")]
        if not all(argument.startswith("--config-dir=") for argument in own):
            return list(arguments)
    return with_usual(arguments, _State.groups, _State.config_name)


def record_refusal(directory: Path, error: Exception, overrides: Sequence[str]) -> None:
    """Say and record why a command line or a job of a sweep was refused before it began."""
    message = explain(error, overrides, _State.config_name)
    _State.statuses.append(FAILED)
    _say(message, error)
    RunDirectory(directory, overrides).write_result("failed", message)


class SweepReport(Callback):
    """Hydra calls it at the end of a sweep: a line for each job."""

    def on_multirun_end(self, config: DictConfig, **_: Any) -> None:
        """Print the table, from the results that the jobs left."""
        directory = Path(str(config.hydra.sweep.dir))
        found = sorted(directory.glob("*/result.json"), key=lambda path: (len(path.parent.name), path.parent.name))
        rows = [["job", "status", "loss", "seconds", "overrides"]]
        for path in found:
            result = json.loads(path.read_text(encoding="utf-8"))
            loss = result.get("loss")
            rows.append(
                [
                    path.parent.name,
                    result["status"],
                    "-" if loss is None else f"{loss:.6f}",
                    f"{result.get('seconds') or 0.0:.2f}",
                    " ".join(result["overrides"]),
                ]
            )
            if result["status"] == "failed":
                _State.statuses.append(FAILED)
        print(f"\n{align(rows)}\n{len(found)} job{'s' * (len(found) != 1)} in {directory}")


def _run_job(entry: Entry, config: DictConfig, path: Path, overrides: list[str]) -> int:
    """One job; whatever happens is said and recorded."""
    directory = None
    _State.traceback = config.get("traceback") is True
    try:
        directory = RunDirectory(path, overrides)
        _refuse_unknown(config, entry.schema)
        return entry.task(config, directory)
    except KeyboardInterrupt as error:
        there = directory is not None and directory.recorded
        when = "after its figures were recorded" if there else "before there were figures"
        return _failure(directory, "interrupted", f"interrupted {when}", error, INTERRUPTED)
    except AcalxError as error:
        return _failure(directory, "failed", explain(placed(error, config)), error, FAILED)
    except (HydraException, OmegaConfBaseException) as error:
        return _failure(directory, "failed", explain(error, overrides, entry.config_name), error, FAILED)
    except BrokenPipeError:  # whoever read the table has gone; what is recorded stays
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - until the process ends
        return FAILED
    except Exception as error:
        message = f"unexpected {type(error).__name__}: {error}; traceback=true shows where"
        return _failure(directory, "failed", message, error, FAILED)


def _refuse_unknown(config: DictConfig, schema: type) -> None:
    """Raise ArgumentError for a key that ``+key=value`` added and nothing reads."""
    known = [field.name for field in fields(schema)]
    for key in map(str, config):
        if key not in known:
            raise ArgumentError(f"{key}: there is no such option{suggestion(key, known)}")


def _failure(directory: RunDirectory | None, status: str, message: str, error: BaseException, code: int) -> int:
    _say(message, error)
    if directory is not None:
        try:
            directory.write_failure(status, message)
        except OSError as other:  # the directory is gone, or the disk is full
            _say(explain(other), other)
    return code


def _say(message: str, error: BaseException) -> None:
    if _wants_traceback():
        traceback.print_exception(error)
    print(f"acalx: {message}", file=sys.stderr)


def _wants_traceback() -> bool:
    """As the composed configuration says, or the command line where nothing could be composed."""
    return _State.traceback or any(_TRACEBACK.fullmatch(argument.strip().lower()) for argument in sys.argv)


def _directory_of(overrides: Sequence[str]) -> Path:
    """Where to record a command line that could not be composed."""
    given = dict(argument.split("=", 1) for argument in overrides if "=" in argument)
    directory = given.get("hydra.run.dir", "")
    if directory and "$" not in directory:
        return Path(directory)
    return Path("runs") / f"{datetime.now():%Y-%m-%d_%H-%M-%S}_{uuid.uuid4().hex[:8]}"


@contextlib.contextmanager
def _errors_come_here() -> Iterator[None]:
    """Hydra prints errors and exits unless it is told to raise them."""
    before = os.environ.get("HYDRA_FULL_ERROR")
    os.environ["HYDRA_FULL_ERROR"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["HYDRA_FULL_ERROR"]
        else:
            os.environ["HYDRA_FULL_ERROR"] = before
