"""Options that several entry points read in the same way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.errors import ArgumentError

__all__ = ["names_of", "seed_of", "where_of"]


def names_of(config: DictConfig, key: str, length: int | None = None) -> list[str]:
    """Names of columns that the configuration lists."""
    given = OmegaConf.to_container(config, resolve=True)[key]  # type: ignore[index,call-overload]
    if not isinstance(given, Sequence) or isinstance(given, str) or length not in (None, len(given)):
        raise ArgumentError(f"{key}={given}: give {length or 'some'} names of columns, as in {key}=[ax,ay,az]")
    return [str(name) for name in given]


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
