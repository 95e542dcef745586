"""The Monte Carlo: trials, estimates, statistics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acalx.errors import ArgumentError, Option
from acalx.estimation import Estimate, Estimator, Iterated, SingularError
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.options import is_whole, require_confidence
from acalx.quantities.information import Information
from acalx.simulation.campaign import BLOCK, Campaign
from acalx.simulation.outcome import Moments, Outcome

__all__ = ["default_estimator", "run_campaign"]

# Readings of about this many bytes are simulated at a time.
_CHUNK_BYTES = 2**21
_MOST_TRIALS = 10**8


def default_estimator(model: Model) -> Estimator:
    """Iterated least squares of what the model compares: right whatever the size of the errors is."""
    return Iterated()


def run_campaign(
    campaign: Campaign,
    estimator: Estimator,
    trials: int,
    name: str = "",
    confidence: float = 0.95,
    chunk: int | None = None,
) -> Outcome:
    """Calibrate so many simulated sensors with the program of a campaign, each with errors of its own.

    The noise is estimated from the residuals, as a calibration does; beside a prior it is known, since positions of
    which there may be as few as one do not tell it.

    Parameters
    ----------
    campaign : Campaign
    estimator : Estimator
    trials : int
        Two or more; 20000 tell standard deviations to 0.5 %.
    name : str
        Of the program, for messages.
    confidence : float
        Of limits, intervals and verdicts.
    chunk : int, optional
        So many trials at a time; it decides memory, not what comes out.

    Raises
    ------
    ArgumentError
        Less than two trials, a confidence that is none.
    CompatibilityError
        An estimator that the model does not go with.
    SingularError
        A program that can't show all the parameters.
    """
    _check_trials(trials)
    require_confidence(confidence)
    model, n = campaign.model, campaign.n
    model = estimator.model_for(model)
    compared = campaign if model is campaign.model else replace(campaign, model=model)
    information = _regular_information(compared, name)
    if chunk is None:
        chunk = _CHUNK_BYTES // (8 * n * campaign.channels)
    chunk = BLOCK * max(1, chunk // BLOCK)
    noise = campaign.sources.noise
    told = np.full(n * model.outputs, noise) if model.informed else None
    moments = Moments(len(model.parameters))
    for begin in range(0, trials, chunk):
        part = campaign.trials(begin, min(begin + chunk, trials))
        estimate = estimator.estimate(model, part.readings, part.known, told)
        half_widths = _half_widths(estimate, noise, confidence)
        error = np.where(estimate.converged[:, None], estimate.parameters, np.nan) - part.parameters
        for first in range(0, len(error), BLOCK):  # so that chunks add up to the same sums
            block = slice(first, first + BLOCK)
            moments.add(part.parameters[block], error[block], half_widths[block])
    if moments.count < 2:
        raise ArgumentError(
            f"{name}: {moments.failed} of {trials} trials ended without an estimate; are the errors right?"
        )
    return Outcome(name, n, information, noise, moments, confidence)


def _regular_information(campaign: Campaign, name: str) -> Information:
    """Information (p, p) of the program where nothing goes wrong; SingularError where it can't show everything."""
    information = _with_noise(campaign.model.information(campaign.nominal), campaign)
    if information.singular:
        unseen = information.inestimable()
        raise SingularError(
            f"{name}: its {campaign.n} positions can't estimate all the parameters; "
            f"they can't see: {'; '.join(unseen)}",
            unseen,
        )
    return information


def _with_noise(information: Information, campaign: Campaign) -> Information:
    """The same where the noise is a multiple of the model's: in units of it what a prior says counts for more."""
    if not campaign.model.informed:
        return information
    prior, noise = campaign.model.prior_information, campaign.sources.noise
    return Information(information.matrix + (noise**2 - 1.0) * np.diag(prior), information.parameters)


def _check_trials(trials: object) -> None:
    if not is_whole(trials) or not 2 <= trials <= _MOST_TRIALS:
        raise ArgumentError(
            "{given}: give a whole number of trials from 2 to {most:,}, such as 20000",
            given=Option("trials", trials),
            most=_MOST_TRIALS,
        )


def _half_widths(estimate: Estimate, noise: float, confidence: float) -> Array:
    """Half widths (T, p) of intervals as a calibration gives them: the noise estimated, where that is possible."""
    from scipy.special import ndtri, stdtrit

    tail = 0.5 * (1.0 + confidence)
    if estimate.known:
        return np.asarray(ndtri(tail) * estimate.standard_errors)
    told = estimate.freedoms > 0.0
    widths = estimate.standard_errors * stdtrit(np.where(told, estimate.freedoms, 1.0), tail)
    if not told.all():
        widths = np.where(told, widths, ndtri(tail) * noise * estimate.information.standard_deviations)
    return np.broadcast_to(widths, estimate.parameters.shape)
