"""Any sensor with what of its readings is compared: the model that most people need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, final

from acalx.errors import CompatibilityError, Option
from acalx.models.base import Model
from acalx.models.comparisons import Comparison, Outputs
from acalx.models.contract import check_declared
from acalx.models.sensor_model import SensorModel
from acalx.options import require_part
from acalx.sensors.base import Sensor

__all__ = ["Compared", "as_model", "compared_by"]


@final
@dataclass(frozen=True)
class Compared(SensorModel):
    """Any sensor, with what of its readings is compared and what is known of it before.

    Parameters
    ----------
    sensor : Sensor
    comparison : Comparison
    prior : mapping of str to float, optional
        Standard deviations of parameters, or of all of a group, before anything is measured, by name, in
        their unit: information that is there already.

    Raises
    ------
    ArgumentError
        Something else than a sensor or a comparison; a prior that is not positive, or of a parameter that
        there is not.
    CompatibilityError
        Readings that do not have what is to be compared.
    PluginError
        A sensor that says of itself what can't be.
    """

    sensor: Sensor
    comparison: Comparison = field(default_factory=Outputs)

    def __post_init__(self) -> None:
        require_part("sensor", self.sensor, Sensor)
        require_part("comparison", self.comparison, Comparison)
        check_declared(self.sensor)
        self._compare(self.sensor, self.comparison)

    @property
    def by_kind(self) -> tuple[Model, ...]:
        """A model of each kind of sensors in it, where they share no parameters and the readings are compared."""
        kinds, sensor = self.sensor.parts, self.sensor
        if len(kinds) == 1 or not self.comparison.of_readings:
            return (self,)
        parts = [part for kind, numbers in kinds.items() if (part := sensor.part(numbers, kind)) is not None]
        if len(parts) < len(kinds):
            return (self,)
        names = [{parameter.name for parameter in part.parameters} for part in parts]
        if sum(map(len, names)) > len(self.parameters):
            return (self,)
        groups = {parameter.name: parameter.group for parameter in self.parameters}
        own = [{**names_of, **{groups[name]: None for name in names_of}} for names_of in map(dict.fromkeys, names)]
        priors = [{name: sd for name, sd in (self.prior or {}).items() if name in known} for known in own]
        return tuple(Compared(part, prior=prior) for part, prior in zip(parts, priors, strict=True))

    @property
    def usual(self) -> Mapping[str, Any]:  # type: ignore[override]
        """What suits the sensor."""
        return self.sensor.usual

    @property
    def called(self) -> str:
        """The name of the sensor."""
        return type(self.sensor).__name__


def compared_by(model: Model, comparison: Comparison | None) -> Model:
    """The same sensor, with something else of its readings compared; as it is where nothing else is asked for.

    Raises
    ------
    CompatibilityError
        A model that is no sensor with a comparison; readings that do not have it.
    """
    if comparison is None or model.compares(comparison):
        return model
    if isinstance(model, SensorModel):
        return Compared(model.sensor, comparison, prior=model.prior)
    raise CompatibilityError(
        "model {model} says itself what of its readings is compared: leave {comparison} out",
        model=model.called,
        comparison=Option("estimator.comparison", type(comparison).__name__, f"{type(comparison).__name__}()"),
    )


def as_model(given: object) -> Model:
    """A model as it is; of a sensor that of its outputs.

    Raises
    ------
    ArgumentError
        Anything else.
    """
    if isinstance(given, Sensor):
        return Compared(given)
    require_part("model", given, Model)
    assert isinstance(given, Model)
    return given
