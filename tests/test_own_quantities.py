"""A vector that acalx has no name for: by known values and by magnitude, from the stand and from columns of a file."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import acalx
from acalx.errors import CompatibilityError, DataError, PluginError
from acalx.estimation import calibrate, read_readings
from acalx.estimation.columns import needs_of
from acalx.estimation.correction import ModelCorrection
from acalx.models import Compared, Joined, Magnitude, Model, Outputs, VectorAccel, as_model
from acalx.models.contract import check_declared
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.recording import RunDirectory
from acalx.recording.calibration import record_corrected
from acalx.sensors import Channel, Sensor
from acalx.stands import Setting, Stand, TwoAxis

NOISE = 1e-3


@dataclass(frozen=True)
class Plates(Stand):
    """A two-axis table between plates with a field that may be switched lower and higher."""

    @property
    def settings(self) -> tuple[Setting, ...]:
        return Setting("alpha1", 0.0, math.tau), Setting("alpha2", 0.0, math.tau)

    def stimulus(self, settings: Array) -> Stimulus:
        turned = TwoAxis().stimulus(settings)["specific_force"]
        return Stimulus({"electric_field": 5.0 * turned, "specific_force": turned}, units={"electric_field": "V/m"})


@dataclass(frozen=True)
class Probe(Sensor):
    """Three electrodes."""

    vectors: tuple[str, ...] = ("electric_field",)  # type: ignore[assignment]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        units = {"bias": "V/m", "scale": "1"}
        return tuple(
            Parameter(f"{group}_{axis}", group, unit, scatter=0.01) for group, unit in units.items() for axis in "xyz"
        )

    @property
    def channels(self) -> tuple[Channel, ...]:
        return tuple(Channel(f"e{axis}", "V/m", NOISE) for axis in "xyz")

    @property
    def needs(self) -> Mapping[str, str]:
        return {"electric_field": "V/m"}

    @property
    def senses(self) -> tuple[str, ...]:
        return ("electric_field",)

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        bias, scale = parameters[..., None, :3], parameters[..., None, 3:]
        return np.asarray(bias + (1.0 + scale) * stimulus["electric_field"])


MODELS: dict[str, Model] = {
    "outputs": Compared(Probe(), Outputs()),
    "magnitude": Compared(Probe(), Magnitude("electric_field", varies=True)),
    "joined": Joined({"probe": Compared(Probe(), Magnitude(varies=True)), "accel": VectorAccel(noise_g=1e-3)}),
}
TRUTH = np.array([0.02, 0.01, -0.03, 0.01, -0.02, 0.005])


@pytest.mark.parametrize("name", MODELS)
def test_it_goes_the_whole_way(name: str, tmp_path: Path) -> None:
    model, stand = MODELS[name], Plates()
    problem = acalx.Problem(stand, model, acalx.D(), n=12)
    designed = acalx.design(problem, acalx.Gradient())
    felt = stand.stimulus(designed.program)
    truth = np.concatenate([TRUTH, np.zeros(len(model.parameters) - 6)])
    rng = np.random.default_rng(0)
    clean = model.readings(truth, felt)
    means = clean + NOISE * rng.standard_normal(clean.shape)
    path = tmp_path / "told.csv"
    told = {f"{name}_{axis}{unit}": k for name, unit in UNITS.items() for k, axis in enumerate("xyz")}
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow([*told, *(channel.name for channel in model.channels)])
        out.writerows(np.column_stack([felt["electric_field"], felt["specific_force"], means]).tolist())
    readings = read_readings(path, [channel.name for channel in model.channels], quantities=needs_of(model))
    estimate = calibrate(readings, model).estimate
    np.testing.assert_allclose(estimate.parameters, truth, atol=6.0 * estimate.standard_errors.max())


UNITS = {"electric_field": "_V_m", "specific_force": "_g"}


def test_columns_that_are_missing_are_named_one_by_one(tmp_path: Path) -> None:
    path = tmp_path / "untold.csv"
    path.write_text("ex,ey,ez\n" + "1,2,3\n2,1,3\n" * 6)
    readings = read_readings(path, ["ex", "ey", "ez"], quantities={"electric_field": "V/m"})
    with pytest.raises(DataError, match="electric_field_x_V_m, electric_field_y_V_m, electric_field_z_V_m"):
        calibrate(readings, Probe())


def test_a_correction_names_the_columns_that_it_lacks(tmp_path: Path) -> None:
    path = tmp_path / "alone.csv"
    path.write_text("ex,ey,ez\n1,2,3\n", encoding="utf-8")
    correction = ModelCorrection(as_model(Blind()), TRUTH, np.ones(3), 0.0, "V/m")
    with pytest.raises(DataError, match=r"corrected by what is known .* electric_field_x_V_m, electric_field_y_V_m"):
        record_corrected(correction, str(path), ["ex", "ey", "ez"], RunDirectory(tmp_path / "run", []))


@dataclass(frozen=True)
class Blind(Probe):
    """The same, whose readings tell nothing by themselves."""

    @property
    def senses(self) -> tuple[str, ...]:
        return ()


def test_what_is_no_vector_has_no_magnitude() -> None:
    with pytest.raises(CompatibilityError, match=r"Probe takes the electric field as one number.*vectors = \('elec"):
        Compared(Probe(vectors=()), Magnitude("electric_field", varies=True))
    as_model(Probe(vectors=()))


@pytest.mark.parametrize("vectors", ["electric_field", ("magnetic_field",), 3])
def test_vectors_are_among_the_needs(vectors: tuple[str, ...]) -> None:
    with pytest.raises(PluginError, match=r"Probe\.vectors is .*; give a tuple of those quantities"):
        check_declared(Probe(vectors=vectors))


def test_a_length_that_is_not_one_is_refused() -> None:
    with pytest.raises(CompatibilityError, match="for 1, but on stand Plates it is 5"):
        acalx.Problem(Plates(), Compared(Probe(), Magnitude()), acalx.D(), n=9)
