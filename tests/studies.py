"""Modules of a study, which lie beside its page and not in a package."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType


def modules_of(folder: Path, names: Sequence[str]) -> tuple[ModuleType, ...]:
    """Modules of a folder, which leave no names behind: other studies have modules of the same name."""
    before = set(sys.modules)
    sys.path.insert(0, str(folder))
    try:
        return tuple(importlib.import_module(name) for name in names)
    finally:
        sys.path.remove(str(folder))
        for name in set(sys.modules) - before:
            if Path(getattr(sys.modules[name], "__file__", None) or "").parent == folder:
                del sys.modules[name]
