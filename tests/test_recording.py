"""What a run directory holds: written whole, read again as it was, never over another."""

import csv
import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from acalx.errors import ArgumentError
from acalx.programs import read_program
from acalx.quantities.units import DEGREE
from acalx.recording import RunDirectory
from acalx.search.result import Solution
from parts import FULL


def read(directory: RunDirectory) -> dict:
    return json.loads((directory.path / "result.json").read_text())


def test_a_result_has_all_the_keys_also_when_it_failed(tmp_path):
    directory = RunDirectory(tmp_path / "a" / "b", ["n=8"])
    assert not directory.recorded
    directory.remember(n=8)
    directory.write_result("failed", "a reason")
    assert directory.recorded
    result = read(directory)
    assert (result["status"], result["message"], result["n"]) == ("failed", "a reason", 8)
    assert result["overrides"] == ["n=8"]
    assert {"seed", "metrics", "loss", "evaluations", "seconds", "versions"} <= set(result)


def test_numbers_are_plain_json(tmp_path):
    directory = RunDirectory(tmp_path, [])
    entries = {"a": np.float64(1.5), "b": np.arange(3), "c": np.inf, "d": (np.nan, [np.int64(2)]), "e": {1: np.True_}}
    directory.write_result("ok", "", **entries)
    result = read(directory)
    assert [result[key] for key in "abcde"] == [1.5, [0, 1, 2], None, [None, [2]], {"1": True}]


def test_a_result_is_never_seen_half_written(tmp_path):
    directory = RunDirectory(tmp_path, [])
    big = list(range(20000))
    directory.write_result("ok", "0", big=big)
    with ThreadPoolExecutor(1) as pool:
        writing = pool.submit(lambda: [directory.write_result("ok", str(k), big=big) for k in range(20)])
        while not writing.done():
            assert read(directory)["big"] == big
    assert [path.name for path in tmp_path.iterdir()] == ["result.json"]


def test_a_directory_with_a_result_is_refused(tmp_path):
    RunDirectory(tmp_path, []).write_result("ok", "")
    with pytest.raises(ArgumentError, match="holds a run already"):
        RunDirectory(tmp_path, [])


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(ArgumentError, match=r"can't write to .*file.*hydra\.run\.dir"):
            RunDirectory(path, [])


def test_a_program_is_read_again_as_it_was_written(tmp_path):
    settings = FULL.axes.random(np.random.default_rng(0), (30,))
    RunDirectory(tmp_path, []).write_program(FULL, settings)
    again = read_program(tmp_path / "program.csv").settings_for(FULL)
    np.testing.assert_allclose(again, settings, rtol=0, atol=2e-14)
    RunDirectory(tmp_path / "b", []).write_program(FULL, again)
    assert (tmp_path / "b" / "program.csv").read_text().split("\n")[0].startswith("position,")


@pytest.mark.parametrize("step", [15.0, 7.5, 5.0, 0.1, 0.05, 1.0 / 3.0])
def test_stops_in_degrees_are_free_of_rounding(step):
    stops = np.arange(-3600, 3601) * step
    stops = stops[np.abs(stops) <= 720]
    written = DEGREE.write(np.radians(stops))
    assert all(len(repr(float(value))) <= 17 for value in written)
    np.testing.assert_allclose(written, stops, rtol=0, atol=1e-12)
    if step in (15.0, 7.5, 5.0):
        assert (written == stops).all()
    assert not np.signbit(DEGREE.write(np.array([-0.0])))[0]


def test_history_and_alternatives(tmp_path):
    directory = RunDirectory(tmp_path, [])
    directory.write_history([(8, 0.5, -1.25), (16, 0.75, -2.0)])
    rows = list(csv.DictReader((tmp_path / "history.csv").read_text().splitlines()))
    assert [(row["evaluations"], float(row["loss"])) for row in rows] == [("8", -1.25), ("16", -2.0)]
    solutions = [Solution(np.zeros((2, 2)), -2.0), Solution(np.ones((2, 2)), -1.5)]
    directory.write_alternatives(FULL, solutions)
    rows = list(csv.DictReader((tmp_path / "alternatives.csv").read_text().splitlines()))
    assert [(row["program"], row["position"]) for row in rows] == [("1", "1"), ("1", "2"), ("2", "1"), ("2", "2")]
    assert float(rows[3]["alpha1_deg"]) == pytest.approx(np.degrees(1.0), abs=1e-12)
