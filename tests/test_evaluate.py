"""Figures of a program that someone uses already: each command is started for real."""

from functools import partial

import numpy as np
import pytest

from command import SCRIPT, Outcome, assert_refused, evaluate, execute, together

FILES = {
    # the program of Table 1, as angles and as cosines, both typed by hand
    "angles.csv": (
        "position,alpha1_deg,alpha2_deg\n"
        "1,22.2,351.7\n2,59.4,78.5\n3,144.6,9.5\n4,151.3,93.7\n5,253.1,292.8\n6,323.4,312.3\n7,333,221.8\n"
        "8,347.5,53.1\n9,355.7,128.4\n"
    ),
    "cosines.csv": "x,y,z\n"
    + "".join(
        f"{np.sin(a):.9f},{np.cos(a) * np.sin(b):.9f},{np.cos(a) * np.cos(b):.9f}\n"
        for a, b in np.radians(
            [
                (22.2, 351.7),
                (59.4, 78.5),
                (144.6, 9.5),
                (151.3, 93.7),
                (253.1, 292.8),
                (323.4, 312.3),
                (333, 221.8),
                (347.5, 53.1),
                (355.7, 128.4),
            ]
        )
    ),
    # all in the plane z = 0
    "plane.csv": "alpha1_deg,alpha2_deg\n" + "".join(f"{30 * k},90\n" for k in range(12)),
    "one.csv": "x,y,z\n0,0,1\n",
    "empty.csv": "",
    "header.csv": "alpha1_deg,alpha2_deg\n",
    "word.csv": "alpha1_deg,alpha2_deg\n1,2\n3,west\n",
    "nan.csv": "alpha1_deg,alpha2_deg\n1,2\nnan,3\n",
    "short.csv": "alpha1_deg,alpha2_deg\n1\n",
    "column.csv": "alpha1_deg,alpha3_deg\n1,2\n",
    "length.csv": "eta_x,eta_y,eta_z\n0,0,1\n1,1,0\n",
    "no_header.csv": "1,2\n3,4\n",
}
COMMANDS = {
    "name": ("program=egorov_2021_table_1",),
    "angles": ("program=angles.csv", "figures=false"),
    "cosines": ("program=cosines.csv", "figures=false", "criterion=d"),
    "outside": ("program=angles.csv", "figures=false", "stand.alpha2_deg=[-90,90]"),
    "best": ("program=icosahedron_12", "figures=false"),
    "classical": ("program=classical_6",),
    "plane": ("program=plane.csv",),
    "one": ("program=one.csv",),
}
REFUSED = [
    ((), ("which program", "program=FILE.csv", "icosahedron_12")),
    (("program=icosahedrn_12",), ("icosahedrn_12", "did you mean icosahedron_12")),
    (("program=dodecahedron",), ("dodecahedron", "did you mean dodecahedron_20")),
    (("program=nowhere.csv",), ("no file nowhere.csv",)),
    (("program=.",), ("is a directory", "program.csv")),
    (("program=empty.csv",), ("empty.csv", "is empty", "alpha1_deg,alpha2_deg")),
    (("program=header.csv",), ("header.csv", "no positions")),
    (("program=word.csv",), ("word.csv, row 3, column alpha2_deg", "'west'", "22.2")),
    (("program=nan.csv",), ("nan.csv, row 3, column alpha1_deg", "'nan'", "finite")),
    (("program=short.csv",), ("short.csv, row 2", "expected 2")),
    (("program=column.csv",), ("alpha3_deg", "alpha1_deg, alpha2_deg")),
    (("program=length.csv",), ("length.csv, row 3", "1.41421", "length 1")),
    (("program=no_header.csv",), ("no_header.csv", "header")),
    (("progam=angles.csv",), ("progam", "did you mean program?")),
    (
        ("program=angles.csv", "n=9"),
        ("n: there is no such option", "criterion, dwell_s, figures, model, program, stand"),
    ),
    (("program=angles.csv", "optimizer=de"), ("optimizer: there is no such option",)),
    (("program=angles.csv", "criterion=bogus"), ("criterion=bogus", "d_fair")),
    (("program=angles.csv", "stand.alpha1_deg=[9,1]"), ("stand.alpha1_deg=[9,1]", "lower bound")),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("evaluate")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture(scope="module")
def evaluated(folder):
    calls = [partial(evaluate, folder, *arguments, into=name) for name, arguments in COMMANDS.items()]
    return dict(zip(COMMANDS, together(calls), strict=True))


def test_a_published_program_has_the_printed_figures(evaluated):
    outcome = evaluated["name"]
    assert outcome.status == 0, outcome.err
    assert outcome.err == ""
    assert outcome.metrics["D"] == pytest.approx(0.0489, abs=5e-5)
    assert [round(value, 2) for value in outcome.metrics["theta"].values()] == [0.59, 0.93, 1.35]
    assert [round(100 * value, 2) for value in outcome.metrics["inequality"].values()] == [2.78, 7.90, 13.16]


def test_a_published_program_is_recorded(evaluated):
    outcome = evaluated["name"]
    keys = {"status", "n", "seed", "metrics", "loss", "evaluations", "seconds", "message", "versions", "overrides"}
    assert keys | {"program"} <= set(outcome.result)
    assert outcome.result["status"] == "ok"
    assert outcome.result["program"] == "egorov_2021_table_1"
    assert outcome.result["n"] == 9
    parts = outcome.result["seconds_by_part"]
    assert sorted(parts) == ["certificate", "drawing"]
    assert 0 < sum(parts.values()) < outcome.result["seconds"]
    figures = {f"{name}.{kind}" for name in ("positions", "entries") for kind in ("svg", "png")}
    assert outcome.files == figures | {"program.csv", "result.json"}
    assert [row["alpha1_deg"] for row in outcome.rows()][:3] == ["22.2", "59.4", "144.6"]
    floored = [max(value, 5e-4) for value in outcome.metrics["inequality"].values()]
    loss = np.log(outcome.metrics["D"]) + 0.1 * np.log(floored).sum()
    assert outcome.result["loss"] == pytest.approx(loss, abs=1e-9)


def test_angles_and_cosines_give_the_same_figures(evaluated):
    by_name, by_angles, by_cosines = (evaluated[name] for name in ("name", "angles", "cosines"))
    assert by_angles.metrics == by_name.metrics
    assert by_cosines.result["loss"] == pytest.approx(np.log(by_cosines.metrics["D"]), abs=1e-12)
    for name in ("D", "A", "E", "condition_number"):
        assert by_cosines.metrics[name] == pytest.approx(by_name.metrics[name], rel=1e-6)
    for name in ("theta", "inequality", "standard_deviations"):
        assert by_cosines.metrics[name] == pytest.approx(by_name.metrics[name], abs=1e-6)
    angles = [[float(row[name]) for name in ("alpha1_deg", "alpha2_deg")] for row in by_angles.rows()]
    axes = [[float(row[f"eta_{axis}"]) for axis in "xyz"] for row in by_cosines.rows()]
    first, second = np.radians(angles).T
    expected = np.stack([np.sin(first), np.cos(first) * np.sin(second), np.cos(first) * np.cos(second)], axis=-1)
    np.testing.assert_allclose(axes, expected, atol=1e-8)


def test_terminal_shows_the_figures_beside_the_best_published_program(evaluated):
    out = evaluated["angles"].out
    assert "best published: " in out
    assert "inequality nonorthogonality" in out
    assert "standard deviation" in out
    assert "nonorthogonality_zy" in out
    assert "best published" not in evaluated["best"].out  # it is that itself


def test_positions_that_the_stand_cannot_take_are_named(evaluated):
    outcome = evaluated["outside"]
    assert outcome.status == 0
    outside = [k + 1 for k, a in enumerate([351.7, 78.5, 9.5, 93.7, 292.8, 312.3, 221.8, 53.1, 128.4]) if 90 < a < 270]
    assert outcome.result["outside"] == outside
    assert f"can't take position {', '.join(map(str, outside))}" in outcome.out
    assert evaluated["angles"].result["outside"] == []


@pytest.mark.parametrize(
    ("name", "unseen"),
    [
        ("classical", ["nonorthogonality_xy", "nonorthogonality_xz", "nonorthogonality_zy"]),
        ("plane", ["bias_z", "scale_z", "nonorthogonality_xz", "nonorthogonality_zy"]),
        ("one", None),
    ],
)
def test_a_singular_program_is_answered_with_what_it_cannot_see(evaluated, name, unseen):
    outcome = evaluated[name]
    assert outcome.status == 1
    assert outcome.err == f"acalx: {outcome.result['message']}\n"
    assert "can't estimate all the parameters; they can't see: " in outcome.err
    assert outcome.result["status"] == "singular"
    assert outcome.result["metrics"] is None
    assert outcome.files == {"program.csv", "result.json"}
    if unseen is None:  # one position sees one combination of nine
        assert len(outcome.result["inestimable"]) == 8
    else:
        assert sorted(outcome.result["inestimable"]) == sorted(unseen)
    for combination in outcome.result["inestimable"]:
        assert combination in outcome.err


@pytest.fixture(scope="module")
def refused(folder) -> list[Outcome]:
    return together(
        partial(evaluate, folder, *arguments, into=f"refused_{k}") for k, (arguments, _) in enumerate(REFUSED)
    )


@pytest.mark.parametrize("k", range(len(REFUSED)), ids=[" ".join(arguments) or "nothing" for arguments, _ in REFUSED])
def test_bad_input_gets_one_plain_message(refused, k):
    assert_refused(refused[k], *REFUSED[k][1])


def test_several_programs_in_a_sweep(folder):
    command = ("evaluate", "-m", "program=icosahedron_12,classical_6,nowhere.csv,edges_12", "figures=false")
    outcome = execute(folder, SCRIPT, *command, "hydra.sweep.dir=sweep")
    assert outcome.status == 1
    assert "Traceback" not in outcome.err
    statuses = [Outcome(0, "", "", folder / "sweep" / str(k)).result["status"] for k in range(4)]
    assert statuses == ["ok", "singular", "failed", "ok"]
    table = [line.split()[:2] for line in outcome.out.splitlines()[-5:-1]]
    assert table == [[str(k), status] for k, status in enumerate(statuses)]
