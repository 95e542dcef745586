"""What all tests share."""

from __future__ import annotations

import os

# As the commands do, and before numpy is imported: two workers with two threads each would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

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


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep tests together that share what takes long, and begin with them: none is left to one process at the end."""
    for item in items:
        if item.path.stem in TOGETHER:
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
    items.sort(key=lambda item: item.path.stem not in TOGETHER)
