"""One plain message for each way in which a command line can be wrong."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence

from hydra.errors import (
    ConfigCompositionException,
    InstantiationException,
    MissingConfigException,
    OverrideParseException,
)
from omegaconf.errors import MissingMandatoryValue, ValidationError
from yaml import YAMLError

from acalx.errors import AcalxError, Option

__all__ = ["as_override", "chain", "explain", "suggestion"]

_EXAMPLES = {
    **{f"{group}._target_": f"my_module.My{group.title()}" for group in ("criterion", "model", "optimizer", "stand")},
    "unit.per_g": "4096, the counts that are 1 g, or unit.per_g=null to have it found from the readings",
}


def explain(error: BaseException, overrides: Sequence[str] = (), config_name: str = "config") -> str:
    """What was wrong and what would be right, in one line or two.

    Parameters
    ----------
    error : exception
    overrides : sequence of str
        The command line.
    config_name : str
        Primary configuration of the entry point.
    """
    for cause in chain(error):
        if isinstance(cause, AcalxError):
            return cause.said(as_override)
    if isinstance(error, MissingConfigException) and error.options is not None and error.missing_cfg_file:
        group, option = _choice(error.missing_cfg_file, overrides)
        given = f"{group}={option}" if group else option
        return f"{given}: there is no such {group or 'configuration'}{suggestion(option, error.options)}"
    if isinstance(error, ConfigCompositionException):
        return _composition(error, overrides, config_name)
    if isinstance(error, OverrideParseException):
        return f"can't read the argument {error.override!r}: {_first_line(error)}; it must be of the form key=value"
    if isinstance(error, InstantiationException):
        return _instantiation(error)
    if isinstance(error, MissingMandatoryValue):
        key = str(error.full_key)
        if key.partition(".")[0] in ("objectives", "orient"):
            own = "a criterion of your own needs a YAML of its own here, FOLDER/criterion/NAME.yaml"
            return f"{key} is missing: {own}; give its NAME, and --config-dir=FOLDER"
        return f"{key} is missing: give {key}={_EXAMPLES.get(key, 'VALUE')}"
    if str(error).startswith("Config group override must be"):
        empty = [argument for argument in overrides if argument.endswith("=null")]
        return f"{' '.join(empty)}: a group takes the name of one of its options, as in criterion=d"
    if isinstance(error, YAMLError):
        return f"can't read a YAML file: {' '.join(str(error).split())}"
    if isinstance(error, OSError):
        return f"can't write to {error.filename}: {error.strerror}; choose another directory by hydra.run.dir=DIRECTORY"
    return _first_line(error)


def as_override(option: Option) -> str:
    """An option as it is typed on the command line: ``stand.dip_deg=65``, ``'target={bias: 0.5}'``."""
    text = f"{option.key}={_typed(option.value)}"
    return f"'{text}'" if " " in text else text


def _typed(value: object) -> str:
    """A value as YAML has it in an override."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(float(value)).removesuffix(".0")
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_typed(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{','.join(map(_typed, value))}]"
    return str(value)


def suggestion(given: str, known: Iterable[str]) -> str:
    """The known name closest to a given one, and all of them."""
    names = sorted(known)
    close = difflib.get_close_matches(given, names, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]}?" if close else ""
    return f"{hint} (there are: {', '.join(names)})" if names else hint


def _choice(file: str, overrides: Sequence[str]) -> tuple[str, str]:
    """Group and option of a missing file, as they were given."""
    for argument in overrides:
        group, _, option = argument.lstrip("+").partition("=")
        if file == f"{group}/{option}":
            return group, option
    group, _, option = file.rpartition("/")
    return group, option


def _composition(error: ConfigCompositionException, overrides: Sequence[str], config_name: str) -> str:
    """For an option that does not exist, or a value that an option does not take."""
    text = str(error)
    for cause in chain(error):
        if isinstance(cause, ValidationError):
            hint = "; must be true or false" if "valid bool" in str(cause) else ""
            return f"{cause.full_key}: {_first_line(cause)}{hint}"
    if text.startswith("Ambiguous value"):
        return f"{_first_line(error)}: one value is right, or the switch -m for a run with each of them"
    key = re.search(
        r"Could not (?:override|append to config|delete from config|find) '?([^'\n.]+(?:\.[^'\n]+)?)'", text
    )
    if key is None:
        return _first_line(error)
    path = key.group(1).rstrip(".")
    parent, _, leaf = path.rpartition(".")
    keys = _keys_of(parent, overrides, config_name)
    if parent and f"{parent}=custom" in overrides:
        return f"{path}: options of a part of your own are added with a plus, as in +{path}=VALUE"
    if leaf in keys:  # as where a recorded configuration runs again
        return f"{path}: this configuration has its options, not a choice; give one, as in {path}.OPTION=VALUE"
    return f"{path}: there is no such option{suggestion(leaf, keys)}"


def _keys_of(parent: str, overrides: Sequence[str], config_name: str) -> list[str]:
    """Keys of the root of a configuration, or of the option that is chosen for a group."""
    from importlib import resources

    import yaml

    folder = resources.files("acalx.conf")
    file = folder.joinpath(f"{config_name}.yaml")
    root = yaml.safe_load(file.read_text())
    chosen = dict(entry.popitem() for entry in root["defaults"] if isinstance(entry, dict))
    if not parent:
        groups = {key for key in chosen if not key.startswith("override ")}
        return sorted((set(root) - {"defaults"}) | groups)
    for argument in overrides:
        key, _, value = argument.partition("=")
        chosen[key] = value
    file = folder.joinpath(parent).joinpath(f"{chosen.get(parent, '')}.yaml")
    return sorted(set(yaml.safe_load(file.read_text())) - {"_target_"}) if file.is_file() else []


def _instantiation(error: InstantiationException) -> str:
    text = str(error).replace(", set env var HYDRA_FULL_ERROR=1 to see chained exception.", "")
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    kept = [line for line in lines if not line.startswith(("full_key", "set env var", "See "))]
    for cause in chain(error):
        option = re.search(r"unexpected keyword argument '(\w+)'", str(cause))
        target = re.search(r"target '([\w.]+)'", text)
        if option and target and isinstance(cause, TypeError):
            return f"{option.group(1)}: {target.group(1)} has no such option"
    causes = [cause for cause in chain(error) if isinstance(cause, (ImportError, AttributeError))]
    if causes:
        kept = [kept[0], _first_line(causes[-1])]  # the first that went wrong
    return ": ".join(dict.fromkeys(line.rstrip(":") for line in kept[:3]))


def chain(error: BaseException | None) -> Iterable[BaseException]:
    """An error, what caused it, what caused that."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or error.__context__


def _first_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[0].rstrip(".") if lines else type(error).__name__
