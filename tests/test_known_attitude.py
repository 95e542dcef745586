"""Files that say what was felt: a program with readings beside it, cosines, and columns of each quantity."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from acalx.errors import ArgumentError, DataError
from acalx.estimation import Readings, calibrate, read_readings
from acalx.estimation.columns import needs_of
from acalx.models import Model, as_model
from acalx.numerics.arrays import Array
from acalx.programs import find_program
from acalx.quantities.stimulus import EARTH_RATE, VECTORS
from acalx.stands import Stand
from command import Outcome, run, together
from configured import part

# Models with the stand that suits them, and so many positions.
CASES = {
    "vector_accel": 8,
    "vector_magnetometer": 8,
    "accel_temperature": 12,
    "gyro_turns": 8,
    "imu": 12,
    "platform": 30,
}
QUICK = ("optimizer=gradient", "optimizer.starts=1", "certificate=false", "figures=false", "seed=1")
each_case = pytest.mark.parametrize("name", CASES)


@cache
def model_of(name: str) -> Model:
    return as_model(part("model", name))


def stand_name(name: str) -> str:
    return str(model_of(name).usual.get("stand", "two_axis"))


@cache
def stand_of(name: str) -> Stand:
    stand: Stand = part("stand", stand_name(name))
    return stand


@pytest.fixture(scope="module")
def designed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Outcome]:
    folder = tmp_path_factory.mktemp("known")
    calls = [
        partial(run, folder, f"model={name}", f"stand={stand_name(name)}", "criterion=d", f"n={n}", *QUICK, into=name)
        for name, n in CASES.items()
    ]
    return dict(zip(CASES, together(calls), strict=True))


def truth_of(name: str) -> Array:
    parameters = model_of(name).parameters
    scatter = np.array([parameter.scatter or 1e-3 for parameter in parameters])
    return 0.1 * scatter * np.random.default_rng(2).standard_normal(len(parameters))


@dataclass(frozen=True)
class Pasted:
    """The rows of a program, and what is read there without noise."""

    header: str
    rows: list[str]
    settings: Array
    means: Array

    def file(self, path: Path, header: str, *columns: Array) -> Path:
        """Columns of its own in the place of the program's."""
        table = np.column_stack([self.means, *columns])
        lines = [header, *(",".join(map(repr, row)) for row in table.tolist())]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path


def pasted(name: str, outcome: Outcome) -> Pasted:
    assert outcome.status == 0, outcome.err
    header, *rows = outcome.text().splitlines()
    settings = find_program(str(outcome.directory / "program.csv")).settings_for(stand_of(name))
    return Pasted(header, rows, settings, model_of(name).readings(truth_of(name), stand_of(name).stimulus(settings)))


def channels(name: str) -> list[str]:
    return [channel.name for channel in model_of(name).channels]


def read(name: str, path: Path, *, stand: bool = True) -> Readings:
    return read_readings(
        path, channels(name), stand=stand_of(name) if stand else None, quantities=needs_of(model_of(name))
    )


def assert_truth_is_found(name: str, readings: Readings) -> None:
    found = calibrate(readings, model_of(name)).estimate.parameters
    np.testing.assert_allclose(found, truth_of(name), atol=1e-8)


