"""A calibrated sensor, and what its residuals say of the calibration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.estimation.base import Estimate
from acalx.estimation.correction import Correction
from acalx.estimation.readings import Readings
from acalx.estimation.units import Unit
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array

__all__ = ["CONFIDENCE", "Calibration"]

CONFIDENCE = 0.95
# A parameter is called hardly shown where its standard deviation is so many times the noise's.
_HARDLY_SHOWN = 30.0


@final
@dataclass(frozen=True, eq=False)
class Calibration:
    """Parameters of a sensor with their accuracy, the correction, and tests of fit.

    Parameters
    ----------
    model : ScalarAccel
    readings : Readings
    unit : Unit
        With `per_g` as found where it was not known.
    estimate : Estimate
    confidence : float
        Of the intervals; positions are called outlying at the complement, shared by all positions.
    """

    model: ScalarAccel
    readings: Readings
    unit: Unit
    estimate: Estimate
    confidence: float = CONFIDENCE

    @property
    def correction(self) -> Correction:
        """The matrix and the offset that make readings right."""
        bias, matrix = self.model.split(self.estimate.parameters)
        per_g = self.per_g
        return Correction(
            np.asarray(np.linalg.inv(matrix) / per_g, dtype=float), self.unit.offset + per_g * bias, self.unit.name
        )

    @property
    def per_g(self) -> float:
        """Units of the readings that are 1 g, to which the parameters refer."""
        assert self.unit.per_g is not None  # found, where it was not given
        return self.unit.per_g

    @property
    def noise(self) -> float:
        """Standard deviation of the residuals in g: estimated, or the mean square of the known ones."""
        if self.estimate.noise is not None:
            return float(np.sqrt(np.mean(self.estimate.noise**2)))
        return float(self.estimate.scale)

    @property
    def half_widths(self) -> Array:
        """Half widths of the confidence intervals, (p,); by Student's t where the noise is estimated."""
        from scipy.special import ndtri, stdtrit

        tail = 0.5 * (1.0 + self.confidence)
        freedom = self.estimate.freedom
        if self.estimate.noise is not None:
            return np.asarray(ndtri(tail) * self.estimate.standard_errors)
        if freedom == 0:
            return np.full(self.estimate.parameters.shape, np.nan)
        return np.asarray(stdtrit(freedom, tail) * self.estimate.standard_errors)

    @cached_property
    def leverage(self) -> Array:
        """How much of its own residual each position fits away, (n,): 1 is all of it, the sum is p."""
        rows, noise = self.estimate.rows, self.estimate.noise
        rows = rows if noise is None else rows / noise[:, None]
        return np.asarray(np.einsum("np,pq,nq->n", rows, self.estimate.information.covariance, rows))

    @cached_property
    def studentized(self) -> Array:
        """Residuals in units of their own standard deviation, (n,); nan where nothing is left to judge by.

        Where the noise is estimated by least squares each position is judged by the scatter of
        the others. Source: Cook and Weisberg, Residuals and Influence in Regression (1982).
        """
        estimate, free = self.estimate, 1.0 - self.leverage
        free = np.where(free > 1e-9, free, np.nan)
        scaled = estimate.scaled
        if estimate.noise is not None:
            return np.asarray(scaled / np.sqrt(free))
        if estimate.loss.robust:
            return np.asarray(scaled / (estimate.scale * np.sqrt(free)))
        rest = estimate.freedom - 1
        if rest < 1:
            return np.full(len(scaled), np.nan)
        others = ((scaled**2).sum() - scaled**2 / free) / rest
        return np.asarray(scaled / np.sqrt(np.maximum(others, 1e-300) * free))

    @property
    def outlying(self) -> list[int]:
        """Numbers (1 is the first) of positions that the others contradict.

        Two-sided probability of so large a studentized residual, times n (Bonferroni), below
        1 - confidence.
        """
        from scipy.special import ndtr, stdtr

        size = -np.abs(np.nan_to_num(self.studentized))
        freedom = self.estimate.freedom - (0 if self.estimate.loss.robust else 1)
        tail = ndtr(size) if self.estimate.noise is not None else stdtr(max(freedom, 1), size)
        return [int(k) + 1 for k in np.flatnonzero(2.0 * tail * self.readings.n < 1.0 - self.confidence)]

    @property
    def chi_square(self) -> dict[str, float] | None:
        """Test of fit where the noise is known: the sum of squares, its freedom, the probability of more."""
        from scipy.special import chdtrc

        if self.estimate.noise is None or self.estimate.freedom == 0:
            return None
        value, freedom = float((self.estimate.scaled**2).sum()), self.estimate.freedom
        return {"value": value, "freedom": freedom, "probability": float(chdtrc(freedom, value))}

    def summary(self) -> str:
        """One line on the noise in mg, whether it was known, and the test of fit."""
        freedom, test = self.estimate.freedom, self.chi_square
        text = f"{self.readings.n} positions, noise {1e3 * self.noise:.4g} mg"
        if test is not None:
            return (
                f"{text} (known); chi-square {test['value']:.4g} for {freedom}, probability {test['probability']:.3g}"
            )
        if self.estimate.noise is not None:
            return f"{text} (known)"
        return f"{text} (estimated, {freedom} degrees of freedom)" if freedom else f"{self.readings.n} positions"

    def remarks(self) -> list[str]:
        """What somebody who relies on the calibration should know."""
        found = []
        estimate, n = self.estimate, self.readings.n
        if estimate.freedom == 0 and estimate.noise is None:
            found.append(
                f"{n} positions for {n} parameters leave no residuals: nothing tells the noise, so there are no "
                "standard errors; give noise=NUMBER in g or more positions"
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
        if self.outlying:
            found.append(f"outlying: position {', '.join(map(str, self.outlying))}; look at it, or take a robust loss")
        return found

    @property
    def _unit_noise(self) -> float:
        return 1.0 if self.estimate.noise is None else self.noise

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
            "noise_g": self.noise,
            "noise_known": estimate.noise is not None,
            "residual_rms_g": float(np.sqrt(np.mean(estimate.residual**2))),
            "residual_deviation_g": float(np.std(estimate.residual)),
            "freedom": estimate.freedom,
            "chi_square": self.chi_square,
            "outlying": self.outlying,
            "iterations": estimate.iterations,
            "remarks": self.remarks(),
        }
