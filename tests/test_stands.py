from __future__ import annotations

import ast
import inspect
import itertools
import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parts
from acalx.errors import ArgumentError, CompatibilityError, Option
from acalx.programs import find_program
from acalx.quantities.units import DEGREE_PER_SECOND
from acalx.stands import Chamber, PlatformGimbals, RateTable, Rotary, Setting, Stand, TwoAxis
from acalx.stands.fields import limits
from acalx.stands.turns import UP, Vector
from acalx.testing import check_stand

NAN, INF = math.nan, math.inf


@pytest.mark.parametrize("stand", [*parts.STANDS, *parts.FURTHER_STANDS], ids=repr)
@pytest.mark.parametrize("seed", range(3))
def test_contract(stand: Stand, seed: int) -> None:
    check_stand(stand, seed=seed)


def test_printed_mapping() -> None:
    force = TwoAxis().stimulus(np.radians([[30.0, 0.0], [0.0, 90.0], [0.0, 0.0], [60.0, 30.0]]))["specific_force"]
    expected = [(0.5, 0, 3**0.5 / 2), (0, 1, 0), (0, 0, 1), (3**0.5 / 2, 0.25, 3**0.5 / 4)]
    np.testing.assert_allclose(force, expected, atol=1e-15)


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
def test_vertical_is_a_unit_vector(alpha1: float, alpha2: float) -> None:
    force = TwoAxis().stimulus(np.array([[alpha1, alpha2]]))["specific_force"][0]
    expected = (math.sin(alpha1), math.cos(alpha1) * math.sin(alpha2), math.cos(alpha1) * math.cos(alpha2))
    np.testing.assert_allclose(force, expected, atol=1e-14)


