"""Options that several entry points read in the same way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.criteria import Criterion, Objectives, Target
from acalx.errors import ArgumentError

__all__ = ["names_of", "seed_of", "target_of", "where_of"]


def names_of(config: DictConfig, key: str, length: int | None = None) -> list[str]:
    """Names of columns that the configuration lists."""
    given = OmegaConf.to_container(config, resolve=True)[key]  # type: ignore[index,call-overload]
    if not isinstance(given, Sequence) or isinstance(given, str) or length not in (None, len(given)):
        raise ArgumentError(f"{key}={given}: give {length or 'some'} names of columns, as in {key}=[ax,ay,az]")
    return [str(name) for name in given]


def target_of(config: DictConfig, criterion: Criterion | Objectives) -> Target | None:
    """What n=auto is to reach; None where n is given."""
    if config.n != "auto":
        if config.target is not None and not _has_target(criterion):
            raise ArgumentError(f"target={config.target} with n={config.n}: a target is for n=auto or criterion=target")
        return None
    if isinstance(criterion, Objectives):
        raise ArgumentError("n=auto: several objectives have no smallest number of positions; give one criterion, or n")
    if config.target is None:
        raise ArgumentError(
            "n=auto: give the largest standard error of each group that matters, as in 'target={bias: 0.5}'"
        )
    whole: Any = OmegaConf.to_container(config, resolve=True)
    return Target(whole["target"])


def where_of(config: DictConfig) -> dict[str, Any]:
    """Values that columns must have."""
    where = config.where
    if where is None:
        return {}
    if not isinstance(where, Mapping):
        raise ArgumentError(f"where={where}: give columns and their values, as in 'where={{imu: 3}}'")
    return {str(name): value for name, value in where.items()}


def seed_of(config: DictConfig) -> int:
    """The seed, or ArgumentError."""
    seed = config.seed
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise ArgumentError(f"seed={seed}: the seed must be a whole number, 0 or more")
    return seed


def _has_target(criterion: Criterion | Objectives) -> bool:
    each = criterion.criteria if isinstance(criterion, Objectives) else (criterion,)
    return any(isinstance(ceiling, Target) for one in each for _, ceiling in one.terms().ceilings)
