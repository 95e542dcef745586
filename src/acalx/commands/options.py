"""Options of the configuration as the plain objects that functions take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.errors import ArgumentError
from acalx.options import require_seed
from acalx.programs import published

__all__ = ["names_of", "program_of", "seed_of", "where_of"]


def program_of(config: DictConfig) -> str:
    """Name or path of the program that is to be looked at."""
    if OmegaConf.is_missing(config, "program"):
        raise ArgumentError(f"which program? Give program=FILE.csv or program=NAME; names: {', '.join(published())}")
    return str(config.program)


def names_of(config: DictConfig, key: str, length: int | None = None) -> list[str]:
    """Names of columns that the configuration lists."""
    given = OmegaConf.to_container(config, resolve=True)[key]  # type: ignore[index,call-overload]
    if not isinstance(given, Sequence) or isinstance(given, str) or length not in (None, len(given)):
        raise ArgumentError.of(key, given, f"give {length or 'some'} names of columns, as in {key}=[ax,ay,az]")
    return [str(name) for name in given]


def where_of(config: DictConfig) -> dict[str, Any]:
    """Values that columns of the data must have for a row to be read, by the names of the columns."""
    where = config.where
    if where is None:
        return {}
    if not isinstance(where, Mapping):
        raise ArgumentError.of("where", where, "give columns and their values, as in 'where={imu: 3}'")
    return {str(name): value for name, value in where.items()}


def seed_of(config: DictConfig) -> int:
    """The seed of the random generator; ArgumentError unless it is a whole number, 0 or more."""
    require_seed(config.seed)
    return int(config.seed)
