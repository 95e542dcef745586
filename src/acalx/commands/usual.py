"""What suits a model where a command line does not say: choices of other groups, and options of these."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import hydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from acalx.commands.former import as_now, target_of
from acalx.models import Model, as_model
from acalx.sensors import Sensor
from acalx.stands import Stand

__all__ = ["with_usual"]

_NAME = re.compile(r"[\w./-]+")
# The model in the defaults of a primary configuration.
_MODEL = re.compile(r"^\s*- model: *([\w./-]+)", re.MULTILINE)
_FOLDER = ("--config-dir", "-cd")


def with_usual(arguments: Sequence[str], groups: Sequence[str], config_name: str) -> list[str]:
    """The command line with what suits its model before its own overrides, where it says nothing else.

    The choice of a group is added unless the group itself is named, `stand=...`; an option of it leaves the choice
    as it is. A single option is added where the usual choice of its group stands, and the option is not named.

    Parameters
    ----------
    arguments : sequence of str
        Of one job, without several values of an option.
    groups : sequence of str
        That the entry point has.
    config_name : str
        The primary configuration, which says the model where the command line does not.

    Returns
    -------
    list of str
        As they are where the model says nothing, or can't be told: Hydra explains that.
    """
    said = {argument.lstrip("+~").partition("=")[0]: argument.partition("=")[2] for argument in arguments}
    chosen = {key.partition("@")[0] for key in said if "." not in key}
    if "objectives" in chosen:
        chosen |= {"criterion", "optimizer"}
    # groups whose class is another one, with other options
    replaced = {key.removesuffix("._target_") for key in said if key.endswith("._target_")}
    usual = _usual(said, arguments, config_name)
    if "optimizer" in usual and "optimizer" not in chosen and "optimizer" in groups:
        stand = said.get("stand") or str(usual.get("stand", ""))
        if _stops_at_steps(stand, arguments):  # there the default suits
            usual = {option: choice for option, choice in usual.items() if option.partition(".")[0] != "optimizer"}
    added = [
        f"{option}={choice}"
        for option, choice in usual.items()
        if (group := option.partition(".")[0]) in groups
        and group not in chosen
        and option not in said
        and (option == group or group not in replaced)
    ]
    # Hydra takes overrides that follow one another, and none with a switch between
    before = zip(["", *arguments], arguments, strict=False)
    own = (k for k, (last, each) in enumerate(before) if not each.startswith("-") and last not in _FOLDER)
    first = next(own, len(arguments))
    return [*arguments[:first], *added, *arguments[first:]]


def _usual(said: Mapping[str, str], arguments: Sequence[str], config_name: str) -> Mapping[str, Any]:
    """What the model says: its class where that is known without making one, the model itself otherwise."""
    folders = _folders(arguments)
    options = _options(folders, "model", said.get("model") or _default(folders, config_name))
    if options is None:
        return {}
    target = said.get("model._target_") or _plain(options).get("_target_")
    model = target_of(target)
    found = getattr(model, "usual", None)
    if isinstance(found, property):
        made = _made(options, "model", arguments)
        found = as_model(made).usual if isinstance(made, Model | Sensor) else None
    if not isinstance(found, Mapping):
        return {}
    suited = {option: choice for option, choice in found.items() if option != "n"}  # which needs the whole model
    noise = said.get(f"model.{getattr(model, 'tells_noise', '')}", "null")
    return suited if noise == "null" else {**suited, "errors": "usual"}


def _stops_at_steps(stand: str, arguments: Sequence[str]) -> bool:
    options = _options(_folders(arguments), "stand", stand)
    made = None if options is None else _made(options, "stand", arguments)
    return isinstance(made, Stand) and made.axes.stepped


def _options(folders: Sequence[Path], group: str, name: str) -> DictConfig | None:
    """The YAML of an option; None where there is none that can be read."""
    path = _found(folders, f"{group}/{name}.yaml") if _NAME.fullmatch(name) else None
    try:
        options = None if path is None else OmegaConf.load(path)
    except (OmegaConfBaseException, YAMLError, OSError):
        return None
    return options if isinstance(options, DictConfig) else None


def _made(options: DictConfig, group: str, arguments: Sequence[str]) -> object:
    """A part with its options from the command line; None where it can't be made."""
    own = [each for each in arguments if each.lstrip("+~").startswith(f"{group}.")]
    try:
        for override in OverridesParser.create().parse_overrides(own):
            key = override.key_or_group.partition(".")[2]
            if not override.is_delete():
                OmegaConf.update(options, key, override.value(), merge=False, force_add=True)
        return hydra.utils.instantiate(as_now(options, group), _convert_="all")
    except Exception:  # whatever a part of somebody's raises when it is made: building it again says it
        return None


def _plain(options: DictConfig) -> dict[Any, Any]:
    plain = OmegaConf.to_container(options, resolve=False)
    assert isinstance(plain, dict)
    return plain


def _default(folders: Sequence[Path], config_name: str) -> str:
    """The model of the primary configuration."""
    path = _found(folders, f"{config_name}.yaml")
    found = None if path is None else _MODEL.search(path.read_text(encoding="utf-8"))
    return found[1] if found else ""


def _found(folders: Sequence[Path], name: str) -> Path | None:
    return next((path for folder in folders if (path := folder / name).is_file()), None)


def _folders(arguments: Sequence[str]) -> list[Path]:
    """Where options are looked for: folders of the user's own, then the package's."""
    own = []
    for k, argument in enumerate(arguments):
        if argument in _FOLDER and k + 1 < len(arguments):
            own.append(Path(arguments[k + 1]))
        elif argument.startswith("--config-dir="):
            own.append(Path(argument.partition("=")[2]))
    return [*own, Path(str(files("acalx.conf")))]
