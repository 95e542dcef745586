"""Every option of every part of the configuration, given nonsense: one message that names it as it was typed."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from omegaconf import DictConfig, OmegaConf

from acalx.commands.composition import build
from acalx.commands.explain import as_override
from acalx.errors import AcalxError, ArgumentError, Option
from configured import CONF, SMALL, names

NONSENSE = ("nonsense", -7, [1, 2, 3, 4, 5])
# What is no nonsense, or can be judged only beside the other parts.
TAKEN = {
    "criterion.group": NONSENSE,
    "optimizer.solver": ("nonsense",),
    "optimizer.steps_deg": ([1, 2, 3, 4, 5],),
    "scheme.order": ([1, 2, 3, 4, 5],),
    "stand.azimuth_deg": (-7,),
    "stand.dip_deg": (-7,),
    "stand.field_azimuth_deg": (-7,),
    "stand.latitude_deg": (-7,),
    "unit.name": ("nonsense",),
    "unit.offset": (-7,),
}
# The target of a criterion is an option of the command line's own.
ELSEWHERE = {"criterion.standard_errors": "target"}


def leaves(config: DictConfig, before: str = "") -> Iterator[str]:
    """Paths of the options of a part, those of its parts among them."""
    for key in config:
        if isinstance(config[key], DictConfig):
            yield from leaves(config[key], f"{before}{key}.")
        elif key != "_target_":
            yield f"{before}{key}"


def options() -> Iterator[tuple[str, DictConfig, str]]:
    for group in sorted({path.parent.name for path in CONF.glob("*/*.yaml")}):
        for name in names(group):
            part = OmegaConf.load(CONF / group / f"{name}.yaml")
            assert isinstance(part, DictConfig)
            if "_target_" in part:
                whole = OmegaConf.create(
                    {group: OmegaConf.merge(part, SMALL.get(f"{group}/{name}", {})), "target": None}
                )
                for leaf in leaves(whole[group]):
                    yield group, whole, leaf


OPTIONS = list(options())


@pytest.mark.parametrize(
    ("group", "whole", "leaf"), OPTIONS, ids=[f"{group}-{k}-{leaf}" for k, (group, _, leaf) in enumerate(OPTIONS)]
)
def test_nonsense_is_quoted_under_the_name_that_was_typed(group: str, whole: DictConfig, leaf: str) -> None:
    first = f"{group}.{leaf.partition('.')[0]}"
    for nonsense in NONSENSE:
        given = OmegaConf.merge(whole)
        OmegaConf.update(given, f"{group}.{leaf}", nonsense)
        if nonsense in TAKEN.get(first, ()):
            build(given, group, object)
            continue
        with pytest.raises(AcalxError) as caught:
            build(given, group, object)
        message = caught.value.said(as_override)
        assert message.lstrip("'").startswith(ELSEWHERE.get(first, first)), message
        shown = as_override(Option("x", nonsense)).strip("'").partition("=")[2]
        assert shown.partition(",")[0] in message, message  # of a list one entry may be quoted alone


def test_python_reads_the_argument_alone() -> None:
    error = ArgumentError.of("optimizer.starts", 0, "give more", 8)
    assert str(error) == "starts=0: give more, as in starts=8"
    assert repr(error) == "ArgumentError('starts=0: give more, as in starts=8')"
    assert error.said(as_override) == "optimizer.starts=0: give more, as in optimizer.starts=8"
    assert error.data["given"] == Option("optimizer.starts", 0)
