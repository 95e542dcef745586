from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parts
from acalx.errors import ArgumentError, CompatibilityError
from acalx.quantities.units import DEGREE_PER_SECOND
from acalx.stands import Setting, Stand, TwoAxis
from acalx.testing import check_stand

NAN, INF = math.nan, math.inf


@pytest.mark.parametrize("stand", [*parts.STANDS, *parts.FURTHER_STANDS], ids=repr)
@pytest.mark.parametrize("seed", range(3))
def test_contract(stand: Stand, seed: int) -> None:
    check_stand(stand, seed=seed)


def test_printed_mapping() -> None:
    force = TwoAxis().stimulus(np.radians([[30.0, 0.0], [0.0, 90.0], [0.0, 0.0], [60.0, 30.0]])).specific_force
    expected = [(0.5, 0, 3**0.5 / 2), (0, 1, 0), (0, 0, 1), (3**0.5 / 2, 0.25, 3**0.5 / 4)]
    np.testing.assert_allclose(force, expected, atol=1e-15)


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
def test_vertical_is_a_unit_vector(alpha1: float, alpha2: float) -> None:
    force = TwoAxis().stimulus(np.array([[alpha1, alpha2]])).specific_force[0]
    expected = (math.sin(alpha1), math.cos(alpha1) * math.sin(alpha2), math.cos(alpha1) * math.cos(alpha2))
    np.testing.assert_allclose(force, expected, atol=1e-14)


@pytest.mark.parametrize("stand", [*parts.CONTINUOUS, *parts.FURTHER_STANDS[:4]], ids=repr)
def test_aim_finds_settings_that_are_allowed(stand: Stand) -> None:
    force = stand.stimulus(stand.axes.random(np.random.default_rng(1), (500,))).specific_force
    assert force is not None
    aimed = stand.aim(force)
    assert stand.axes.allows(aimed).all()
    np.testing.assert_allclose(stand.stimulus(aimed).specific_force, force, atol=1e-7)


def test_stand_that_can_not_be_aimed_says_so() -> None:
    class Plain(Stand):
        settings = (Setting("roll", 0.0, 1.0),)

        def stimulus(self, settings):  # type: ignore[no-untyped-def]
            raise NotImplementedError

    with pytest.raises(CompatibilityError, match="Plain can't be aimed"):
        Plain().aim(np.eye(3))


@pytest.mark.parametrize("stand", parts.STEPPED, ids=repr)
def test_random_settings_reach_all_the_stops_and_no_other(stand: Stand) -> None:
    angles = stand.axes.random(np.random.default_rng(0), (5000,))
    for k, setting in enumerate(stand.settings):
        stops = setting.stops()
        np.testing.assert_array_equal(np.unique(angles[:, k]), stops)
        assert setting.step is not None
        np.testing.assert_allclose(stops / setting.step, np.round(stops / setting.step), atol=1e-9)
        assert not setting.allows(stops + 0.3 * setting.step).any()


def test_stops_of_a_full_turn_are_counted_once() -> None:
    assert len(TwoAxis(step_deg=15).settings[0].stops()) == 24
    assert len(TwoAxis(alpha1_deg=(-180, 180), step_deg=45).settings[0].stops()) == 8
    assert len(TwoAxis(step_deg=15, periodic=False).settings[0].stops()) == 25
    np.testing.assert_allclose(
        np.degrees(TwoAxis((-0.3, 0.3), step_deg=0.1).settings[0].stops()), np.arange(-3, 4) / 10
    )


def test_continuous_setting_has_no_stops() -> None:
    with pytest.raises(CompatibilityError, match="roll has no steps"):
        Setting("roll", 0.0, 1.0).stops()