@each_case
def test_a_program_with_readings_beside_it_is_a_measurement(
    designed: dict[str, Outcome], tmp_path: Path, name: str
) -> None:
    given = pasted(name, designed[name])
    path = tmp_path / "measured.csv"
    lines = [",".join([given.header, *channels(name)])]
    lines += [",".join([row, *map(repr, own)]) for row, own in zip(given.rows, given.means.tolist(), strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert_truth_is_found(name, read(name, path))


@each_case
def test_the_settings_of_the_stand_are_enough(designed: dict[str, Outcome], tmp_path: Path, name: str) -> None:
    given, axes = pasted(name, designed[name]), stand_of(name).axes
    header = ",".join([*channels(name), *axes.columns])
    assert_truth_is_found(name, read(name, given.file(tmp_path / "a.csv", header, axes.written(given.settings))))


# How units are written behind the name of a column, and what is in that where stands give 1.
SUFFIXES: dict[str, dict[str, float]] = {
    "specific_force": {"": 1.0, "_g": 1.0, "_m_s2": 9.80665},
    "angular_rate": {
        "_earth_rate": 1.0,
        "_rad_s": EARTH_RATE,
        "_deg_s": np.degrees(EARTH_RATE),
        "_deg_h": 3600.0 * np.degrees(EARTH_RATE),
    },
    "magnetic_field": {"_field": 1.0},
    "temperature": {"_degC": 1.0},
}


def columns_of(quantity: str, suffix: str | None = None) -> list[str]:
    end = list(SUFFIXES[quantity])[-1] if suffix is None else suffix
    return [f"{quantity}_{axis}{end}" for axis in "xyz"] if quantity in VECTORS else [f"{quantity}{end}"]


def written(quantity: str, felt: Array) -> Array:
    """What was felt, in the unit of the columns."""
    return felt * list(SUFFIXES[quantity].values())[-1]


BY_COLUMNS = ["vector_accel", "vector_magnetometer", "accel_temperature", "platform"]


@pytest.mark.parametrize("name", BY_COLUMNS)
def test_columns_of_each_quantity_are_enough(designed: dict[str, Outcome], tmp_path: Path, name: str) -> None:
    given, needs = pasted(name, designed[name]), model_of(name).needs
    felt = stand_of(name).stimulus(given.settings)
    header = ",".join([*channels(name), *(column for quantity in needs for column in columns_of(quantity))])
    path = given.file(tmp_path / "columns.csv", header, *(written(quantity, felt[quantity]) for quantity in needs))
    assert_truth_is_found(name, read(name, path, stand=False))


@pytest.mark.parametrize("name", ["vector_accel", "accel_temperature", "platform"])
def test_direction_cosines_say_the_specific_force(designed: dict[str, Outcome], tmp_path: Path, name: str) -> None:
    given = pasted(name, designed[name])
    felt = stand_of(name).stimulus(given.settings)
    others = [quantity for quantity in model_of(name).needs if quantity != "specific_force"]
    header = [*channels(name), "eta_x", "eta_y", "eta_z", *(c for quantity in others for c in columns_of(quantity))]
    told = [written(quantity, felt[quantity]) for quantity in others]
    path = given.file(tmp_path / "cosines.csv", ",".join(header), felt["specific_force"], *told)
    assert_truth_is_found(name, read(name, path, stand=False))


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("vector_accel", ["eta_x, eta_y, eta_z"]),
        ("vector_magnetometer", ["field_eta_x"]),
        ("accel_temperature", ["eta_x, eta_y, eta_z", "temperature_degC (or .._K)"]),
        ("imu", ["eta_x, eta_y, eta_z", "angular_rate_x_deg_s"]),
        ("gyro_turns", ["angular_rate_x_deg_s, angular_rate_y_deg_s, angular_rate_z_deg_s (or .._deg_h, .._rad_s"]),
    ],
)
def test_what_is_not_known_is_named_with_its_columns(
    designed: dict[str, Outcome], tmp_path: Path, name: str, columns: list[str]
) -> None:
    given = pasted(name, designed[name])
    readings = read(name, given.file(tmp_path / "bare.csv", ",".join(channels(name))))
    with pytest.raises(DataError) as caught:
        calibrate(readings, model_of(name))
    message = str(caught.value)
    assert "\n" not in message
    assert "bare.csv" in message
    for column in columns:
        assert column in message


