"""The parts that the configuration offers: a new YAML is enough to be in every list made from it."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import hydra
from omegaconf import OmegaConf

from acalx.commands.composition import build_model

CONF = Path(str(files("acalx.conf")))
# What takes long by default, made small: options of the same parts.
SMALL: dict[str, dict[str, Any]] = {
    "optimizer/convex": {"candidates": 400, "roundings": 6},
    "optimizer/de": {"restarts": 1, "agree": 1, "popsize": 2, "maxiter": 40, "companions": 4},
    "optimizer/exchange": {"starts": 6, "chains": 1, "agree": 1, "elite": 4, "patience": 4, "candidates": 200},
    "optimizer/gradient": {"starts": 16},
    "optimizer/nsga2": {"population": 16, "generations": 12, "points": 6},
    "optimizer/scalarized": {"points": 6, "seeds": 2, "starts": 16},
    "criterion/target": {"standard_errors": {"bias": 0.6}},
    "model/accel_array": {"sensor": {"triads": 2}},
    "unit/counts": {"per_g": 4096.0},
}


def names(group: str) -> list[str]:
    """Options of a group but the one for a part of the user's own."""
    return sorted(path.stem for path in CONF.glob(f"{group}/*.yaml") if path.stem != "custom")


def part(group: str, name: str, **options: Any) -> Any:
    """The part that an option stands for, small where it has a size."""
    config = OmegaConf.load(CONF / group / f"{name}.yaml")
    config = OmegaConf.merge(config, SMALL.get(f"{group}/{name}", {}), options)
    if group == "model":
        return build_model(OmegaConf.create({group: config}))
    return hydra.utils.instantiate(config, _convert_="all")


def parts_of(group: str) -> dict[str, Any]:
    """All the options of a group by name."""
    return {name: part(group, name) for name in names(group)}
