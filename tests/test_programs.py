"""Published programs reach their printed figures; files are read, or refused with a plain reason."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from acalx.criteria import D
from acalx.errors import AcalxError, CompatibilityError, ProgramError
from acalx.models import Platform, ScalarAccel
from acalx.planning.metrics import best_published
from acalx.problem import Problem
from acalx.programs import Program, find_program, published, published_for, read_program
from acalx.quantities.information import Information
from acalx.quantities.stimulus import Stimulus
from acalx.stands import PlatformGimbals, RateTable, Setting, Stand, TwoAxis

# of an accelerometer triad, and of a platform
PLATFORM_NAMES = tuple(name for name in published() if name.startswith("platform_"))
NAMES = tuple(name for name in published() if name not in PLATFORM_NAMES)
NONORTHOGONALITIES = ["nonorthogonality_xy", "nonorthogonality_xz", "nonorthogonality_zy"]
SMALLEST_D_OF_ONE_POSITION = 1.5377e7
ANGLES = "alpha1_deg,alpha2_deg\n22.2,351.7\n59.4,78.5\n"
COSINES = "eta_x,eta_y,eta_z\n1,0,0\n0,0.6,-0.8\n"


@dataclass(frozen=True)
class Gimbals(Stand):
    """A stand with other angles, which can't be aimed."""

    @property
    def settings(self) -> tuple[Setting, ...]:
        return Setting("outer", 0.0, 6.0), Setting("inner", 0.0, 6.0)

    def stimulus(self, settings):
        return Stimulus()


def vertical_of(program: Program) -> np.ndarray:
    if program.directions is not None:
        return program.directions
    return TwoAxis().stimulus(program.settings_for(TwoAxis()))["specific_force"]


def information_of(vertical: np.ndarray) -> Information:
    model = ScalarAccel()
    return Information.from_regressors(model.regressors(Stimulus(specific_force=vertical)), model.parameters)


def written(folder: Path, content: str | bytes, name: str = "program.csv") -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


# ---------------------------------------------------------------- published programs

# theta of axes_and_edges_9 is 2.6458, which the paper prints cut off, as 2.64
PRINTED = [
    ("egorov_2021_table_1", "0.0489", "0.59 0.93 1.35", "2.78 7.90 13.16"),
    ("axes_and_vertices_9", "0.7119", "0.71 0.71 2.74", "0.00 0.00 0.00"),
    ("axes_and_edges_9", "1.0000", "0.71 0.71 2.65", "0.00 0.00 0.00"),
    ("egorov_2021_table_2", "7.8e-05", "0.41 0.58 0.91", "0.03 0.05 0.04"),
    ("faces_and_edges_18", "8.6e-05", "0.41 0.53 1.00", "0.00 0.00 0.00"),
    ("rotations_18", "1.3e-04", "0.41 0.48 1.15", "0.00 0.00 0.00"),
]


@pytest.mark.parametrize("aimed", [False, True], ids=["as given", "through the stand"])
@pytest.mark.parametrize(("name", "determinant", "thetas", "inequalities"), PRINTED)
def test_published_programs_reach_their_printed_figures(name, determinant, thetas, inequalities, aimed):
    program, stand = find_program(name), TwoAxis()
    vertical = stand.stimulus(program.settings_for(stand))["specific_force"] if aimed else vertical_of(program)
    information = information_of(vertical)
    reached = np.exp(-information.log_det)
    assert (f"{reached:.1e}" if "e" in determinant else f"{reached:.4f}") == determinant
    assert " ".join(f"{information.theta(group):.2f}" for group in information.groups) == thetas
    shown = [f"{100 * abs(information.inequality(group)):.2f}" for group in information.groups]
    assert " ".join(shown) == inequalities


