"""The study of an inertial measurement unit: its command gives the page that is kept here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from acalx.programs import read_program
from acalx.sensors import IMU
from acalx.stands import TwoAxisRateTable
from acalx.testing import check_sensor
from command import Outcome, execute
from measured import MEASURED, needs_measured
from studies import modules_of
from test_experiments import NUMBER, files, is_close, table_in

STUDY = Path(__file__).parents[1] / "experiments" / "imu"
HEADING = "## Real sensors"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The page, with the part on real sensors where there are data."""
    folder = tmp_path_factory.mktemp("imu")
    outcome = execute(folder, "python", str(STUDY / "run.py"), "--data", str(MEASURED), "--to", "page")
    return Outcome(outcome.status, outcome.out, outcome.err, folder / "page")


def kept() -> str:
    return (STUDY / "README.md").read_text(encoding="utf-8")


def assert_alike(one: str, other: str) -> None:
    assert NUMBER.sub("#", one) == NUMBER.sub("#", other)
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    assert [pair for pair in pairs if not is_close(*pair)] == []


def test_the_command_writes_the_page_that_is_kept(written: Outcome) -> None:
    assert written.status == 0, written.err
    assert written.err == ""
    assert_alike(kept().partition(HEADING)[0], written.text("README.md").partition(HEADING)[0])
    for name in [*(f"joint_{n}" for n in (12, 20, 24, 30, 36, 40)), "joint_24_plain"]:
        of_both = [read_program(folder / "programs" / f"{name}.csv") for folder in (STUDY, written.directory)]
        np.testing.assert_allclose(*(program.settings_for(TwoAxisRateTable()) for program in of_both))


@needs_measured
def test_the_part_on_real_sensors_is_as_it_is_kept(written: Outcome) -> None:
    assert_alike(kept().partition(HEADING)[2], written.text("README.md").partition(HEADING)[2])
    sources = {path.name for path in STUDY.glob("*.py")} | {"page.md", "measured.md"}
    assert files(written.directory) == files(STUDY) - sources


def test_without_data_a_sentence_says_what_to_give(tmp_path: Path) -> None:
    (run,) = modules_of(STUDY, ("run",))
    assert run.measurements(Path("nowhere"), tmp_path).startswith("There are no measurements in nowhere: give --data")
    assert "give --data DIRECTORY" in run.measurements(None, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_page_says_what_the_tables_say() -> None:
    page = kept()
    _, *rows = table_in(page, "How many positions and turns")
    *groups, last = rows
    assert last[0] == "all that it shows"
    for column in (2, 3, 4, 5):
        needed = [int(row[column]) for row in groups if row[column] != "never"]
        assert max(needed) == int(last[column])
    assert all("never" not in row[5] for row in groups)
    _, *simulated = table_in(page, "Simulated")
    assert len(simulated) == 6
    for row in simulated:
        low, high = map(float, row[1].split(" to "))
        assert 0.95 < low < 1.0 < high < 1.05
    for name in ("standard_errors", "drift"):
        assert f"({name}.svg)" in page
        assert (STUDY / f"{name}.svg").is_file()
        assert (STUDY / f"{name}.png").is_file()


def test_recipes_turn_the_sensor_about_the_axes_that_the_page_says() -> None:
    (recipes,) = modules_of(STUDY, ("recipes",))
    stand = TwoAxisRateTable(averaging_s=0.0)
    six = recipes.RECIPES["six_faces_and_turns_12"]
    felt = stand.stimulus(six.settings(stand))
    vertical = np.round(felt["specific_force"][:6], 12)
    assert {tuple(row) for row in vertical} == {tuple(sign * row) for row in np.eye(3) for sign in (1.0, -1.0)}
    rates = felt["angular_rate"][6:]
    assert np.abs(rates).argmax(axis=1).tolist() == [0, 0, 1, 1, 2, 2]
    assert np.sign(rates[[0, 2, 4], [0, 1, 2]]).tolist() == [1.0, -1.0, 1.0]
    tumbles = recipes.RECIPES["tumbles_24"].settings(stand)
    assert len(np.unique(np.round(stand.stimulus(tumbles)["specific_force"], 9) + 0.0, axis=0)) == 18
    assert [recipe.n for recipe in recipes.RECIPES.values()] == [12, 24, 36]


def test_joint_programs_show_all_parameters_and_recipes_do_not() -> None:
    (programs,) = modules_of(STUDY, ("programs",))
    for n in (12, 24, 36):
        settings = read_program(STUDY / "programs" / f"joint_{n}.csv").settings_for(programs.STAND)
        joint = programs.Accuracy("joint", settings)
        assert joint.n == n
        assert joint.shown.all()
    recipes = programs.Programs().recipes
    hidden = {name: int((~one.shown).sum()) for name, one in recipes.items()}
    assert hidden == {"six_faces_and_turns_12": 4, "tumbles_24": 16, "multi_position_and_rates_36": 4}
    assert len(IMU().parameters) == 43


@pytest.mark.parametrize("drift", [False, True])
def test_gyros_at_rest_are_a_sensor(drift: bool) -> None:
    from acalx.quantities.stimulus import Stimulus

    (resting,) = modules_of(STUDY, ("resting",))
    sensor = resting.RestingGyros(drift=drift)
    if not drift:
        check_sensor(sensor, TwoAxisRateTable())
    felt = Stimulus(specific_force=np.eye(3), temperature=np.array([[-0.5], [0.0], [0.5]]))
    true = np.arange(1.0, len(sensor.parameters) + 1.0)
    rows = sensor.by_parameters(true, felt)
    np.testing.assert_allclose(rows @ true, sensor.readings(true, felt))
    assert len(sensor.parameters) == (15 if drift else 12)
