"""Models taken apart by kinds of sensors, with the names that their parameters have in the whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from acalx.models.base import Model
from acalx.models.composite import Composite

__all__ = ["Named", "parts_of"]


@final
@dataclass(frozen=True)
class Named(Composite):
    """One model, with something before the names of its parameters and channels.

    Parameters
    ----------
    model : Model
    prefix : str
    """

    model: Model
    prefix: str

    @property
    def called(self) -> str:
        """The same as of the model itself."""
        return self.model.called

    @property
    def kind(self) -> str:
        """The same as of the model itself."""
        return self.model.kind

    @property
    def models(self) -> tuple[Model, ...]:
        """The one model that it names anew."""
        return (self.model,)

    @property
    def prefixes(self) -> tuple[str, ...]:
        """The prefix that was given."""
        return (self.prefix,)


def parts_of(model: Model) -> tuple[Model, ...]:
    """A model taken apart by kinds of sensors, in the order of its parameters; itself where parts share parameters."""
    if not isinstance(model, Composite):
        return model.by_kind
    if model.shared:
        return (model,)
    named = zip(model.models, model.prefixes, strict=True)
    return tuple(Named(one, prefix) if prefix else one for part, prefix in named for one in parts_of(part))
