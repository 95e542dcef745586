"""Sweeps that record a job that can't be composed and go on with the others.

Hydra's own refuse the whole sweep for it. Hydra looks for such parts in the namespace package
``hydra_plugins`` only, hence this file's place.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hydra._internal.core_plugins.basic_launcher import BasicLauncher
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.override_parser.types import Override
from hydra.core.utils import JobReturn, JobStatus
from hydra.errors import HydraException
from omegaconf.errors import OmegaConfBaseException

__all__ = ["AcalxLauncher", "AcalxSweeper"]


class AcalxLauncher(BasicLauncher):
    """Runs the jobs of a sweep one after another in this process."""

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> Sequence[JobReturn]:
        """Run each job, or record why it can't be composed."""
        returns: list[JobReturn] = []
        assert self.config is not None
        for number, overrides in enumerate(job_overrides, initial_job_idx):
            try:
                returns += super().launch([overrides], number)
            except (HydraException, OmegaConfBaseException) as error:
                from acalx.commands import launch  # Hydra imports this file for every program of the environment

                directory = Path(str(self.config.hydra.sweep.dir)) / str(number)
                launch.record_refusal(directory, error, list(overrides))
                refused = JobReturn()
                refused.status = JobStatus.COMPLETED  # recorded; raising would end the sweep
                refused.return_value = None
                returns.append(refused)
        return returns


class AcalxSweeper(BasicSweeper):
    """Makes a job of each combination of values."""

    @staticmethod
    def split_arguments(overrides: list[Override], max_batch_size: int | None) -> list[list[list[str]]]:
        """Each combination of values, with what suits its model where it does not say."""
        from acalx.commands import launch  # Hydra imports this file for every program of the environment

        batches = BasicSweeper.split_arguments(overrides, max_batch_size)
        return [[launch.suited(job) for job in batch] for batch in batches]

    def validate_batch_is_legal(self, batch: Sequence[Sequence[str]]) -> None:
        """Leave jobs that can't be composed to a launcher that records them."""
        if not isinstance(self.launcher, AcalxLauncher):
            super().validate_batch_is_legal(batch)
