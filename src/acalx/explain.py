"""One plain message for each way in which a command line can be wrong."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from importlib.resources.abc import Traversable

from hydra.errors import (
    ConfigCompositionException,
    InstantiationException,
    MissingConfigException,
    OverrideParseException,
)
from omegaconf.errors import MissingMandatoryValue, ValidationError

from acalx.errors import AcalxError

__all__ = ["explain", "suggestion"]

_EXAMPLES = {"criterion._target_": "my_module.MyCriterion"}


def explain(error: BaseException, overrides: Sequence[str] = ()) -> str:
    """What was wrong and what would be right, in one line or two."""
    for cause in _chain(error):
        if isinstance(cause, AcalxError):
            return str(cause)
    if isinstance(error, MissingConfigException) and error.options is not None and error.missing_cfg_file:
        group, _, option = error.missing_cfg_file.rpartition("/")
        given = f"{group}={option}" if group else option
        return f"{given}: there is no such {group or 'configuration'}{suggestion(option, error.options)}"
    if isinstance(error, ConfigCompositionException):
        return _composition(error, overrides)
    if isinstance(error, OverrideParseException):
        return f"can't read the argument {error.override!r}: {_first_line(error)}; it must be of the form key=value"
    if isinstance(error, InstantiationException):
        return _instantiation(error)
    if isinstance(error, MissingMandatoryValue):
        key = str(error.full_key)
        return f"{key} is missing: give {key}={_EXAMPLES.get(key, 'VALUE')}"
    if isinstance(error, OSError):
        return f"can't write to {error.filename}: {error.strerror}; choose another directory by hydra.run.dir=DIRECTORY"
    return _first_line(error)


def suggestion(given: str, known: Iterable[str]) -> str:
    """The known name closest to a given one, and all of them."""
    names = sorted(known)
    close = difflib.get_close_matches(given, names, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]}?" if close else ""
    return f"{hint} (there are: {', '.join(names)})" if names else hint


def _composition(error: ConfigCompositionException, overrides: Sequence[str]) -> str:
    """For an option that does not exist, or a value that an option does not take."""
    text = str(error)
    for cause in _chain(error):
        if isinstance(cause, ValidationError):
            return f"{cause.full_key}: {_first_line(cause)}"
    key = re.search(
        r"Could not (?:override|append to config|delete from config|find) '?([^'\n.]+(?:\.[^'\n]+)?)'", text
    )
    if key is None:
        return _first_line(error)
    path = key.group(1).rstrip(".")
    parent, _, leaf = path.rpartition(".")
    return f"{path}: there is no such option{suggestion(leaf, _keys_of(parent, overrides))}"


def _keys_of(parent: str, overrides: Sequence[str]) -> list[str]:
    """Keys of the root of the configurations, or of the option that is chosen for a group."""
    from importlib import resources

    import yaml

    folder = resources.files("acalx.conf")
    roots = [yaml.safe_load(folder.joinpath(name).read_text()) for name in ("config.yaml", "evaluate.yaml")]
    if not parent:
        keys = {key for root in roots for key in root} - {"defaults"}
        return sorted(keys | {entry.name for entry in folder.iterdir() if _is_group(entry)})
    chosen = dict(entry.popitem() for root in roots for entry in root["defaults"] if isinstance(entry, dict))
    for argument in overrides:
        key, _, value = argument.partition("=")
        chosen[key] = value
    file = folder.joinpath(parent).joinpath(f"{chosen.get(parent, '')}.yaml")
    return sorted(set(yaml.safe_load(file.read_text())) - {"_target_"}) if file.is_file() else []


def _is_group(entry: Traversable) -> bool:
    return entry.is_dir() and entry.name not in ("hydra", "__pycache__")


def _instantiation(error: InstantiationException) -> str:
    text = str(error).replace(", set env var HYDRA_FULL_ERROR=1 to see chained exception.", "")
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    kept = [line for line in lines if not line.startswith(("full_key", "set env var", "See "))]
    causes = [cause for cause in _chain(error) if isinstance(cause, (ImportError, AttributeError))]
    if causes:
        kept = [kept[0], _first_line(causes[0])]
    return ": ".join(dict.fromkeys(line.rstrip(":") for line in kept[:3]))


def _chain(error: BaseException | None) -> Iterable[BaseException]:
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or error.__context__


def _first_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[0].rstrip(".") if lines else type(error).__name__