@pytest.mark.parametrize("name", ["icosahedron_12", "dodecahedron_20"])
def test_regular_solids_attain_the_bound(name):
    program = find_program(name)
    log_bound = np.log(SMALLEST_D_OF_ONE_POSITION) - 9 * np.log(program.n)
    assert -information_of(vertical_of(program)).log_det == pytest.approx(log_bound, abs=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_no_program_is_below_the_bound(name):
    program = find_program(name)
    log_bound = np.log(SMALLEST_D_OF_ONE_POSITION) - 9 * np.log(program.n)
    assert -information_of(vertical_of(program)).log_det > log_bound - 1e-4


@pytest.mark.parametrize("name", ["classical_6", "classical_12", "rotations_12"])
def test_right_angles_alone_hide_nonorthogonality(name):
    program = find_program(name)
    information = information_of(vertical_of(program))
    assert np.linalg.matrix_rank(information.matrix) == 6
    assert information.singular
    assert sorted(information.inestimable()) == NONORTHOGONALITIES
    assert "can't show non-orthogonality" in program.title


@pytest.mark.parametrize(
    "name", [name for name in NAMES if name not in ("classical_6", "classical_12", "rotations_12")]
)
def test_the_other_programs_show_every_parameter(name):
    information = information_of(vertical_of(find_program(name)))
    assert not information.singular
    assert information.inestimable() == []


@pytest.mark.parametrize("name", NAMES)
def test_every_published_program_is_complete(name):
    program = published()[name]
    assert program.name == name
    assert program.title
    assert "\n" not in program.title
    assert program.source
    vertical = vertical_of(program)
    assert vertical.shape == (program.n, 3)
    np.testing.assert_allclose(np.linalg.norm(vertical, axis=-1), 1.0, atol=1e-14)
    tail = name.rsplit("_", 1)[1]
    assert program.n == {"egorov_2021_table_1": 9, "egorov_2021_table_2": 18}.get(name, int(tail))


@pytest.mark.parametrize("name", NAMES)
def test_the_stand_reaches_every_published_program(name):
    program, stand = find_program(name), TwoAxis()
    settings = program.settings_for(stand)
    assert settings.shape == (program.n, 2)
    assert stand.axes.allows(settings).all()
    np.testing.assert_allclose(stand.stimulus(settings)["specific_force"], vertical_of(program), atol=1e-15)


@pytest.mark.parametrize("name", PLATFORM_NAMES)
def test_the_gimbals_reach_every_program_of_a_platform(name):
    program, stand = find_program(name), PlatformGimbals()
    assert program.name == name
    assert program.title
    assert program.source
    settings = program.settings_for(stand)
    assert settings.shape == (16, 2) == (program.n, 2)
    assert stand.axes.allows(settings).all()
    unseen = Platform().information(stand.stimulus(settings)).inestimable()
    assert len(unseen) == (3 if name == "platform_grid_16" else 0)
    with pytest.raises(CompatibilityError, match="gives gamma_deg, alpha_deg, but stand TwoAxis needs"):
        program.settings_for(TwoAxis())


@pytest.mark.parametrize("name", ["edges_12", "icosahedron_12", "dodecahedron_20", "faces_and_edges_18"])
def test_positions_of_a_solid_are_distinct_and_balanced(name):
    vertical = find_program(name).directions
    assert len(np.unique(np.round(vertical, 9), axis=0)) == len(vertical)
    np.testing.assert_allclose(vertical.sum(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("n", [12, 24, 36])
def test_classical_rotations_are_the_rotations(n):
    classical, rotations = find_program(f"classical_{n}"), find_program(f"rotations_{n}")
    np.testing.assert_array_equal(classical.directions, rotations.directions)
    assert rotations.name in classical.source


def test_right_angles_are_exact():
    assert set(np.unique(find_program("rotations_12").directions)) == {-1.0, 0.0, 1.0}


# ---------------------------------------------------------------- a program and a stand


def test_angles_come_in_the_order_of_the_stand():
    settings = np.array([[0.1, 0.2], [0.3, 0.4]])
    program = Program("mine", "", "", settings=settings, settings_names=("alpha2", "alpha1"))
    np.testing.assert_array_equal(program.settings_for(TwoAxis()), settings[:, ::-1])


def test_a_program_keeps_its_own_angles():
    given = np.array([[0.1, 0.2]])
    program = Program("mine", "", "", settings=given, settings_names=("alpha1", "alpha2"))
    program.settings_for(TwoAxis())[:] = 9.0
    given[:] = 9.0
    np.testing.assert_array_equal(program.settings_for(TwoAxis()), [[0.1, 0.2]])


@pytest.mark.parametrize("name", ["egorov_2021_table_1", "icosahedron_12"])
def test_a_stand_with_other_angles_is_refused(name):
    with pytest.raises(CompatibilityError, match=rf"program {name} .*Gimbals needs .*outer_deg, inner_deg"):
        find_program(name).settings_for(Gimbals())


@pytest.mark.parametrize("names", [("alpha1",), ("alpha1", "alpha3"), ("alpha1", "alpha2", "alpha3")])
def test_angles_must_be_those_of_the_stand(names):
    program = Program("mine", "", "", settings=np.zeros((4, len(names))), settings_names=names)
    with pytest.raises(CompatibilityError, match=f"gives {names[0]}_deg.*TwoAxis needs alpha1_deg, alpha2_deg"):
        program.settings_for(TwoAxis())


@pytest.mark.parametrize("name", ["egorov_2021_table_1", "icosahedron_12"])
def test_what_is_no_angle_is_at_rest_unless_it_is_told(name, tmp_path):
    program, table = find_program(name), RateTable()
    settings = program.settings_for(table)
    np.testing.assert_array_equal(settings, np.column_stack([program.settings_for(TwoAxis()), np.zeros(program.n)]))
    assert table.axes.allows(settings).all()
    assert not RateTable(rate_deg_s=(5, 10)).axes.allows(settings).any()
    assert name in published_for(table)
    read = read_program(written(tmp_path, "alpha2_deg,alpha1_deg\n10,20\n30,40\n"))
    np.testing.assert_allclose(np.degrees(read.settings_for(table)), [[20, 10, 0], [40, 30, 0]])
    told = read_program(written(tmp_path, "rate_deg_s,alpha2_deg,alpha1_deg\n7,10,20\n"))
    np.testing.assert_allclose(np.degrees(told.settings_for(table)), [[20, 10, 7]])
    only = read_program(written(tmp_path, "rate_deg_s,alpha1_deg\n7,10\n"))
    with pytest.raises(CompatibilityError, match="RateTable needs alpha1_deg, alpha2_deg, rate_deg_s"):
        only.settings_for(table)


def test_the_best_published_program_is_found_for_a_table_at_rest():
    problem = Problem(RateTable(), ScalarAccel(), D(), 9)
    best = best_published(problem)
    assert best is not None
    assert best.name == best_published(Problem(TwoAxis(), ScalarAccel(), D(), 9)).name


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({}, "either settings or directions"),
        ({"settings": np.zeros((2, 1)), "settings_names": ("a",), "directions": np.eye(3)}, "either settings or"),
        ({"settings": np.zeros((2, 2)), "settings_names": ("a",)}, r"settings of shape \(2, 2\), expected \(n, 1\)"),
        ({"settings": np.zeros(2), "settings_names": ("a",)}, r"settings of shape \(2,\)"),
        ({"settings": np.zeros((2, 0))}, r"settings of shape \(2, 0\)"),
        ({"settings": np.array([[np.nan]]), "settings_names": ("a",)}, "settings must be finite"),
        ({"directions": np.zeros((0, 3))}, r"directions of shape \(0, 3\), expected \(n, 3\)"),
        ({"directions": np.eye(4)}, r"directions of shape \(4, 4\)"),
        ({"directions": np.diag([1.0, 1.0, 1.2])}, "position 3: a direction of length 1.2, expected 1"),
        ({"directions": np.diag([1.0, np.inf, 1.0])}, "directions must be finite"),
    ],
)
def test_a_program_that_makes_no_sense_is_refused(parts, message):
    with pytest.raises(ProgramError, match=message):
        Program("mine", "", "", **parts)


# ---------------------------------------------------------------- files that can be read


def test_angles_survive_a_file(tmp_path):
    degrees = np.random.default_rng(1).uniform(-180, 360, (18, 2))
    rows = "".join(f"{k + 1},{first!r},{second!r}\n" for k, (first, second) in enumerate(degrees.tolist()))
    program = read_program(written(tmp_path, "position,alpha1_deg,alpha2_deg\n" + rows))
    assert program.settings_names == ("alpha1", "alpha2")
    assert program.n == 18
    np.testing.assert_array_equal(program.settings, np.radians(degrees))


@pytest.mark.parametrize("header", ["eta_x,eta_y,eta_z", "x,y,z"])
@pytest.mark.parametrize("name", NAMES)
def test_cosines_survive_a_file(tmp_path, name, header):
    vertical = vertical_of(find_program(name))
    rows = "".join(",".join(map(repr, row)) + "\n" for row in vertical.tolist())
    program = read_program(written(tmp_path, f"{header}\n{rows}"))
    assert program.settings is None
    np.testing.assert_allclose(program.directions, vertical, rtol=0, atol=1e-15)


def test_columns_come_in_any_order(tmp_path):
    program = read_program(written(tmp_path, "eta_z,position,eta_x,eta_y\n0,1,1,0\n0.8,2,0,0.6\n"))
    np.testing.assert_allclose(program.directions, [[1, 0, 0], [0, 0.6, 0.8]])


def test_angles_count_where_cosines_are_there_too(tmp_path):
    content = "position,alpha1_deg,alpha2_deg,eta_x,eta_y,eta_z\n1,30,40,not,read,\n"
    program = read_program(written(tmp_path, content))
    np.testing.assert_array_equal(program.settings, np.radians([[30.0, 40.0]]))


def test_rounded_cosines_become_unit_vectors(tmp_path):
    program = read_program(written(tmp_path, "x,y,z\n0.577,0.577,0.577\n0.707,-0.707,0\n"))
    np.testing.assert_allclose(np.linalg.norm(program.directions, axis=-1), 1.0, atol=1e-15)


@pytest.mark.parametrize(
    "content",
    [
        ANGLES.encode("utf-8-sig"),
        ANGLES.replace("\n", "\r\n"),
        ANGLES.replace("\n", "\r"),
        ANGLES.removesuffix("\n"),
        ANGLES.replace(",", ";"),
        ANGLES.replace(",", "\t"),
        ANGLES.replace(",", "  , "),
        ANGLES.replace(",", ";")
        .replace("\n", " ;a comment, with a comma\n")
        .replace(";a comment, with a comma", ";label", 1),
        "# a comment; with, marks\n\n" + ANGLES.replace("\n", "\n\n  # another\n") + ",\n \n",
        '"alpha1_deg","alpha2_deg"\n"22.2", "351.7"\n59.4,+7.85e1\n',
        "label,alpha1_deg,comment,alpha2_deg\nä,22.2,,351.7\n,59.4,1e9,78.5\n",
    ],
    ids=["BOM", "CRLF", "CR", "no end", "semicolons", "tabs", "spaces", "labels", "comments", "quotes", "not read"],
)
def test_files_may_look_different(tmp_path, content):
    program = read_program(written(tmp_path, content))
    np.testing.assert_array_equal(program.settings, np.radians([[22.2, 351.7], [59.4, 78.5]]))
    assert program.settings_names == ("alpha1", "alpha2")


def test_a_stand_may_have_any_angles(tmp_path):
    program = read_program(written(tmp_path, "inner_deg,outer_deg\n90,45\n"))
    np.testing.assert_array_equal(program.settings_for(Gimbals()), np.radians([[45.0, 90.0]]))


def test_a_rate_is_in_degrees_per_second(tmp_path):
    program = read_program(written(tmp_path, "rate_deg_s,tilt_deg\n-90,45\n"))
    assert program.columns == ("rate_deg_s", "tilt_deg")
    np.testing.assert_array_equal(program.settings, np.radians([[-90.0, 45.0]]))
    with pytest.raises(CompatibilityError, match="gives rate_deg_s, tilt_deg, but stand Gimbals needs outer_deg"):
        program.settings_for(Gimbals())


def test_a_file_program_says_where_it_is_from(tmp_path):
    path = written(tmp_path, COSINES)
    program = find_program(str(path))
    assert program.name == program.source == str(path)
    assert program.title == "2 positions from program.csv"


# ---------------------------------------------------------------- files that can't


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "program.csv: is empty; a header names angles in degrees, as in 'alpha1_deg,alpha2_deg'"),
        ("\n # only a comment\n\n", "program.csv: is empty"),
        ("alpha1_deg,alpha2_deg\n", "program.csv: a header but no positions"),
        ("1,0,0\n0,1,0\n", "row 1: numbers without a header above them; .*'eta_x,eta_y,eta_z'"),
        ("# alpha1_deg,alpha2_deg\n22.2,351.7\n", "row 2: numbers without a header"),
        ("22,2;351,7\n", "row 1: numbers without a header"),
        ("alpha1,alpha2\n1,2\n", "row 1: unknown column 'alpha1' .did you mean alpha1_deg"),
        ("x,y,Z\n1,0,0\n", "row 1: unknown column 'Z' .did you mean z"),
        ("eta_x,eta_y,etaz\n1,0,0\n", "row 1: unknown column 'etaz' .did you mean eta_z"),
        (
            "alpha1_deg,alpha2_deg,temperature\n1,2,3\n",
            "unknown column 'temperature'; a header names .*comment, fixed are",
        ),
        ("alpha1_deg alpha2_deg\n1 2\n", "unknown column 'alpha1_deg alpha2_deg'"),
        ("_deg\n1\n", "unknown column '_deg'"),
        ("eta_x,eta_y\n1,0\n", "row 1: no column eta_z; direction cosines are eta_x, eta_y, eta_z"),
        ("position,comment\n1,first\n", "row 1: neither angles nor direction cosines"),
        ("x,y,z,eta_x,eta_y,eta_z\n1,0,0,1,0,0\n", "row 1: both eta_x, eta_y, eta_z and x, y, z; give one"),
        ("alpha1_deg,alpha1_deg\n1,2\n", "row 1: column 'alpha1_deg' is there twice"),
        ("alpha1_deg,alpha2_deg,\n1,2,\n", "row 1: column 3 has no name"),
        ("alpha1_deg,alpha2_deg\n1,2\n3\n", "row 3: number of fields 1, expected 2 as in the header, alpha1_deg, alp"),
        ("alpha1_deg,alpha2_deg\n1,2\n3,4,5\n", "row 3: number of fields 3, expected 2"),
        ("alpha1_deg,alpha2_deg\n22,2,351,7\n", "row 2: number of fields 4, expected 2 .*decimal points, not commas"),
        ("alpha1_deg;alpha2_deg\n1;351,7\n", "row 2, column alpha2_deg: '351,7' has a decimal comma; write 351.7"),
        ("# note\n\nalpha1_deg,alpha2_deg\n1,2\n3,x4\n", "row 5, column alpha2_deg: 'x4' is not a finite number"),
        ("alpha1_deg,alpha2_deg\n1,\n", "row 2, column alpha2_deg: empty, expected a number"),
        ("alpha1_deg,alpha2_deg\nnan,2\n", "row 2, column alpha1_deg: 'nan' is not a finite number"),
        ("alpha1_deg,alpha2_deg\n1,-inf\n", "row 2, column alpha2_deg: '-inf' is not a finite number"),
        ("alpha1_deg,alpha2_deg\n1,1e999\n", "row 2, column alpha2_deg: '1e999' is not a finite number"),
        ("alpha1_deg,alpha2_deg\n1_0,2\n", "row 2, column alpha1_deg: '1_0' is not a finite number"),
        ("alpha1_deg,alpha2_deg\n22.2°,2\n", "row 2, column alpha1_deg: '22.2°' is not a finite number"),
        (
            "x,y,z\n1,0,0\n\n1,1,0\n",
            "row 4, columns x, y, z: the length of the vector is 1.41421; .*must have length 1",
        ),
        ("x,y,z\n0,0,0\n", "row 2, columns x, y, z: the length of the vector is 0;"),
        ("x,y,z\n1.0011,0,0\n", "the length of the vector is 1.0011"),
        ("x,y,z\n1e200,1e308,1e308\n", "the length of the vector is "),
        ('alpha1_deg,alpha2_deg\n1,"2\n3,4\n', "unexpected end of data; write plain numbers without quotes"),
        (
            b"alpha1_deg,alpha2_deg,comment\n1,2,\xe4\n",
            "program.csv: byte 35 is not UTF-8 text; save it as CSV in UTF-8",
        ),
        ("alpha1_deg,alpha2_deg\n1,2\n".encode("utf-16"), "byte 1 is not UTF-8 text"),
        (b"\x00\x01\x02", "unknown column"),
        ("alpha1_deg\n" + "1" * 200_000, "row 2: field larger than field limit"),
    ],
)
def test_a_bad_file_is_refused_with_a_reason(tmp_path, content, message):
    with pytest.raises(ProgramError, match=message) as caught:
        read_program(written(tmp_path, content))
    assert str(caught.value).startswith(str(tmp_path))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400 + len(str(tmp_path))


