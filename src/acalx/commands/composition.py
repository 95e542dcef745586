"""The configuration of a job: what names stand for, the user's own YAMLs included, and parts made from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import hydra
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import InstantiationException
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from acalx.commands.explain import chain, suggestion
from acalx.commands.former import as_now, target_of
from acalx.criteria import Criterion, Objectives
from acalx.errors import AcalxError, ArgumentError, DataError, Option
from acalx.models import Compared, Model, as_model
from acalx.planning.defaults import suited
from acalx.sensors import Sensor
from acalx.stands import Stand

__all__ = ["RESOLVED", "as_recorded", "build", "build_model", "build_objectives", "composed", "placed", "resolved"]

RESOLVED = "resolved.yaml"
_GROUP = "criterion"


def composed(config: DictConfig, overrides: Sequence[str]) -> DictConfig:
    """The configuration of a design with all that names stand for, and the optimizer that suits where none is named.

    Parameters
    ----------
    config : DictConfig
    overrides : sequence of str
        The command line.

    Raises
    ------
    ArgumentError
        A name that there is not, or that is there twice; a criterion beside the objectives.
    """
    several = config.objectives is not None
    if several:
        config = _compose_objectives(config, overrides)
    usual = suited(several=False, stepped=False)
    name = suited(several=several, stepped=not several and build(config, "stand", Stand).axes.stepped)
    if name != usual:
        config = _compose_default_optimizer(config, overrides, name)
    return _compose_orient(config)


def resolved(config: DictConfig, entry: str) -> str:
    """The configuration of an entry point as it was, which runs again by itself, as YAML."""
    chosen = {"launcher": "acalx", "sweeper": "acalx", "job_logging": "none", "hydra_logging": "none"}
    defaults = [
        f"{entry}_schema",
        "settings",
        *({f"override hydra/{group}": option} for group, option in chosen.items()),
    ]
    head = {"defaults": [*defaults, "_self_"]}
    body = OmegaConf.to_container(config, resolve=True)
    return (
        f"# This run again: python -m acalx.{entry} --config-dir=THIS_DIRECTORY --config-name=resolved\n"
        + OmegaConf.to_yaml(OmegaConf.create(head))
        + OmegaConf.to_yaml(OmegaConf.create(body))
    )


def as_recorded(config: DictConfig, run: str, overrides: Sequence[str]) -> DictConfig:
    """A configuration with the model and the stand of another run, unless the command line names a model.

    Parameters
    ----------
    config : DictConfig
    run : str
        Its directory, or a file there.
    overrides : sequence of str
        The command line.

    Raises
    ------
    DataError
        Where that run left its configuration, and it can't be read.
    """
    named = {override.lstrip("+~").partition("=")[0].partition(".")[0] for override in overrides}
    path = Path(run).expanduser()
    path = (path if path.is_dir() else path.parent) / RESOLVED
    if "model" in named or not path.is_file():
        return config
    try:
        recorded: Any = OmegaConf.load(path)
        parts = OmegaConf.masked_copy(recorded, [group for group in ("model", "stand") if group not in named])
    except (OmegaConfBaseException, YAMLError, OSError, ValueError) as error:
        raise DataError(f"{path}: can't be read; give model=NAME as it was when it was calibrated") from error
    changed = config.copy()
    for group, part in parts.items():
        changed[group] = part
    return changed


def build(config: DictConfig, group: str, *kinds: type) -> Any:
    """Make the part that a group of the configuration describes, and check what it is."""
    if config[group] is None:
        raise ArgumentError(f"there is no {group}: give {group}=NAME")
    try:
        part = hydra.utils.instantiate(as_now(config[group], group), _convert_="all")
    except InstantiationException as error:
        own = next((cause for cause in chain(error) if isinstance(cause, AcalxError)), None)
        if own is None:
            raise
        options = _plain(config[group])
        raise own.placed(lambda option: _placed(option, group, options) or option) from error
    if not isinstance(part, kinds):
        names = [f"{kind.__module__.rsplit('.', 1)[0]}.{kind.__name__}" for kind in kinds]
        raise ArgumentError(
            f"{group}: {config[group].get('_target_')} is not a {' or a '.join(kind.__name__ for kind in kinds)}; "
            f"it must be a class derived from {' or '.join(names)}"
        )
    return part


def build_model(config: DictConfig) -> Model:
    """The model that a configuration describes; of a sensor alone that of its outputs, with what is known before."""
    options = config.model
    if not isinstance(options, DictConfig) or "prior" not in options or not _is_sensor(options.get("_target_")):
        return as_model(build(config, "model", Model, Sensor))
    prior: Any = OmegaConf.to_container(options, resolve=True)["prior"]  # type: ignore[index, call-overload]
    alone = OmegaConf.create({"model": {key: value for key, value in options.items() if key != "prior"}})
    return Compared(build(alone, "model", Sensor), prior=prior)


def _is_sensor(target: object) -> bool:
    found = target_of(target)
    return isinstance(found, type) and issubclass(found, Sensor)


def placed(error: AcalxError, config: DictConfig) -> AcalxError:
    """An error with the options of parts where the configuration has them: ``points`` as ``optimizer.points``.

    Left as they are: options of the command line itself, those of no part, and those of several.
    """

    options = _plain(config)
    groups = [(str(name), part) for name, part in options.items() if isinstance(part, dict)]

    def place(option: Option) -> Option:
        if option.key.partition(".")[0] in options:
            return option
        found = [one for name, part in groups if (one := _placed(option, name, part)) is not None]
        return found[0] if len(found) == 1 else option

    return error.placed(place)


def _plain(config: DictConfig) -> dict[Any, Any]:
    """As it was written: what is missing, or refers to something else, stays so."""
    plain = OmegaConf.to_container(config, resolve=False)
    assert isinstance(plain, dict)
    return plain


def _placed(option: Option, path: str, options: Mapping[Any, Any]) -> Option | None:
    """An option of a part, ``step_deg``, where the part has it, ``stand.step_deg``; None where it has none such."""
    if option.key.partition(".")[0] in options:
        return replace(option, key=f"{path}.{option.key}")
    inner = ((f"{path}.{name!s}", part) for name, part in options.items() if isinstance(part, dict))
    return next((found for name, part in inner if (found := _placed(option, name, part)) is not None), None)


def _compose_objectives(config: DictConfig, overrides: Sequence[str]) -> DictConfig:
    """The configuration with each objective's own in the place of its name, and no criterion.

    Parameters
    ----------
    config : DictConfig
        Its ``objectives`` are names of options of the criterion group, or, as a recorded run
        has them, a mapping from such names to what they stood for.
    overrides : sequence of str
        The command line.

    Raises
    ------
    ArgumentError
        A name that there is not, or that is there twice; a criterion beside the objectives.
    """
    given = config.objectives
    beside = [argument for argument in overrides if argument.lstrip("+~").startswith((f"{_GROUP}=", f"{_GROUP}."))]
    if beside:
        raise ArgumentError(
            f"{beside[0]} beside objectives: with several objectives the criterion plays no part; give one of them"
        )
    if isinstance(given, DictConfig):
        chosen = OmegaConf.to_container(given, resolve=True)
    else:
        names = list(given) if isinstance(given, ListConfig) else [given]
        for k, name in enumerate(names):
            if name in names[:k]:
                raise ArgumentError(f"objectives=[{','.join(map(str, names))}]: {name} is there twice; once is right")
        chosen = {str(name): _compose("objectives", str(name)) for name in names}
    whole = OmegaConf.to_container(config, resolve=True)
    assert isinstance(whole, dict)
    return OmegaConf.create({**whole, "objectives": chosen, _GROUP: None})


def build_objectives(config: DictConfig) -> Objectives:
    """The objectives of a configuration that `composed` gave."""
    names = [str(name) for name in config.objectives]
    return Objectives([build(config.objectives, name, Criterion) for name in names], names)


def _compose_orient(config: DictConfig) -> DictConfig:
    """The configuration with the criterion that ``orient`` names in the place of its name.

    Raises
    ------
    ArgumentError
        A name that there is not.
    """
    if config.orient is None or isinstance(config.orient, DictConfig):
        return config
    whole = OmegaConf.to_container(config, resolve=True)
    assert isinstance(whole, dict)
    return OmegaConf.create({**whole, "orient": _compose("orient", str(config.orient))})


def _compose_default_optimizer(config: DictConfig, overrides: Sequence[str], name: str) -> DictConfig:
    """The configuration with another default optimizer, unless the command line or a recorded run says which."""
    said = any(argument.lstrip("+~").startswith(("optimizer=", "optimizer.")) for argument in overrides)
    if said or "optimizer" not in HydraConfig.get().runtime.choices:
        return config
    whole = OmegaConf.to_container(config, resolve=True)
    assert isinstance(whole, dict)
    suited = OmegaConf.to_container(hydra.compose(f"optimizer/{name}")["optimizer"], resolve=True)
    return OmegaConf.create({**whole, "optimizer": suited})


def _compose(option: str, name: str) -> Any:
    """What an option of the criterion group stands for, on Hydra's search path."""
    known = GlobalHydra.instance().config_loader().get_group_options(_GROUP)
    if name not in known:
        raise ArgumentError(f"{option}: there is no criterion {name}{suggestion(name, known)}")
    return OmegaConf.to_container(hydra.compose(f"{_GROUP}/{name}")[_GROUP], resolve=True)
