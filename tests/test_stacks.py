"""Estimates of stacks of sensors: each member has freedoms, steps and noises of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from acalx.errors import ArgumentError
from acalx.estimation import Estimate, Huber, Iterated
from acalx.models import Compared, Model, VectorAccel
from acalx.models.base import noises_of
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import AccelTriad, Channel, Polynomial, Term
from acalx.simulation import Campaign, ErrorSources, run_campaign
from acalx.stands import TwoAxis

TABLE = TwoAxis()


@dataclass(frozen=True)
class TwoUnits(Polynomial):
    """Two channels in units of their own that share as many parameters as they are told."""

    common: int = 1
    scale: float = 1.0
    channels: tuple[Channel, ...] = field(default=(Channel("a", "g", 1e-3), Channel("b", "V", 1e-2)))

    @property
    def terms(self) -> tuple[Term, ...]:
        shared = [Parameter(f"common_{axis}", "common", "1") for axis in "xy"[: self.common]]
        own = [Parameter(f"bias_{one}", "bias", one) for one in ("g", "V")]
        return (
            *(Term(p, f"f{p.name[-1]}", factor * self.scale, k) for p in shared for k, factor in ((0, 1.0), (1, 5.0))),
            *(Term(p, (), self.scale, k) for k, p in enumerate(own)),
            Term(None, "fz", 1.0, 0),
        )


def felt(n: int, seed: int = 0) -> Stimulus:
    return TABLE.stimulus(TABLE.axes.random(np.random.default_rng(seed), (n,)))


def stack(model: Model, known: Stimulus, count: int, noise: float = 1.0) -> Array:
    rng = np.random.default_rng(3)
    clean = model.readings(model.nominal, known)
    return np.asarray(clean + noise * model.deviations(known) * rng.standard_normal((count, *clean.shape)))


INFORMED = [
    (lambda: Compared(AccelTriad("full", noise_g=1e-2), prior={"bias": 0.01, "scale": 0.01}), Iterated()),
    (lambda: Compared(AccelTriad("full", noise_g=1e-2), prior={"bias": 0.01}), Iterated(loss=Huber())),
    (lambda: Compared(TwoUnits(), prior={"common": 1e-3}), Iterated()),
]


@pytest.mark.parametrize(("made", "estimator"), INFORMED)
def test_each_member_of_a_stack_has_the_freedoms_that_it_has_alone(
    made: Callable[[], Model], estimator: Iterated
) -> None:
    model, known = made(), felt(9)
    readings = stack(model, known, 4) * 1.0
    readings[1] += 3.0 * (readings[1] - readings.mean(axis=0))  # noisier
    whole = estimator.estimate(model, readings, known)
    alone = [estimator.estimate(model, each, known) for each in readings]

    def assert_alike(of: Callable[[Estimate], Any], rtol: float) -> None:
        np.testing.assert_allclose(of(whole), [of(each) for each in alone], rtol=rtol)

    assert whole.freedom.shape == (4,)
    assert len(set(whole.freedom.round(6))) == 4
    for of in (lambda e: e.freedom, lambda e: e.freedoms, lambda e: e.standard_errors):
        assert_alike(of, 1e-4)


@pytest.mark.parametrize(("made", "estimator"), INFORMED)
def test_a_member_that_is_lost_takes_no_other_with_it(made: Callable[[], Model], estimator: Iterated) -> None:
    model, known = made(), felt(9)
    readings = stack(model, known, 3)
    good = estimator.estimate(model, readings, known)
    readings[0] = np.nan
    found = estimator.estimate(model, readings, known)
    assert found.converged.tolist() == [False, True, True]
    np.testing.assert_allclose(found.standard_errors[1:], good.standard_errors[1:], rtol=1e-6)
    assert (found.freedom[1:] > 0).all()


def test_without_a_prior_all_have_the_same_freedom() -> None:
    model = VectorAccel()
    found = Iterated().estimate(model, stack(model, felt(9), 3), felt(9))
    assert found.freedom.shape == ()
    assert found.freedoms.tolist() == [27.0 - 12.0] * 12


def test_intervals_with_a_prior_cover() -> None:
    model = Compared(AccelTriad("full", noise_g=1e-3), prior={"bias": 1e-3, "scale": 1e-3, "misalignment": 1e-3})
    sources = ErrorSources(
        parameters={"bias": 1e-3, "scale": 1e-3, "misalignment": 1e-3}, setting_rad=0.0, gravity=0.0, noise=1.0
    )
    settings = TABLE.axes.random(np.random.default_rng(1), (8,))
    outcome = run_campaign(Campaign(model, TABLE, settings, sources, seed=2), Iterated(), 3000)
    assert outcome.moments.failed == 0
    assert abs(outcome.coverage.mean() - 0.95) < 0.02


# ---------------------------------------------------------------- several noises


@pytest.mark.parametrize(("common", "shared"), [(0, False), (1, True), (2, True)])
def test_parameters_that_several_noises_share_are_known_by_where_they_show(common: int, shared: bool) -> None:
    model = Compared(TwoUnits(common))
    assert model.noises.shared == shared
    assert float(model.noises.parameters.sum()) == 2.0 + common


def test_shares_need_no_odd_sum() -> None:
    noises = noises_of(np.array([0, 1]), np.array([[True, True, True, False], [True, True, False, True]]))
    assert noises.parameters.tolist() == [2.0, 2.0]
    assert noises.shared


@pytest.mark.parametrize("common", [1, 2])
def test_sizes_of_noises_are_followed_until_they_stay(common: int) -> None:
    model, known = Compared(TwoUnits(common)), felt(7)
    readings = stack(model, known, 50) + (stack(model, known, 50) - model.readings(model.nominal, known)) * [9.0, 0.0]
    found = Iterated().estimate(model, readings, known)
    assert found.converged.all()
    again = found.sizes_of_noises(model.noises, np.tile(model.noises.of_outputs, 7))
    np.testing.assert_allclose(again, found.sizes, rtol=1e-5)


def test_sizes_that_do_not_stay_are_not_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("acalx.estimation.base._MOST_ROUNDS", 2)
    model, known = Compared(TwoUnits(2)), felt(7)
    assert not Iterated().estimate(model, stack(model, known, 5), known).converged.any()


# ---------------------------------------------------------------- steps


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_steps_end_by_standard_errors_whatever_the_units(scale: float, noise: float) -> None:
    """The same readings, parameters in units a millionth as large or a million times."""
    known = felt(9)
    plain, other = Compared(TwoUnits()), Compared(TwoUnits(scale=scale))
    truth = np.array([0.3, -0.2, 0.5])
    shift = stack(plain, known, 4, noise) - plain.readings(plain.nominal, known)
    readings = plain.readings(truth, known) + shift
    found, same = (Iterated().estimate(model, readings, known) for model in (plain, other))
    assert found.converged.all()
    assert same.converged.all()
    assert same.iterations <= max(found.iterations, 3)  # before the third, roundings are not looked at
    np.testing.assert_allclose(same.parameters * scale, found.parameters, rtol=1e-6)
    if noise == 0.0:
        np.testing.assert_allclose(found.parameters, np.broadcast_to(truth, (4, 3)), rtol=1e-12)


@pytest.mark.parametrize("size", [1e-200, 1e-170, 1e170, 5e-324])
def test_priors_that_cannot_be_squared_are_refused(size: float) -> None:
    with pytest.raises(ArgumentError, match="that can be squared"):
        Compared(AccelTriad(noise_g=1e-3), prior={"bias": size})
