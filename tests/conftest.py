"""What all tests share."""

from __future__ import annotations

import os

# As the commands do, and before numpy is imported: two workers with two threads each would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from pathlib import PurePath

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling, Scheduling

# Files whose tests look at what a few long commands have left: they stay in one process, which runs these once. All
# others go wherever a process is free.
TOGETHER = {
    "test_calibrate",
    "test_evaluate",
    "test_experiments",
    "test_launch",
    "test_measured_study",
    "test_run",
    "test_simulate",
    "test_validate",
    "test_wang_study",
}


class SharedOut(LoadScopeScheduling):
    """Tests one by one to whichever process is free, but those of some files to the same one.

    A scheduler and no mark: xdist reads its mark xdist_group from a node id that pytest 9.2 no longer lets it write,
    and shares such tests out without a word (pytest-xdist #1386).
    """

    def _split_scope(self, nodeid: str) -> str:
        path, _, _ = nodeid.partition("::")
        return path if PurePath(path).stem in TOGETHER else nodeid


def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> Scheduling:
    """Share tests out as `SharedOut` does, the files that stay together first: none is left to the end."""
    return SharedOut(config, log)
