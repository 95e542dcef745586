"""Simulated calibrations: what comes out is what theory predicts, and the command as a user starts it."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import parts
from acalx.errors import ArgumentError, CompatibilityError
from acalx.estimation import Bisquare, Estimator, Iterated, Linear, SingularError
from acalx.models import Magnitude, Platform, Projection, ScalarAccel, VectorAccel
from acalx.programs import find_program
from acalx.quantities.parameter import parameter_groups
from acalx.recording.parts import described
from acalx.simulation import Campaign, ErrorSources, Outcome, default_estimator, run_campaign, simulate
from acalx.stands import PlatformGimbals, TwoAxis
from command import Outcome as Ended
from command import assert_refused, run, together

MODEL, STAND = ScalarAccel(), parts.FULL
PAPER = ErrorSources()
COARSE = replace(PAPER, setting_rad=6e-3)
EXACT = ErrorSources(noise=1e-12, setting_rad=0.0, gravity=0.0)
ORIENTED = Linear(comparison=Projection())


def campaign(program: str, sources: ErrorSources = PAPER, seed: int = 0, shuffled: bool = False) -> Campaign:
    return Campaign(MODEL, STAND, find_program(program).settings_for(STAND), sources, seed, shuffled)


def simulated(
    program: str = "egorov_2021_table_2",
    sources: ErrorSources = PAPER,
    estimator: Estimator | None = None,
    trials: int = 2000,
) -> Outcome:
    return run_campaign(campaign(program, sources), estimator or Iterated(), trials, program)


def test_trials_do_not_depend_on_their_number_or_on_the_chunk() -> None:
    whole = campaign("icosahedron_12").trials(0, 2500)
    part = campaign("icosahedron_12").trials(1024, 1700)
    np.testing.assert_array_equal(whole.parameters[1024:1700], part.parameters)
    np.testing.assert_array_equal(whole.readings[1024:1700], part.readings)
    outcomes = [
        run_campaign(campaign("icosahedron_12"), Iterated(), 5000, "", chunk=chunk) for chunk in (1024, 2048, 10**6)
    ]
    for other in outcomes[1:]:
        np.testing.assert_allclose(other.covariance, outcomes[0].covariance, rtol=1e-12, atol=1e-24)
        np.testing.assert_allclose(other.bias, outcomes[0].bias, rtol=0, atol=1e-18)
    again = run_campaign(campaign("icosahedron_12"), Iterated(), 5000)
    np.testing.assert_array_equal(again.covariance, outcomes[2].covariance)
    assert (run_campaign(campaign("icosahedron_12", seed=1), Iterated(), 5000).covariance != again.covariance).all()


def test_programs_have_common_sensors_and_noise() -> None:
    quiet = ErrorSources(setting_rad=0.0, gravity=0.0)
    few, many = campaign("axes_and_edges_9", quiet), campaign("faces_and_edges_18", quiet)
    first, second = few.trials(0, 300), many.trials(0, 300)
    np.testing.assert_array_equal(first.parameters, second.parameters)
    noises = [t.readings - MODEL.readings(t.parameters, c.nominal) for t, c in ((first, few), (second, many))]
    np.testing.assert_allclose(noises[0], noises[1][:, :9], atol=1e-15)


def test_without_noise_only_the_iterated_estimate_is_right() -> None:
    sources = replace(EXACT, parameters={"bias": 0.05, "scale": 0.05, "nonorthogonality": 0.05})
    iterated = simulated(sources=sources, trials=500)
    linear = simulated(sources=sources, estimator=Linear(), trials=500)
    assert np.abs(iterated.covariance).max() < 1e-22
    assert (linear.deviations > 1e-3).all()


@pytest.mark.parametrize("estimator", [Iterated(), Linear(), ORIENTED], ids=repr)
def test_errors_of_estimates_are_as_predicted(estimator: Estimator) -> None:
    outcome = simulated(estimator=estimator, trials=20000)
    assert outcome.agrees
    assert outcome.moments.failed == 0
    for entry in outcome.groups.values():
        assert entry["s"] == pytest.approx(entry["theta"], rel=0.02)
        assert entry["inequality"] == pytest.approx(entry["inequality_predicted"], abs=0.03)
    assert ((outcome.coverage > 0.94) & (outcome.coverage < 0.96)).all()


@pytest.mark.parametrize("program", ["egorov_2021_table_1", "egorov_2021_table_2"])
@pytest.mark.parametrize("estimator", [Iterated(), ORIENTED], ids=["iterated", "oriented"])
def test_intervals_cover_as_they_should(program: str, estimator: Estimator) -> None:
    outcome = simulated(program, estimator=estimator)
    assert 0.935 <= outcome.coverage.mean() <= 0.965
    assert ((outcome.coverage >= 0.93) & (outcome.coverage <= 0.97)).all()


def test_verdicts_are_right_as_often_as_they_say() -> None:
    settings = find_program("icosahedron_12").settings_for(STAND)
    outcomes = [run_campaign(Campaign(MODEL, STAND, settings, PAPER, seed), Linear(), 300) for seed in range(120)]
    assert 0.88 <= np.mean([outcome.agrees for outcome in outcomes]) <= 0.99
    for name in ("bias_probability", "scatter_probability"):  # uniform
        values = np.sort([getattr(outcome, name) for outcome in outcomes])
        assert np.abs(values - np.linspace(0, 1, len(values))).max() < 0.15
    within = np.mean([outcome.as_predicted for outcome in outcomes])
    assert within == pytest.approx(0.95, abs=0.02)


def test_a_coarse_stand_leaves_the_magnitude_alone() -> None:
    fine, coarse = simulated(trials=20000), simulated(sources=COARSE, trials=20000)
    assert coarse.agrees
    np.testing.assert_allclose(coarse.deviations, fine.deviations, rtol=2e-3)


def test_a_coarse_stand_biases_the_oriented_residual() -> None:
    """W . eta falls short by half the square of the angle between: all three scale factors seem smaller."""
    changing = simulated(sources=COARSE, estimator=ORIENTED, trials=5000)
    assert not changing.agrees
    np.testing.assert_allclose(changing.bias[3:6], -(COARSE.setting_rad**2), rtol=0.05)
    assert (changing.deviations > 2 * changing.predicted).all()
    repeated = simulated(sources=replace(COARSE, setting_repeats=True), estimator=ORIENTED, trials=5000)
    np.testing.assert_allclose(repeated.deviations, repeated.predicted, rtol=0.06)
    assert repeated.bias_probability < 1e-6


def test_measured_attitudes_count_instead_of_set_ones() -> None:
    measured = replace(COARSE, knowledge_rad=1e-4)
    assert simulated(sources=measured, estimator=ORIENTED, trials=5000).agrees


def test_gravity_that_is_not_known_goes_into_the_scale() -> None:
    outcome = simulated(sources=replace(EXACT, gravity=1e-5), trials=2000)
    np.testing.assert_allclose(outcome.deviations[3:6], 1e-5, rtol=0.06)
    assert (outcome.deviations[:3] < 1e-8).all()


def test_drift_favours_some_parameters_in_order_and_none_shuffled() -> None:
    drifting = replace(EXACT, drift=1e-4, drift_positions=5.0)
    ordered = run_campaign(campaign("faces_and_edges_18", drifting), Iterated(), 4000)
    shuffled = run_campaign(campaign("faces_and_edges_18", drifting, shuffled=True), Iterated(), 4000)
    for group, entry in ordered.groups.items():
        assert entry["inequality"] > 0.3
        assert shuffled.groups[group]["inequality"] < 0.1


def test_few_trials_and_failures_are_counted() -> None:
    outcome = simulated(trials=5)
    assert np.isnan(outcome.scatter_probability)
    assert not outcome.agrees
    wild = replace(PAPER, parameters={"bias": 3.0, "scale": 3.0, "nonorthogonality": 3.0})
    outcome = simulated(sources=wild, estimator=Iterated(iterations=20), trials=500)
    assert outcome.moments.failed > 0
    assert outcome.trials + outcome.moments.failed == 500


def test_limits_are_those_of_textbooks() -> None:
    from scipy import stats

    outcome = simulated(trials=100)
    spread = outcome.covariance[0, 0]
    low, high = np.sqrt(99 * spread / stats.chi2.ppf([0.975, 0.025], 99))
    np.testing.assert_allclose(outcome.deviation_limits[0], [low, high], rtol=1e-12)
    interval = stats.t.interval(0.95, 99, outcome.bias[0], np.sqrt(spread / 100))
    np.testing.assert_allclose(outcome.bias_limits[0], interval, rtol=1e-10)


# ---------------------------------------------------------------- other models

GYROS = {
    "gyro_bias": (0.01, 0.1),
    "gyro_first_order": (0.05, 0.5),
    "gyro_second_order": (0.005, 0.05),
    "gyro_misalignment": (7.29e-4, 4.375e-3),
}


def on_the_platform(**options: object) -> Outcome:
    platform = Platform(sensors=["gyros"], gyro_noise_deg_h=0.001)
    stand = PlatformGimbals()
    sources = ErrorSources(GYROS, noise=1.0, setting_rad=0.0, **options)  # type: ignore[arg-type]
    settings = find_program("platform_reference_16").settings_for(stand)
    return run_campaign(Campaign(platform, stand, settings, sources, 0), default_estimator(platform), 1000)


def test_linear_models_are_as_predicted_where_installation_errors_are_known() -> None:
    plain = on_the_platform()
    known = on_the_platform(installation_arcsec=(10, 1))
    unknown = on_the_platform(installation_arcsec=(600, 60), installation_known=False)
    assert plain.agrees
    assert known.agrees
    assert not unknown.agrees
    weakest = plain.information.parameters[int(plain.relative_errors.argmax())]
    assert weakest.group == "gyro_misalignment"


def test_robust_losses_take_outputs_too() -> None:
    model = VectorAccel(noise_g=1e-5)
    sources = ErrorSources({"bias": 1e-4, "scale": 1e-4, "misalignment": 1e-4}, noise=1.0, setting_rad=0.0)
    settings = find_program("icosahedron_12").settings_for(STAND)
    linear, robust = (
        run_campaign(Campaign(model, STAND, settings, sources, 0), Linear(loss=loss), 1000)
        for loss in (Linear().loss, Bisquare())
    )
    assert linear.agrees
    assert (robust.deviations > linear.deviations).mean() > 0.8


def test_axes_off_by_nothing_change_nothing() -> None:
    for stand in (PlatformGimbals(azimuth_deg=30), STAND):
        settings = stand.axes.random(np.random.default_rng(0), (7,))
        exact = dict(stand.stimulus(settings).items())
        zero = np.zeros((5, 1, len(stand.axis_errors)))
        for name, felt in stand.misaligned(settings, zero).items():
            np.testing.assert_allclose(np.broadcast_to(felt, (5, 7, 3))[3], exact[name], atol=1e-15)


def test_gimbals_with_their_axes_off_keep_lengths_and_the_angle_between() -> None:
    stand = PlatformGimbals()
    rng = np.random.default_rng(0)
    felt = stand.misaligned(stand.axes.random(rng, (7,)), 0.1 * rng.standard_normal((5, 1, 3)))
    assert "specific_force" in felt
    assert "angular_rate" in felt
    np.testing.assert_allclose(np.linalg.norm(felt["specific_force"], axis=-1), 1.0, atol=1e-14)
    between = (felt["specific_force"] * felt["angular_rate"]).sum(axis=-1)
    np.testing.assert_allclose(between, np.sin(np.radians(34.25)), atol=1e-14)


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("options", "phrase"),
    [
        ({"noise": -1e-5}, "noise=-1e-05"),
        ({"noise": 0.0}, "must be positive"),
        ({"setting_rad": "much"}, "setting_rad='much'"),
        ({"knowledge_rad": -1.0}, "knowledge_rad=-1.0"),
        ({"parameters": {"bias": -1e-4}}, "parameters={'bias': -0.0001}"),
        ({"parameters": {"bias": [2.0, 1.0]}}, "least and the largest"),
        ({"parameters": 3}, "by group"),
        ({"installation_arcsec": [10]}, "mean and the standard deviation"),
        ({"installation_known": 1}, "true or false"),
        ({"drift_positions": 0}, "positive number of positions"),
    ],
)
def test_bad_errors_are_refused(options: dict[str, object], phrase: str) -> None:
    with pytest.raises(ArgumentError, match=phrase.replace(".", r"\.")):
        ErrorSources(**options)  # type: ignore[arg-type]


USUAL = ErrorSources(dict.fromkeys(parameter_groups(Platform().parameters), 0.001), noise=1.0)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(CompatibilityError, match="Platform says itself what of its readings is compared"):
        simulate("platform_reference_16", PlatformGimbals(), Platform(), USUAL, estimator=Linear(Projection()))
    settings = find_program("icosahedron_12").settings_for(STAND)
    vector = Campaign(
        VectorAccel(), STAND, settings, ErrorSources({"bias": 1, "scale": 1, "misalignment": 1}, noise=1.0), 0
    )
    with pytest.raises(CompatibilityError, match="AccelTriad has no magnitude of the magnetic field"):
        run_campaign(vector, Iterated(comparison=Magnitude("magnetic_field")), 100)
    with pytest.raises(CompatibilityError, match="group nonorthogonality that model VectorAccel lacks"):
        Campaign(VectorAccel(), STAND, settings, PAPER, 0)
    with pytest.raises(CompatibilityError, match="does not say what its axes"):
        campaign("icosahedron_12", replace(PAPER, installation_arcsec=(10, 1)))
    with pytest.raises(SingularError, match="can't see: nonorthogonality_xy"):
        simulated("classical_12")


# ---------------------------------------------------------------- the function


def test_names_programs_and_settings_are_the_same_to_it() -> None:
    name = "icosahedron_12"
    program = find_program(name)
    by_name = simulate(name, STAND, MODEL, PAPER, trials=200)
    others = [simulate(given, STAND, MODEL, PAPER, trials=200) for given in (program, program.settings_for(STAND))]
    for other, called in zip(others, (name, "program"), strict=True):
        np.testing.assert_array_equal(other.outcomes[called].covariance, by_name.outcomes[name].covariance)
    both = simulate([name, program.settings_for(STAND)], STAND, MODEL, PAPER, trials=200)
    assert list(both.outcomes) == [name, "program 2"]
    assert isinstance(by_name.estimator, Iterated)
    assert by_name.trials == by_name.outcomes[name].trials == 200


@pytest.mark.parametrize(
    ("programs", "options", "message"),
    [
        ([], {}, r"program=\[\]: give one program or more, as in program=\['icosahedron_12', 'mine.csv'\]"),
        (["icosahedron_12", find_program("icosahedron_12")], {}, "icosahedron_12 is there twice"),
        ("icosahedron_12", {"seed": -1}, "seed=-1"),
        ("icosahedron_12", {"trials": "many"}, "trials='many': give a whole number of trials from 2 to 100,000,000"),
        ("icosahedron_12", {"order": "alphabetic"}, "order='alphabetic'"),
        ("icosahedron_12", {"confidence": 95}, "confidence=95"),
    ],
)
def test_what_it_is_not_given_right_is_refused(programs: list[str], options: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        simulate(programs, STAND, MODEL, PAPER, **options)  # type: ignore[arg-type]
    with pytest.raises(CompatibilityError, match="compare the readings themselves, by Outputs"):
        simulate("icosahedron_12", STAND, MODEL, PAPER, estimator=Iterated(Magnitude("magnetic_field")))


# ---------------------------------------------------------------- the command

NINE = "program=[egorov_2021_table_1,axes_and_vertices_9]"
PLATFORM = ("model=platform", "stand=platform_gimbals", "errors=platform")
COMMANDS = {
    "two": (NINE, "trials=2000", "seed=1"),
    "again": (NINE, "trials=2000", "seed=1", "figures=false"),
    "platform": (*PLATFORM, "program=platform_reference_16", "trials=300", "model.gyro_noise_deg_h=0.001"),
    "singular": ("program=classical_6",),
}
REFUSED = [
    ((), ("which program", "icosahedron_12")),
    (("program=[]",), ("program=[]",)),
    (("program=icosahedron_21",), ("icosahedron_21", "did you mean icosahedron_12")),
    (("program=[icosahedron_12,icosahedron_12]",), ("icosahedron_12 is there twice",)),
    (("program=icosahedron_12", "trials=0"), ("trials=0", "such as 20000")),
    (("program=icosahedron_12", "trials=many"), ("trials=many", "such as 20000")),
    (("program=icosahedron_12", "seed=-1"), ("seed=-1",)),
    (("program=icosahedron_12", "confidence=95"), ("confidence=95", "such as 0.95")),
    (("program=icosahedron_12", "errors.noise=-1"), ("noise=-1", "0 or more")),
    (("program=icosahedron_12", "errors=platform"), ("gyro_bias", "ScalarAccel", "errors=NAME")),
    (("program=platform_reference_16", *PLATFORM, "estimator=oriented"), ("Platform says itself what", "comparison")),
    (("program=icosahedron_12", "errors.nois=1"), ("errors.nois", "did you mean noise?")),
]


def simulate_command(folder: Path, *arguments: str, into: str) -> Ended:
    return run(folder, *arguments, into=into, entry="simulate")


@pytest.fixture(scope="module")
def commands(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Ended]:
    folder = tmp_path_factory.mktemp("simulate")
    calls = [partial(simulate_command, folder, *arguments, into=name) for name, arguments in COMMANDS.items()]
    return dict(zip(COMMANDS, together(calls), strict=True))


def test_the_command_records_and_shows(commands: dict[str, Ended]) -> None:
    two = commands["two"]
    assert two.status == 0, two.err
    assert two.err == ""
    assert two.files == {"simulation.json", "simulation.csv", "simulation.svg", "simulation.png", "result.json"}
    assert two.result["status"] == "ok"
    assert two.result["trials"] == 2000
    assert two.result["agrees"] == {"egorov_2021_table_1": True, "axes_and_vertices_9": True}
    assert two.metrics["axes_and_vertices_9"]["nonorthogonality"]["theta"] == pytest.approx(2.7386, abs=1e-4)
    rows = two.rows("simulation.csv")
    assert len(rows) == 18
    for row in rows:
        assert float(row["standard_deviation"]) == pytest.approx(float(row["predicted"]), rel=0.06)
        assert float(row["standard_deviation_low"]) < float(row["standard_deviation_high"])
    assert "agrees with theory" in two.out
    assert commands["again"].text("simulation.csv") == two.text("simulation.csv")


def test_the_function_gives_what_the_command_gives(
    commands: dict[str, Ended], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names = ["egorov_2021_table_1", "axes_and_vertices_9"]
    simulated = simulate(names, TwoAxis(), MODEL, ErrorSources(), trials=2000, seed=1)
    two = commands["two"]
    assert json.loads(two.text("simulation.json"))["programs"] == [one.entries() for one in simulated.outcomes.values()]
    assert two.result["message"] == simulated.summary()
    assert two.result["agrees"] == simulated.agrees
    assert two.result["visits"] == simulated.visits
    for name in ("model", "stand", "errors", "estimator"):
        assert two.result[name] == described(getattr(simulated, name))
    assert two.result["estimator"]["comparison"] is None
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr() == ("", "")


def test_the_command_takes_other_models(commands: dict[str, Ended]) -> None:
    platform = commands["platform"]
    assert platform.status == 0, platform.err
    assert len(platform.rows("simulation.csv")) == 36


def test_the_command_names_what_a_program_cannot_see(commands: dict[str, Ended]) -> None:
    singular = commands["singular"]
    assert singular.status == 1
    assert singular.result["status"] == "singular"
    assert singular.result["inestimable"] == [f"nonorthogonality_{pair}" for pair in ("xy", "xz", "zy")]
    assert singular.files == {"result.json"}


@pytest.fixture(scope="module")
def refused(tmp_path_factory: pytest.TempPathFactory) -> list[Ended]:
    folder = tmp_path_factory.mktemp("refused")
    return together(
        partial(simulate_command, folder, *arguments, into=str(k)) for k, (arguments, _) in enumerate(REFUSED)
    )


@pytest.mark.parametrize("k", range(len(REFUSED)), ids=[" ".join(arguments) or "nothing" for arguments, _ in REFUSED])
def test_bad_input_gets_one_plain_message(refused: list[Ended], k: int) -> None:
    assert_refused(refused[k], *REFUSED[k][1])
    assert refused[k].files == {"result.json"}
