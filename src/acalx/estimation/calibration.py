"""A calibrated sensor, and what its residuals say of the calibration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.errors import CompatibilityError
from acalx.estimation.correction import Correctly, correction_of
from acalx.estimation.estimate import Estimate
from acalx.estimation.readings import Readings
from acalx.estimation.residuals import OF_MODEL, suffix
from acalx.estimation.units import Unit
from acalx.models import Model
from acalx.numerics.arrays import Array

__all__ = ["CONFIDENCE", "Calibration"]

CONFIDENCE = 0.95
# A parameter is called hardly shown where its standard deviation is so many times the noise's.
_HARDLY_SHOWN = 30.0
# An estimated noise is questioned where it is so many times what the model tells.
_FAR_ABOVE = 5.0


@final
@dataclass(frozen=True, eq=False)
class Calibration:
    """Parameters of a sensor with their accuracy, the correction, and tests of fit.

    Parameters
    ----------
    model : Model
        As it was compared.
    readings : Readings
    unit : Unit
        With `per_g` as found where it was not known.
    estimate : Estimate
    confidence : float
        Of the intervals; positions are called outlying at the complement, shared by all positions.
    """

    model: Model
    readings: Readings
    unit: Unit
    estimate: Estimate
    confidence: float = CONFIDENCE

    @cached_property
    def correction(self) -> Correctly:
        """What makes readings right: a matrix and an offset where these do."""
        per = self.unit.per_channel(self.model.channels)
        return correction_of(self.model, self.estimate.parameters, per, self.unit.offset, self.unit.name or "")

    @cached_property
    def corrected(self) -> Array | None:
        """The readings made right, (n, k); None where what that takes is not known."""
        known = self.readings.stimulus
        there = self.correction.needs
        if there and (known is None or not set(there) <= set(known)):
            return None
        return self.correction.apply(self.readings.means, known)

    @cached_property
    def noises(self) -> dict[str, float]:
        """Standard deviations of the residuals by what they are in, estimated, or the mean square of the known ones.

        In the unit of the channels where these have the same noise; otherwise in units of the model's noise.
        """
        kinds, estimate = self.model.noises, self.estimate
        if estimate.sizes.size:
            sizes = estimate.sizes
        elif estimate.noise is not None:
            sizes = np.array([np.sqrt(np.mean(estimate.noise**2))])
        else:
            sizes = np.array([float(estimate.scale)])
        found: dict[str, float] = {}
        for k, size in enumerate(sizes):
            unit, one = self._of_noise(k if len(sizes) == len(kinds.parameters) else None)
            name = unit if unit not in found else f"{unit} ({k + 1})"
            found[name] = float(size * one)
        return found

    @property
    def noise(self) -> float:
        """The standard deviation of the residuals where they have one noise: see `noises`.

        Raises
        ------
        CompatibilityError
            Where they have several.
        """
        if len(self.noises) > 1:
            raise CompatibilityError(f"there is a noise for each of {', '.join(self.noises)}: see noises")
        return next(iter(self.noises.values()))

    def _of_noise(self, number: int | None) -> tuple[str, float]:
        """Unit of the residuals with that noise, and how large the model says it is."""
        channels = self.model.channels
        if number is not None and len(channels) == self.model.outputs:
            channels = tuple(c for c, k in zip(channels, self.model.noises.of_outputs, strict=True) if k == number)
        alike = {(channel.unit, channel.noise) for channel in channels}
        return alike.pop() if len(alike) == 1 else (OF_MODEL, 1.0)

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the residuals: see `Estimate.freedom`."""
        return float(self.estimate.freedom)

    @property
    def half_widths(self) -> Array:
        """Half widths of the confidence intervals, (p,); by Student's t where the noise is estimated."""
        from scipy.special import ndtri, stdtrit

        tail = 0.5 * (1.0 + self.confidence)
        if self.estimate.known:
            return np.asarray(ndtri(tail) * self.estimate.standard_errors)
        freedoms = self.estimate.freedoms
        quantiles = stdtrit(np.maximum(freedoms, 1e-9), tail)
        return np.where(freedoms > 0, quantiles * self.estimate.standard_errors, np.nan)

    @cached_property
    def leverage(self) -> Array:
        """How much of itself each residual fits away, (n m,): 1 is all of it; the sum is p, or less with a prior."""
        rows, noise = self.estimate.rows, self.estimate.noise
        rows = rows if noise is None else rows / noise[:, None]
        return np.asarray(np.einsum("np,pq,nq->n", rows, self.estimate.information.covariance, rows))

    @cached_property
    def studentized(self) -> Array:
        """Residuals in units of their own standard deviation, (n m,); nan where nothing is left to judge by.

        Where the noise is estimated by least squares each residual is judged by the scatter of
        the others that have it. Source: Cook and Weisberg, Residuals and Influence in Regression (1982).
        """
        estimate, free = self.estimate, 1.0 - self.leverage
        free = np.where(free > 1e-9, free, np.nan)
        scaled = estimate.scaled
        if estimate.known or (estimate.loss.robust and estimate.sizes.size):
            return np.asarray(scaled / np.sqrt(free))
        if estimate.loss.robust:
            return np.asarray(scaled / (estimate.scale * np.sqrt(free)))
        of_noise, rest = estimate.of_noises, estimate.freedom_of_residuals - 1.0
        total = np.bincount(of_noise, scaled**2)[of_noise]
        others = (total - scaled**2 / free) / np.where(rest >= 1.0, rest, np.nan)
        return np.asarray(scaled / np.sqrt(np.maximum(others, 1e-300) * free))

    @property
    def outlying(self) -> list[int]:
        """Numbers (1 is the first) of positions that the others contradict.

        Two-sided probability of so large a studentized residual, times n (Bonferroni), below
        1 - confidence.
        """
        from scipy.special import ndtr, stdtr

        size = -np.abs(np.nan_to_num(self.studentized))
        freedom = self.estimate.freedom_of_residuals - (0 if self.estimate.loss.robust else 1)
        tail = ndtr(size) if self.estimate.known else stdtr(np.maximum(freedom, 1.0), size)
        far = 2.0 * tail * len(size) < 1.0 - self.confidence
        return [int(k) + 1 for k in np.flatnonzero(far.reshape(self.readings.n, -1).any(axis=1))]

    @property
    def chi_square(self) -> dict[str, float] | None:
        """Test of fit where the noise is known: the sum of squares, its freedom, the probability of more."""
        from scipy.special import chdtrc

        if not self.estimate.known or self.freedom <= 0:
            return None
        value, freedom = float((self.estimate.scaled**2).sum()), self.freedom
        return {"value": value, "freedom": freedom, "probability": float(chdtrc(freedom, value))}

    def summary(self) -> str:
        """One line on the noise, whether it was known, and the test of fit."""
        freedom, test = self.freedom, self.chi_square
        noises = (f"{1e3 * size:.4g} mg" if unit == "g" else f"{size:.4g} {unit}" for unit, size in self.noises.items())
        text = f"{self.readings.n} positions, noise {', '.join(noises)}"
        if test is not None:
            return (
                f"{text} (known); chi-square {test['value']:.4g} for {freedom:g}, probability {test['probability']:.3g}"
            )
        if self.estimate.known:
            return f"{text} (known)"
        told = f"{text} (estimated, {freedom:.4g} degrees of freedom)"
        return told if freedom > 0 else f"{self.readings.n} positions"

    def remarks(self) -> list[str]:
        """What somebody who relies on the calibration should know."""
        found = []
        estimate, n = self.estimate, self.readings.n
        if self.freedom <= 0 and not estimate.known:
            unit = next(iter(self.noises))
            found.append(
                f"{n} positions for {len(estimate.parameters)} parameters leave no residuals: nothing tells the noise, "
                f"so there are no standard errors; give noise=NUMBER in {unit} or more positions"
            )
        deviations = estimate.information.standard_deviations / self._unit_noise
        weak = [
            f"{parameter.name} ({deviation:.3g})"
            for parameter, deviation in zip(estimate.model.parameters, deviations, strict=True)
            if deviation > _HARDLY_SHOWN
        ]
        if weak:
            found.append(f"these positions hardly show {', '.join(weak)}: standard deviation in units of the noise")
        test = self.chi_square
        if test is not None and test["probability"] < 1.0 - self.confidence:
            ratio = np.sqrt(test["value"] / test["freedom"])
            found.append(
                f"the residuals are {ratio:.3g} times what the noise explains (chi-square probability "
                f"{test['probability']:.2g}): something else is there, and the standard errors are too small"
            )
        found += self._question_noise()
        turned = [
            parameter.name
            for parameter, value in zip(estimate.model.parameters, estimate.parameters, strict=True)
            if parameter.unit == "1" and parameter.group.endswith("scale") and value < -1.0
        ]
        if turned:
            question = "are signs and axes of what was felt right?"
            found.append(f"{', '.join(turned)} below -1, as of an axis the other way round: {question}")
        if self.outlying:
            found.append(f"outlying: position {', '.join(map(str, self.outlying))}; look at it, or take a robust loss")
        return found

    def _question_noise(self) -> list[str]:
        """A question where an estimated noise is far above what the model tells of it."""
        told = all(channel.noise != 1.0 for channel in self.model.channels)
        if self.estimate.known or self.freedom <= 0 or not told:
            return []
        sizes = np.atleast_1d(self.estimate.sizes if self.estimate.sizes.size else self.estimate.scale)
        far = [f"in {unit} {size:.3g}" for unit, size in zip(self.noises, sizes, strict=True) if size > _FAR_ABOVE]
        question = "are the settings, what the stand says of the place, and the rows those of these readings?"
        return [f"the noise is far above what the model says, {' and '.join(far)} times: {question}"] if far else []

    @property
    def _unit_noise(self) -> float:
        """The size of the noise that standard deviations come in, in units of the model's."""
        noise = self.estimate.noise
        return 1.0 if noise is None else float(np.sqrt(np.mean(noise**2)))

    @property
    def size_of_residuals(self) -> float:
        """How large the model's noise is in the unit that `noises` has for it, where there is one of them."""
        return self._of_noise(None)[1]

    @property
    def figures(self) -> dict[str, Any]:
        """Noise, and root mean square and standard deviation of the residuals, for files; names have the unit."""
        residual, (unit, *others) = self.estimate.residual, self.noises
        if others:
            return {"noise": self.noises, "residual_rms": float(np.sqrt(np.mean(self.estimate.scaled**2)))}
        size, tail = self.size_of_residuals, suffix(unit)
        return {
            f"noise_{tail}": self.noises[unit],
            f"residual_rms_{tail}": size * float(np.sqrt(np.mean(residual**2))),
            f"residual_deviation_{tail}": size * float(np.std(residual)),
        }

    def entries(self) -> dict[str, Any]:
        """Correction, parameters with standard errors and intervals, and tests of fit, for calibration.json."""
        estimate = self.estimate
        half = self.half_widths
        parameters = {
            parameter.name: {
                "group": parameter.group,
                "unit": parameter.unit,
                "estimate": float(value),
                "standard_error": float(error),
                "interval": [float(value - width), float(value + width)],
            }
            for parameter, value, error, width in zip(
                estimate.model.parameters, estimate.parameters, estimate.standard_errors, half, strict=True
            )
        }
        return {
            "correction": self.correction.entries(),
            "parameters": parameters,
            "confidence": self.confidence,
            "covariance": estimate.covariance,
            "correlations": estimate.information.correlations,
            "unit": {"name": self.unit.name, "per_g": self.unit.per_g, "offset": self.unit.offset},
            "positions": self.readings.n,
            **self.figures,
            "noise_known": estimate.known,
            "freedom": self.freedom,
            "chi_square": self.chi_square,
            "outlying": self.outlying,
            "iterations": estimate.iterations,
            "remarks": self.remarks(),
        }