def test_cosines_of_another_length_are_refused_in_their_row(designed: dict[str, Outcome], tmp_path: Path) -> None:
    given = pasted("vector_accel", designed["vector_accel"])
    cosines = stand_of("vector_accel").stimulus(given.settings)["specific_force"].copy()
    cosines[2] *= 1.01
    path = given.file(tmp_path / "long.csv", ",".join([*channels("vector_accel"), "eta_x", "eta_y", "eta_z"]), cosines)
    with pytest.raises(DataError, match=r"long.csv, row 4, columns eta_x, eta_y, eta_z: the length .* is 1.01"):
        read("vector_accel", path)


def test_cosines_that_contradict_the_settings_are_refused(designed: dict[str, Outcome], tmp_path: Path) -> None:
    given, stand = pasted("vector_accel", designed["vector_accel"]), stand_of("vector_accel")
    cosines = stand.stimulus(given.settings)["specific_force"].copy()
    header = ",".join([*channels("vector_accel"), *stand.axes.columns, "eta_x", "eta_y", "eta_z"])
    near = stand.stimulus(given.settings + 0.02)["specific_force"]  # known better than what was set
    read("vector_accel", given.file(tmp_path / "near.csv", header, stand.axes.written(given.settings), near))
    cosines[[1, 2]] = cosines[[2, 1]]
    path = given.file(tmp_path / "swapped.csv", header, stand.axes.written(given.settings), cosines)
    with pytest.raises(DataError, match=r"swapped.csv: alpha1_deg .* and eta_x .* contradict each other.*; leave"):
        read("vector_accel", path)


def test_the_command_says_what_is_not_known(designed: dict[str, Outcome]) -> None:
    given = pasted("accel_temperature", designed["accel_temperature"])
    folder = designed["accel_temperature"].directory
    given.file(folder / "bare.csv", ",".join(channels("accel_temperature")))
    outcome = run(folder, "model=accel_temperature", "stand=chamber", "data=bare.csv", into="c", entry="calibrate")
    assert outcome.status == 1
    assert "Traceback" not in outcome.err
    assert outcome.err.count("\n") == 1
    assert "temperature" in outcome.err


# ---------------------------------------------------------------- units in the names of columns


@pytest.mark.parametrize(
    ("name", "quantity", "suffix"),
    [
        ("platform", "angular_rate", "_deg_h"),
        ("platform", "angular_rate", "_rad_s"),
        ("platform", "angular_rate", "_deg_s"),
        ("platform", "angular_rate", "_earth_rate"),
        ("vector_accel", "specific_force", "_g"),
        ("vector_accel", "specific_force", "_m_s2"),
        ("vector_accel", "specific_force", ""),
        ("vector_magnetometer", "magnetic_field", "_field"),
    ],
)
def test_names_of_columns_end_in_their_unit(
    designed: dict[str, Outcome], tmp_path: Path, name: str, quantity: str, suffix: str
) -> None:
    given = pasted(name, designed[name])
    felt = stand_of(name).stimulus(given.settings)
    others = [other for other in model_of(name).needs if other != quantity]
    header = [*channels(name), *columns_of(quantity, suffix), *(c for other in others for c in columns_of(other))]
    told = [felt[quantity] * SUFFIXES[quantity][suffix], *(written(other, felt[other]) for other in others)]
    assert_truth_is_found(name, read(name, given.file(tmp_path / "u.csv", ",".join(header), *told), stand=False))


def test_kelvins_are_degrees_celsius_from_elsewhere(designed: dict[str, Outcome], tmp_path: Path) -> None:
    name = "accel_temperature"
    given = pasted(name, designed[name])
    felt = stand_of(name).stimulus(given.settings)
    header = ",".join([*channels(name), "eta_x,eta_y,eta_z,temperature_K"])
    path = given.file(tmp_path / "k.csv", header, felt["specific_force"], felt["temperature"] + 273.15)
    assert_truth_is_found(name, read(name, path, stand=False))
    kelvin = read_readings(path, channels(name), quantities={"specific_force": "g", "temperature": "K"})
    assert kelvin.stimulus is not None
    assert kelvin.stimulus.units["temperature"] == "K"
    np.testing.assert_allclose(kelvin.stimulus["temperature"], felt["temperature"] + 273.15)


