"""Options of the configuration as the plain objects that functions take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.errors import ArgumentError
from acalx.models import Model
from acalx.options import require_seed
from acalx.programs import published

__all__ = ["channels_of", "names_of", "program_of", "seed_of", "where_of"]


def program_of(config: DictConfig) -> str:
    """Name or path of the program that is to be looked at."""
    if OmegaConf.is_missing(config, "program"):
        raise ArgumentError(f"which program? Give program=FILE.csv or program=NAME; names: {', '.join(published())}")
    return str(config.program)


def names_of(config: DictConfig, key: str, usual: Sequence[str] = ()) -> list[str]:
    """Names that the configuration lists; where there are usual ones as many, and those where it lists none."""
    given = OmegaConf.to_container(config, resolve=True)[key]  # type: ignore[index,call-overload]
    if given is None and usual:
        return list(usual)
    if not isinstance(given, Sequence) or isinstance(given, str) or (usual and len(given) != len(usual)):
        names = ",".join(usual or ("ax", "ay", "az"))
        raise ArgumentError.of(key, given, f"give {len(usual) or 'some'} names of columns, as in {key}=[{names}]")
    return [str(name) for name in given]


def channels_of(config: DictConfig, model: Model) -> list[str]:
    """Names of the columns that hold the readings of a model's channels."""
    return names_of(config, "columns", [channel.name for channel in model.channels])


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
