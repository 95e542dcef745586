"""What came out of many simulated calibrations with one program, beside what theory predicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import parameter_groups

__all__ = ["Moments", "Outcome"]


@final
@dataclass
class Moments:
    """Sums over trials, so that memory does not grow with their number.

    Parameters
    ----------
    p : int
        Number of parameters.
    """

    p: int
    count: int = 0
    failed: int = 0
    mean: Array = field(init=False)
    scatter: Array = field(init=False)
    true_squares: Array = field(init=False)
    covered: Array = field(init=False)

    def __post_init__(self) -> None:
        self.mean, self.scatter = np.zeros(self.p), np.zeros((self.p, self.p))
        self.true_squares, self.covered = np.zeros(self.p), np.zeros(self.p)

    def add(self, true: Array, error: Array, half_widths: Array) -> None:
        """Take in the true parameters, errors of estimates and half widths of intervals of trials, (T, p) each.

        Trials without an estimate, nan, are counted but don't count.
        """
        good = np.isfinite(error).all(axis=-1)
        self.failed += int((~good).sum())
        if not good.all():
            true, error, half_widths = true[good], error[good], half_widths[good]
        if not len(error):
            return
        mean = error.mean(axis=0)
        centered = error - mean
        total = self.count + len(error)
        apart = mean - self.mean
        self.scatter += centered.T @ centered + np.outer(apart, apart) * (self.count * len(error) / total)
        self.mean = self.mean + apart * (len(error) / total)
        self.true_squares += (true * true).sum(axis=0)
        self.covered += (np.abs(error) <= half_widths).sum(axis=0)
        self.count = total


@final
@dataclass(frozen=True, eq=False)
class Outcome:
    """Errors of the estimates of one program over the trials.

    Parameters
    ----------
    name : str
        Of the program.
    n : int
        Number of its positions.
    information : Information
        Of the program where nothing goes wrong, in units of the noise.
    noise : float
        Standard deviation of the noise.
    moments : Moments
    confidence : float
        Of limits and of verdicts.
    """

    name: str
    n: int
    information: Information
    noise: float
    moments: Moments
    confidence: float = 0.95

    @property
    def trials(self) -> int:
        """Trials that ended with an estimate."""
        return self.moments.count

    @property
    def bias(self) -> Array:
        """Mean error of the estimates, (p,)."""
        return self.moments.mean

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the errors, (p, p)."""
        return self.moments.scatter / (self.trials - 1)

    @property
    def deviations(self) -> Array:
        """Standard deviations of the errors, (p,)."""
        return np.sqrt(self.covariance.diagonal())

    @property
    def bias_limits(self) -> Array:
        """Confidence limits of the bias, normal, (p, 2)."""
        from scipy.special import stdtrit

        half = stdtrit(self.trials - 1, 0.5 * (1 + self.confidence)) * self.deviations / np.sqrt(self.trials)
        return np.stack([self.bias - half, self.bias + half], axis=-1)

    @property
    def deviation_limits(self) -> Array:
        """Confidence limits of the standard deviations, by chi-square, (p, 2)."""
        from scipy.special import chdtri

        freedom, tail = self.trials - 1, 0.5 * (1 - self.confidence)
        factors = np.sqrt(freedom / chdtri(freedom, np.array([tail, 1 - tail])))
        return np.asarray(self.deviations[:, None] * factors)

    @property
    def predicted(self) -> Array:
        """Standard deviations by theory, noise times sqrt(K_rr), (p,)."""
        return self.noise * self.information.standard_deviations

    @property
    def as_predicted(self) -> np.ndarray:
        """Whether each predicted standard deviation is within the limits, (p,)."""
        low, high = self.deviation_limits.T
        return np.asarray((low <= self.predicted) & (self.predicted <= high))

    @property
    def relative_errors(self) -> Array:
        """Root mean square error over that of the true parameters, (p,); inf for those that are zero."""
        squares = self.moments.scatter.diagonal() / self.trials + self.bias**2
        with np.errstate(divide="ignore"):
            return np.asarray(np.sqrt(squares / (self.moments.true_squares / self.trials)))

    @property
    def coverage(self) -> Array:
        """Share of trials in which the interval of the calibration held the true parameter, (p,)."""
        return self.moments.covered / self.trials

    @cached_property
    def bias_probability(self) -> float:
        """Probability of a bias as large as this where there is none, by Hotelling's test."""
        from scipy.special import fdtrc

        t, p = self.trials, len(self.bias)
        if t <= p:
            return np.nan
        squared = t * float(self.bias @ np.linalg.solve(self.covariance, self.bias))
        return float(fdtrc(p, t - p, squared * (t - p) / (p * (t - 1))))

    @cached_property
    def scatter_probability(self) -> float:
        """Probability of a covariance as far from the predicted one as this, where that is right.

        By the likelihood ratio, (T - 1) (tr R - log det R - p) for R the covariance over the
        predicted one, with Bartlett's correction: chi-square of p (p + 1) / 2. It takes errors
        for normal. Source: Anderson, An Introduction to Multivariate Statistical Analysis, 10.8.
        """
        from scipy.special import chdtrc

        t, p = self.trials, len(self.bias)
        if t <= p:
            return np.nan
        root = np.linalg.cholesky(self.information.covariance * self.noise**2)
        half = np.linalg.solve(root, self.covariance)
        values = np.linalg.eigvalsh(np.linalg.solve(root, half.T))
        if values[0] <= 0:
            return 0.0
        correction = 1.0 - (2 * p + 1 - 2 / (p + 1)) / (6.0 * (t - 1))
        statistic = (t - 1) * correction * float((values - np.log(values) - 1.0).sum())
        return float(chdtrc(p * (p + 1) / 2, statistic))

    @property
    def agrees(self) -> bool:
        """Whether bias and covariance are what theory predicts, as far as so many trials can tell."""
        share = 0.5 * (1 - self.confidence)  # of each of two tests
        return bool(min(self.bias_probability, self.scatter_probability) >= share)

    def summary(self) -> str:
        """One line on whether it agrees with theory, and how probable what came out is where it does."""
        probabilities = f"{self.scatter_probability:.3g} (spread), {self.bias_probability:.3g} (bias)"
        failed = f"; {self.moments.failed} trials did not settle" if self.moments.failed else ""
        word = "agrees with theory" if self.agrees else "does not agree with theory"
        return f"{self.name} {word}: probability {probabilities}{failed}"

    @cached_property
    def groups(self) -> Mapping[str, Mapping[str, Any]]:
        """By group: s and inequality, achieved and predicted, with their limits.

        s is the largest standard deviation of the group over that of the noise, which theory
        says is theta. ``s_limits`` are those of the parameter that has it; ``as_predicted`` is
        whether theory is within limits for all of the group, at a confidence that all parameters share.
        Source: Egorov, Kiryachenko, Popov (2021).
        """
        out = {}
        deviations, limits = self.deviations / self.noise, self.deviation_limits / self.noise
        for group, members in parameter_groups(self.information.parameters).items():
            own = deviations[members]
            entry = {
                "s": float(own.max()),
                "s_limits": limits[members[int(own.argmax())]].tolist(),
                "theta": float(self.information.theta(group)),
                "as_predicted": bool(self._within(members)),
                "bias": float(np.abs(self.bias[members]).max()),
            }
            if len(members) > 1:
                entry["inequality"] = float(1.0 - own.min() / own.max())
                entry["inequality_predicted"] = float(self.information.inequality(group))
            out[group] = entry
        return out

    def _within(self, members: list[int]) -> bool:
        """Whether all these have their predicted deviation, at a confidence that all parameters share."""
        from scipy.special import chdtri

        freedom = self.trials - 1
        tail = 0.5 * (1 - self.confidence ** (1 / len(self.bias)))
        low, high = chdtri(freedom, np.array([1 - tail, tail]))
        ratio = freedom * (self.deviations[members] / self.predicted[members]) ** 2
        return bool(((low <= ratio) & (ratio <= high)).all())

    def entries(self) -> dict[str, Any]:
        """Verdicts, and all that is known of each group and parameter, for a file."""
        rows = zip(
            self.information.parameters,
            self.bias.tolist(),
            self.bias_limits.tolist(),
            self.deviations.tolist(),
            self.deviation_limits.tolist(),
            self.predicted.tolist(),
            self.as_predicted.tolist(),
            self.relative_errors.tolist(),
            self.coverage.tolist(),
            strict=True,
        )
        keys = ("bias", "bias_limits", "standard_deviation", "standard_deviation_limits", "predicted")
        more = ("as_predicted", "relative_error", "coverage")
        return {
            "program": self.name,
            "n": self.n,
            "trials": self.trials,
            "failed": self.moments.failed,
            "agrees": self.agrees,
            "bias_probability": self.bias_probability,
            "covariance_probability": self.scatter_probability,
            "groups": self.groups,
            "parameters": {
                parameter.name: {"unit": parameter.unit, **dict(zip((*keys, *more), row, strict=True))}
                for parameter, *row in rows
            },
        }