@pytest.mark.parametrize(
    ("name", "quantity", "right"),
    [
        ("platform", "angular_rate", "angular_rate_x_deg_s, angular_rate_y_deg_s, angular_rate_z_deg_s or "),
        ("vector_magnetometer", "magnetic_field", "magnetic_field_x_uT, "),
        ("accel_temperature", "temperature", "temperature_degC or temperature_K"),
    ],
)
def test_columns_that_could_be_in_several_units_are_refused(
    designed: dict[str, Outcome], tmp_path: Path, name: str, quantity: str, right: str
) -> None:
    given = pasted(name, designed[name])
    felt = stand_of(name).stimulus(given.settings)
    path = given.file(tmp_path / "no.csv", ",".join([*channels(name), *columns_of(quantity, "")]), felt[quantity])
    with pytest.raises(DataError, match=rf"no.csv: {quantity}.* without a unit in the name; call it {right}"):
        read(name, path)


def test_direction_cosines_say_where_the_field_is(designed: dict[str, Outcome], tmp_path: Path) -> None:
    name = "vector_magnetometer"
    given, stand = pasted(name, designed[name]), stand_of(name)
    field = stand.stimulus(given.settings)["magnetic_field"].copy()
    cosines = "field_eta_x,field_eta_y,field_eta_z"
    header = ",".join([*channels(name), cosines])
    assert_truth_is_found(name, read(name, given.file(tmp_path / "f.csv", header, field), stand=False))
    with pytest.raises(DataError, match=r"long.csv, row 2, columns field_eta_x, .* direction cosines must have length"):
        read(name, given.file(tmp_path / "long.csv", header, 48.0 * field))
    field[[1, 2]] = field[[2, 1]]
    header = ",".join([*channels(name), *stand.axes.columns, cosines])
    path = given.file(tmp_path / "swapped.csv", header, stand.axes.written(given.settings), field)
    with pytest.raises(DataError, match=r"the magnetic field is more than 5 degrees from there"):
        read(name, path)


def test_a_field_in_teslas_is_for_a_sensor_of_teslas(designed: dict[str, Outcome], tmp_path: Path) -> None:
    name = "vector_magnetometer"
    given = pasted(name, designed[name])
    field = 48.0 * stand_of(name).stimulus(given.settings)["magnetic_field"]
    header = ",".join([*channels(name), *columns_of("magnetic_field", "_uT")])
    path = given.file(tmp_path / "t.csv", header, field)
    with pytest.raises(DataError, match=r"magnetic_field_x_uT, .* can't be in field, .*: give field_eta_x, "):
        read(name, path, stand=False)
    found = read_readings(path, channels(name), quantities={"magnetic_field": "uT"}).stimulus
    assert found is not None
    assert found.units["magnetic_field"] == "uT"
    np.testing.assert_allclose(found["magnetic_field"], field)


def test_messages_name_the_columns_of_the_channels(designed: dict[str, Outcome], tmp_path: Path) -> None:
    given = pasted("platform", designed["platform"])
    readings = read(
        "platform",
        given.file(
            tmp_path / "b.csv",
            ",".join([*channels("platform"), *stand_columns()]),
            stand_of("platform").axes.written(given.settings),
        ),
    )
    with pytest.raises(DataError, match="columns s" + ", s".join(channels("platform")) + " and numbers of samples"):
        calibrate(readings, model_of("platform"), noise="columns")
    with pytest.raises(ArgumentError, match=r"noise=-1: .*mean as a multiple of that of the model|mean in "):
        calibrate(readings, model_of("platform"), noise=-1)


def stand_columns() -> list[str]:
    return list(stand_of("platform").axes.columns)
