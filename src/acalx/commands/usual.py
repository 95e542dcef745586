"""What suits a sensor where a command line does not say: other options of groups, from the class that it names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import hydra
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from acalx.commands.composition import moved

__all__ = ["with_usual"]

_NAME = re.compile(r"[\w./-]+")
_FOLDER = ("--config-dir", "-cd")


def with_usual(arguments: Sequence[str], groups: Sequence[str]) -> list[str]:
    """The command line with what suits its model before its own overrides, for groups that it says nothing of.

    Parameters
    ----------
    arguments : sequence of str
        Of one job, without several values of an option.
    groups : sequence of str
        That the entry point has.

    Returns
    -------
    list of str
        As they are where the model says nothing, or can't be told: Hydra explains that.
    """
    said = {argument.lstrip("+~").partition("=")[0]: argument.partition("=")[2] for argument in arguments}
    names = {key.partition(".")[0].partition("@")[0] for key in said}
    usual = _usual(said, _folders(arguments))
    several = "objectives" in names
    left = {"criterion", "optimizer"} if several else set()
    added = [
        f"{option}={choice}"
        for option, choice in usual.items()
        if (group := option.partition(".")[0]) in groups and group not in names | left
    ]
    # Hydra takes overrides that follow one another, and none with a switch between
    before = zip(["", *arguments], arguments, strict=False)
    own = (k for k, (last, each) in enumerate(before) if not each.startswith("-") and last not in _FOLDER)
    first = next(own, len(arguments))
    return [*arguments[:first], *added, *arguments[first:]]


def _usual(said: Mapping[str, str], folders: Sequence[Path]) -> Mapping[str, Any]:
    """What the class of the model says, or that of the sensor in it."""
    name = said.get("model", "scalar_accel")
    if not _NAME.fullmatch(name):
        return {}
    path = next((each for folder in folders if (each := folder / "model" / f"{name}.yaml").is_file()), None)
    if path is None:
        return {}
    try:
        options = OmegaConf.to_container(OmegaConf.load(path), resolve=False)
    except (OmegaConfBaseException, YAMLError, OSError):
        return {}
    options = options if isinstance(options, dict) else {}
    sensor = options.get("sensor") or {}
    inner = said.get("model.sensor._target_", sensor.get("_target_"))
    for target in (inner, said.get("model._target_", options.get("_target_"))):
        found = getattr(_class(target), "usual", None)
        if isinstance(found, Mapping):
            suited = {name: choice for name, choice in found.items() if name != "n"}  # which needs the model itself
            option = f"model.{getattr(_class(target), 'tells_noise', '')}"
            return {**suited, "errors": "usual"} if said.get(option, "null") != "null" else suited
    return {}


def _class(target: object) -> Any:
    """The class that a target names; None where there is none."""
    if not isinstance(target, str) or "." not in target:
        return None
    try:
        return hydra.utils.get_object(moved(target))
    except Exception:  # whatever a module of somebody's raises when it is imported: building the part says it
        return None


def _folders(arguments: Sequence[str]) -> list[Path]:
    """Where options are looked for: folders of the user's own, then the package's."""
    own = []
    for k, argument in enumerate(arguments):
        if argument in _FOLDER and k + 1 < len(arguments):
            own.append(Path(arguments[k + 1]))
        elif argument.startswith("--config-dir="):
            own.append(Path(argument.partition("=")[2]))
    return [*own, Path(str(files("acalx.conf")))]
