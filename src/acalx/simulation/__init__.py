"""Calibrations simulated with everything that goes wrong on a real stand."""

from acalx.simulation.campaign import Campaign, Trials
from acalx.simulation.monte_carlo import default_estimator, run_campaign
from acalx.simulation.outcome import Outcome
from acalx.simulation.procedure import Simulated, find_programs, simulate
from acalx.simulation.sources import ErrorSources

__all__ = [
    "Campaign",
    "ErrorSources",
    "Outcome",
    "Simulated",
    "Trials",
    "default_estimator",
    "find_programs",
    "run_campaign",
    "simulate",
]
