"""Words that something had before: command lines, YAML files and recorded runs that have them still run."""

from __future__ import annotations

import pkgutil
import re
import sys
from collections.abc import Sequence
from typing import Any

from omegaconf import DictConfig, OmegaConf

__all__ = ["as_now", "renewed", "target_of"]

# Parts by the names that they had.
_MOVED = {
    "acalx.Oriented": "acalx.models.Projection",
    "acalx.criteria.fair.Inequality": "acalx.criteria.Inequality",
    **{
        f"acalx.estimation.{room}{old}": f"acalx.models.{new}"
        for room in ("", "residuals.")
        for old, new in (("Magnitude", "Magnitude"), ("Oriented", "Projection"), ("Outputs", "Outputs"))
    },
    **{
        f"acalx.models.{room}{name}": f"acalx.sensors.{name}"
        for module, name in (("platform_gyro.", "PlatformGyro"), ("platform_accel.", "PlatformAccel"))
        for room in ("", module)
    },
}
# Options of groups by the names that they had.
_RENAMED = {"estimator": {"residual": "comparison"}}
_WORDS = re.compile("|".join(rf"(?<![\w.]){re.escape(old)}(?![\w.])" for old in _MOVED))

_said: set[str] = set()


def target_of(target: object) -> Any:
    """What a target names, by the name that it has or had; None where there is nothing: building the part says it."""
    if not isinstance(target, str) or "." not in target:
        return None
    try:
        return pkgutil.resolve_name(_MOVED.get(target, target))
    except Exception:  # whatever a module of somebody's raises when it is imported
        return None


def renewed(arguments: Sequence[str]) -> list[str]:
    """A command line with the words of now, which are said once where it has others."""
    return [_WORDS.sub(lambda found: _now(found[0], _MOVED[found[0]]), _option(each)) for each in arguments]


def as_now(config: DictConfig, group: str) -> Any:
    """A part's options with the words of now; as they are where they have no others."""
    plain = OmegaConf.to_container(config, resolve=False)
    if _renewed(plain, group, say=False) == plain:
        return config
    return _renewed(OmegaConf.to_container(config, resolve=True), group, say=True)


def _option(argument: str) -> str:
    """An argument with the option that there is now."""
    for group, names in _RENAMED.items():
        for old, new in names.items():
            found = re.fullmatch(rf"([+~]*){group}\.({old}|{new})((?:\.[\w.]+)?)((?:=.*)?)", argument, re.DOTALL)
            if found:
                sign, name, inner, value = found.groups()
                if name == old:
                    _now(f"{group}.{old}", f"{group}.{new}")
                # where there is no part by default, its options have to be added
                return f"{'++' if inner and '~' not in sign else sign}{group}.{new}{inner}{value}"
    return argument


def _renewed(options: Any, group: str, *, say: bool) -> Any:
    """Options with the words of now; `group` is empty within a part."""
    if isinstance(options, list):
        return [_renewed(each, "", say=say) for each in options]
    if not isinstance(options, dict):
        return options
    names, renewed = _RENAMED.get(group, {}), {}
    for key, value in options.items():
        if key == "_target_" and value in _MOVED:
            renewed[key] = _now(value, _MOVED[value]) if say else _MOVED[value]
        elif key in names:
            new = names[key]
            if say:
                _now(f"{group}.{key}", f"{group}.{new}")
            renewed[new] = _renewed(value, "", say=say)
        elif renewed.get(key) is None:
            renewed[key] = _renewed(value, "", say=say)
    return renewed


def _now(old: str, new: str) -> str:
    """The new word, said once."""
    if old not in _said:
        _said.add(old)
        print(f"acalx: {old} is {new} now", file=sys.stderr)
    return new