@pytest.mark.parametrize("stand", [*parts.CONTINUOUS, *parts.FURTHER_STANDS[:4]], ids=repr)
def test_aim_finds_settings_that_are_allowed(stand: Stand) -> None:
    force = stand.stimulus(stand.axes.random(np.random.default_rng(1), (500,)))["specific_force"]
    assert force is not None
    aimed = stand.aim(force)
    assert stand.axes.allows(aimed).all()
    np.testing.assert_allclose(stand.stimulus(aimed)["specific_force"], force, atol=1e-7)


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
    with pytest.raises(ArgumentError) as caught:
        TwoAxis(**{name: limits})  # type: ignore[arg-type]
    assert str(caught.value).startswith(f"{name}={limits!r}: ")


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
        ({"step_deg": "x"}, "step_deg='x': "),
        ({"step_deg": True}, "step_deg=True: "),
        ({"alpha1_deg": (1, 9), "step_deg": 30}, "alpha1_deg=[1, 9]: holds no multiple of the step of 30 degrees"),
        ({"periodic": "yes"}, "periodic='yes': "),
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
        ((0, 1, None, "no"), "periodic='no'"),
    ],
    ids=str,
)
def test_bad_settings(arguments: tuple[object, ...], quoted: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        Setting("roll", *arguments)  # type: ignore[arg-type]
    assert quoted in str(caught.value)


def test_a_setting_may_be_a_rate() -> None:
    rate = Setting("rate", *np.radians([-60.0, 60.0]), math.radians(20.0), False, DEGREE_PER_SECOND)
    assert rate.limits == Option(rate.column, [-60, 60]) == Option("rate_deg_s", [-60, 60])
    np.testing.assert_array_equal(rate.unit.write(rate.stops()), np.arange(-60, 61, 20))
    with pytest.raises(ArgumentError, match="rate_deg_s: only an angle is periodic"):
        Setting("rate", -1.0, 1.0, unit=DEGREE_PER_SECOND)
    with pytest.raises(ArgumentError, match=r"step_deg_s=-5: .* positive number of degrees per second"):
        Setting("rate", -1.0, 1.0, math.radians(-5.0), False, DEGREE_PER_SECOND)


def test_the_magnetic_field_turns_with_the_vertical() -> None:
    angles = parts.FULL.axes.random(np.random.default_rng(0), (50,))
    for dip in (90.0, -90.0):  # it is the vertical, down or up
        stimulus = TwoAxis(dip_deg=dip).stimulus(angles)
        np.testing.assert_allclose(stimulus["magnetic_field"], -np.sign(dip) * stimulus["specific_force"], atol=1e-15)
    stimulus = TwoAxis(dip_deg=65.0, field_azimuth_deg=30.0).stimulus(angles)
    assert "magnetic_field" in stimulus
    np.testing.assert_allclose(np.linalg.norm(stimulus["magnetic_field"], axis=-1), 1.0)
    below = (stimulus["magnetic_field"] * stimulus["specific_force"]).sum(axis=-1)
    np.testing.assert_allclose(below, -math.sin(math.radians(65.0)))
    level = TwoAxis(dip_deg=0.0, field_azimuth_deg=90.0).stimulus(np.zeros((1, 2)))
    np.testing.assert_allclose(level["magnetic_field"], [[0, 1, 0]], atol=1e-15)
    with pytest.raises(ArgumentError, match="dip_deg=100: must be a number of degrees from -90 to 90"):
        TwoAxis(dip_deg=100)


# ---------------------------------------------------------------- stands that are told by their axes


@dataclass(frozen=True)
class Tumbler(Rotary):
    """A stand as its author writes it: a table that rolls about y, then about the sensor's own x, near a magnet."""

    turns: ClassVar[Mapping[str, str]] = {"roll": "y", "spin": "x"}
    surroundings: ClassVar[Mapping[str, Vector]] = {"specific_force": UP, "magnetic_field": (0.6, None, -0.8)}
    roll_deg: Sequence[float] = limits(-180.0, 180.0)
    spin_deg: Sequence[float] = (0.0, 360.0)


def turned_about(*axes: str) -> Stand:
    """A stand that feels gravity, with one angle about each axis."""
    names = [f"angle{k}" for k in range(len(axes))]
    body = {"turns": dict(zip(names, axes, strict=True)), "surroundings": {"specific_force": UP}}
    return dataclass(frozen=True)(type("Turned", (Rotary,), body | {f"{name}_deg": (0.0, 360.0) for name in names}))()


AXES = ("x", "y", "z", "-x", "-y", "-z")


@pytest.mark.parametrize("axes", [*itertools.product(AXES, repeat=2), *itertools.product("xyz", repeat=3)], ids="".join)
def test_stands_with_any_axes_keep_the_contract(axes: tuple[str, ...]) -> None:
    stand = turned_about(*axes)
    check_stand(stand)
    outer, inner = axes[0][-1], axes[1][-1]
    if len(axes) == 2 and outer != "z" and outer != inner:
        assert len(stand.equivalents(np.zeros((1, 2)))) == 2
        assert np.abs(stand.aim(np.eye(3))).max() <= 2 * math.pi
    else:
        with pytest.raises(CompatibilityError, match="can't be aimed at directions"):
            stand.aim(np.eye(3))


def test_a_turn_is_a_rotation_of_the_axes() -> None:
    rng = np.random.default_rng(0)
    for axis in AXES:
        angle = rng.uniform(-3.0, 3.0)
        k, sign = "xyz".index(axis[-1]), -1.0 if axis[0] == "-" else 1.0
        c, s = math.cos(angle), sign * math.sin(angle)
        matrix = np.roll([[1, 0, 0], [0, c, s], [0, -s, c]], (k, k), axis=(0, 1))
        force = turned_about(axis).stimulus(np.array([[angle]]))["specific_force"]
        np.testing.assert_allclose(force, [matrix @ [0.0, 0.0, 1.0]], atol=1e-15)


def test_a_stand_of_few_lines_has_it_all() -> None:
    stand = Tumbler(step_deg=(15, None), forbidden=[{"roll_deg": (10, 20)}], speed_deg_s=(5, 20))
    check_stand(stand)
    assert stand.axes.columns == ("roll_deg", "spin_deg")
    assert stand.axes.forbids(np.radians([15.0, 0.0]))
    np.testing.assert_allclose(np.degrees(stand.speeds), [5, 20])
    assert stand == Tumbler(step_deg=(15, None), forbidden=[{"roll_deg": (10, 20)}], speed_deg_s=(5, 20))
    with pytest.raises(ArgumentError, match=r"spin_deg=\[0, 400\]: a periodic angle spans 360"):
        Tumbler(spin_deg=(0, 400))
    with pytest.raises(ArgumentError, match=r"roll_deg=3: give a lower and an upper limit in degrees, as in roll_deg="):
        Tumbler(roll_deg=3)


def code_lines(kind: type) -> int:
    """Lines of a class that hold code: no documentation, no comments, no blank ones, each statement on one."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(kind)))
    for node in ast.walk(tree):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            del node.body[0]
    return sum(1 for line in ast.unparse(tree).splitlines() if line.strip())


@pytest.mark.parametrize("kind", [TwoAxis, PlatformGimbals, RateTable, Tumbler])
def test_a_stand_takes_no_more_than_25_lines(kind: type) -> None:
    assert 5 <= code_lines(kind) <= 25


def test_what_only_depends_on_the_vertical_has_another_pair_of_angles() -> None:
    settings = np.radians([[20.0, 30.0, 40.0]])
    np.testing.assert_allclose(np.degrees(RateTable().equivalents(settings)[1]), [[160, 210, 40]])
    assert len(PlatformGimbals().equivalents(settings[:, :2])) == 1
    assert len(PlatformGimbals(latitude_deg=90).equivalents(settings[:, :2])) == 2  # the rate is vertical there
    assert len(TwoAxis(dip_deg=65).equivalents(settings[:, :2])) == 1


def test_the_rate_is_at_rest_where_directions_are_given() -> None:
    program = find_program("icosahedron_12")
    settings = program.settings_for(RateTable())
    np.testing.assert_array_equal(settings[:, :2], program.settings_for(TwoAxis()))
    assert not settings[:, 2].any()
    assert RateTable().axes.allows(settings).all()
    assert not RateTable(rate_deg_s=(10, 50)).axes.allows(settings).any()


@pytest.mark.parametrize(
    ("stand", "rest"),
    [
        (Chamber(temperature_degC=(20, 60)), 20.0),
        (Chamber(temperature_degC=(-40, -5)), -5.0),
        (Chamber(temperature_degC=(21, 60), temperature_step_degC=10), 30.0),
        (Chamber(temperature_degC=(-40, 5), temperature_step_degC=10), 0.0),
        (RateTable(rate_deg_s=(10, 50)), math.radians(10.0)),
        (RateTable(rate_deg_s=(-50, -7), rate_step_deg_s=5), math.radians(-10.0)),
    ],
    ids=str,
)
def test_rest_is_as_near_to_zero_as_the_limits_allow(stand: Stand, rest: float) -> None:
    force = stand.stimulus(stand.axes.random(np.random.default_rng(0), (20,)))["specific_force"]
    aimed = stand.aim(force)
    assert stand.axes.allows(aimed).all()
    np.testing.assert_allclose(aimed[:, 2], rest, rtol=1e-12)
    check_stand(stand)


def test_options_are_said_as_arguments() -> None:
    with pytest.raises(ArgumentError, match=r"as in alpha1_deg=\(-180, 180\)"):
        TwoAxis(alpha1_deg=5)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"or step_deg=None for none"):
        TwoAxis(step_deg="x")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"forbidden=\[\{'alpha1_deg': \(80, 100\), 'alpha2_deg'"):
        TwoAxis(forbidden="x")  # type: ignore[arg-type]


def test_a_stand_that_is_no_dataclass_has_the_options_too() -> None:
    class Plain(Stand):
        settings = (Setting("roll", 0.0, 1.0), Setting("rate", -1.0, 1.0, None, False, DEGREE_PER_SECOND))

        def stimulus(self, settings):  # type: ignore[no-untyped-def]
            raise NotImplementedError

    stand = Plain(forbidden=[{"roll_deg": (10, 20)}], speed_deg_s=20)
    assert stand.axes.forbids(np.radians([15.0, 0.0]))
    assert stand.speeds.tolist() == [math.radians(20.0), INF]
    assert Plain().axes.allows(np.radians([15.0, 0.0]))
    assert Plain() != Plain()
