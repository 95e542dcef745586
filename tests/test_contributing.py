"""Every example of CONTRIBUTING.md runs: modules, options and checks, as they stand there."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import hydra
import pytest
from omegaconf import OmegaConf

PAGE = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^( *)```(python|yaml) ?([\w/.]*)\n(.*?)^ *```$", PAGE, re.DOTALL | re.MULTILINE)
MODULES = {name: text for _, kind, name, text in BLOCKS if kind == "python" and name}
OPTIONS = {name: text for _, kind, name, text in BLOCKS if kind == "yaml"}
CHECKS = [re.sub(rf"^{indent}", "", text, flags=re.MULTILINE) for indent, _, name, text in BLOCKS if not name]


@pytest.fixture
def modules(tmp_path, monkeypatch):
    for name, text in MODULES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield
    for name in MODULES:
        sys.modules.pop(name.removesuffix(".py"), None)


def test_there_is_an_example_of_each_kind():
    groups = {name.partition("/")[0] for name in OPTIONS}
    assert groups == {"stand", "model", "criterion", "optimizer", "scheme", "estimator", "errors"}
    assert len(CHECKS) == 9


@pytest.mark.parametrize("code", CHECKS, ids=[code.splitlines()[-1] for code in CHECKS])
def test_checks_of_examples_pass(modules, code):
    exec(code, {})


@pytest.mark.parametrize("name", OPTIONS)
def test_options_of_examples_build(modules, name):
    config = OmegaConf.create(OPTIONS[name])
    part = hydra.utils.instantiate(config, _convert_="all")
    assert type(part).__name__ == config._target_.rpartition(".")[2]