def test_too_many_positions_are_refused(tmp_path):
    with pytest.raises(ProgramError, match="more than 1,000,000 positions"):
        read_program(written(tmp_path, ANGLES + "1,2\n" * 1_000_000))


def test_too_large_a_file_is_refused_unread(tmp_path):
    path = written(tmp_path, ANGLES)
    os.truncate(path, 2**40)  # sparse
    with pytest.raises(ProgramError, match="1048576 MB is too large; a program has 1,000,000 positions or fewer"):
        read_program(path)


def test_a_directory_is_refused(tmp_path):
    with pytest.raises(ProgramError, match=r"is a directory; give a file, such as .*program\.csv"):
        find_program(str(tmp_path))


def test_a_device_is_refused():
    with pytest.raises(ProgramError, match="/dev/null: is not an ordinary file"):
        find_program("/dev/null")


def test_a_file_without_permission_is_refused(tmp_path, monkeypatch):
    def refuse(path, *_):
        raise PermissionError(13, "Permission denied", str(path))

    path = written(tmp_path, ANGLES)
    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(ProgramError, match=r"program\.csv: can't be read: Permission denied"):
        read_program(path)


@pytest.mark.parametrize("path", ["a" * 300 + ".csv", "a\0b.csv"], ids=["long", "NUL"])
def test_an_impossible_path_is_refused(path):
    with pytest.raises(ProgramError, match="can't be read: "):
        find_program(path)