@given(
    st.floats(-720, 720), st.floats(1, 360), st.floats(-2000, 2000), st.booleans(), st.one_of(st.none(), st.just(10.0))
)
@settings(max_examples=200)
def test_wrap_keeps_the_position(lower: float, span: float, angle: float, periodic: bool, step: float | None) -> None:
    span = max(span, 2 * (step or 0.0))
    setting = Setting(
        "roll", *np.radians([lower, lower + span]), None if step is None else math.radians(step), periodic
    )
    angles = np.array([math.radians(angle)])
    wrapped = setting.wrap(angles)
    turns = (angles - wrapped) / (2 * math.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    np.testing.assert_allclose(setting.wrap(wrapped), wrapped, atol=1e-9)
    assert periodic or wrapped == angles
    assert setting.allows(angles) == setting.allows(wrapped)
    if periodic and step is None:
        over = (angle - lower) % 360.0
        if 1e-6 < over < span - 1e-6:
            assert setting.allows(angles)
        elif span + 1e-6 < over < 360.0 - 1e-6:
            assert not setting.allows(angles)


@pytest.mark.parametrize("limits", [None, 5, "ab", (0,), (0, 1, 2), ("a", 3), (0, NAN), (0, INF), (True, 3), (None, 1)])
@pytest.mark.parametrize("name", ["alpha1_deg", "alpha2_deg"])
def test_limits_that_are_not_a_pair_of_numbers(name: str, limits: object) -> None:
    quoted = limits if not isinstance(limits, tuple) or len(limits) != 2 else f"[{limits[0]}, {limits[1]}]"
    with pytest.raises(ArgumentError) as caught:
        TwoAxis(**{name: limits})  # type: ignore[arg-type]
    assert str(caught.value).startswith(f"{name}={quoted}: ")


@pytest.mark.parametrize(
    ("arguments", "quoted"),
    [
        ({"alpha1_deg": (10, -10)}, "alpha1_deg=[10, -10]: the lower bound must be below"),
        ({"alpha2_deg": (7, 7)}, "alpha2_deg=[7, 7]: the lower bound must be below"),
        ({"alpha1_deg": (0, 400)}, "alpha1_deg=[0, 400]: a periodic angle spans 360"),
        ({"step_deg": 0}, "step_deg=0: "),
        ({"step_deg": -1}, "step_deg=-1: "),
        ({"step_deg": NAN}, "step_deg=nan: "),
        ({"step_deg": INF}, "step_deg=inf: "),
        ({"step_deg": "x"}, "step_deg=x: "),
        ({"step_deg": True}, "step_deg=True: "),
        ({"alpha1_deg": (1, 9), "step_deg": 30}, "alpha1_deg=[1, 9] holds no multiple of the step of 30 degrees"),
        ({"periodic": "yes"}, "periodic=yes: "),
        ({"periodic": 1}, "periodic=1: "),
        ({"periodic": None}, "periodic=None: "),
    ],
    ids=str,
)
def test_bad_tables(arguments: dict[str, object], quoted: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        TwoAxis(**arguments)  # type: ignore[arg-type]
    assert quoted in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "quoted"),
    [
        ((NAN, 1), "roll_deg=[nan, 57.2958]"),
        ((0, INF), "roll_deg=[0, inf]"),
        ((1, 0), "roll_deg=[57.2958, 0]"),
        ((0, 0), "roll_deg=[0, 0]"),
        ((0, 7), "roll_deg=[0, 401.07]"),
        (("x", 1), "roll: lower='x'"),
        ((0, None), "roll: upper=None"),
        ((0, 1, "x"), "roll: step='x'"),
        ((0, 1, 0), "step_deg=0: "),
        ((0, 1, math.radians(-5)), "step_deg=-5: "),
        ((0, 1, NAN), "step_deg=nan: "),
        ((1, 2, 3), "step of 171.887 degrees"),
        ((0, 1, None, "no"), "roll: periodic='no'"),
    ],
    ids=str,
)
def test_bad_settings(arguments: tuple[object, ...], quoted: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        Setting("roll", *arguments)  # type: ignore[arg-type]
    assert quoted in str(caught.value)


def test_a_setting_may_be_a_rate() -> None:
    rate = Setting("rate", *np.radians([-60.0, 60.0]), math.radians(20.0), False, DEGREE_PER_SECOND)
    assert (rate.column, rate.limits) == ("rate_deg_s", "rate_deg_s=[-60, 60]")
    np.testing.assert_array_equal(rate.unit.write(rate.stops()), np.arange(-60, 61, 20))
    with pytest.raises(ArgumentError, match="rate_deg_s: only an angle is periodic"):
        Setting("rate", -1.0, 1.0, unit=DEGREE_PER_SECOND)
    with pytest.raises(ArgumentError, match=r"step_deg_s=-5: .* positive number of degrees per second"):
        Setting("rate", -1.0, 1.0, math.radians(-5.0), False, DEGREE_PER_SECOND)


def test_the_magnetic_field_turns_with_the_vertical() -> None:
    angles = parts.FULL.axes.random(np.random.default_rng(0), (50,))
    for dip in (90.0, -90.0):  # it is the vertical, down or up
        stimulus = TwoAxis(dip_deg=dip).stimulus(angles)
        np.testing.assert_allclose(stimulus.magnetic_field, -np.sign(dip) * stimulus.specific_force, atol=1e-15)
    stimulus = TwoAxis(dip_deg=65.0, field_azimuth_deg=30.0).stimulus(angles)
    assert stimulus.magnetic_field is not None
    np.testing.assert_allclose(np.linalg.norm(stimulus.magnetic_field, axis=-1), 1.0)
    below = (stimulus.magnetic_field * stimulus.specific_force).sum(axis=-1)
    np.testing.assert_allclose(below, -math.sin(math.radians(65.0)))
    level = TwoAxis(dip_deg=0.0, field_azimuth_deg=90.0).stimulus(np.zeros((1, 2)))
    np.testing.assert_allclose(level.magnetic_field, [[0, 1, 0]], atol=1e-15)
    with pytest.raises(ArgumentError, match="dip_deg=100: must be a number of degrees from -90 to 90"):
        TwoAxis(dip_deg=100)