# ---------------------------------------------------------------- by name or path


@pytest.mark.parametrize(
    ("asked", "meant"),
    [
        ("icosahedron", "icosahedron_12"),
        ("Icosahedron_12", "icosahedron_12"),
        ("icosaedron_12", "icosahedron_12"),
        ("egorov_2021_table1", "egorov_2021_table_1"),
        ("classical12", "classical_12"),
        ("table_2", "egorov_2021_table_2"),
    ],
)
def test_a_misspelt_name_gets_a_suggestion(asked, meant):
    with pytest.raises(ProgramError, match=f"no program '{asked}' .did you mean .*{meant}.*; the programs are egorov"):
        find_program(asked)


@pytest.mark.parametrize("asked", ["qqqqq", "", " "])
def test_an_unknown_name_gets_the_list(asked):
    with pytest.raises(
        ProgramError, match=f"no program '{asked}'; the programs are .*classical_36, .*, or give the path"
    ):
        find_program(asked)


@pytest.mark.parametrize("path", ["missing.csv", "MISSING.CSV", "folder/missing", "/folder/missing.txt", "~/no such"])
def test_a_missing_file_is_called_a_file(path):
    with pytest.raises(ProgramError, match=r"^no file "):
        find_program(path)


def test_a_missing_file_says_where_it_was_looked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ProgramError, match=rf"^no file missing\.csv in {tmp_path}$"):
        find_program("missing.csv")


def test_a_file_is_found_without_a_suffix_and_from_home(tmp_path, monkeypatch):
    written(tmp_path, COSINES, "mine")
    monkeypatch.chdir(tmp_path)
    assert find_program("mine").n == 2
    monkeypatch.setenv("HOME", str(tmp_path))
    assert find_program("~/mine").n == 2


def test_errors_are_of_acalx():
    assert issubclass(ProgramError, AcalxError)
