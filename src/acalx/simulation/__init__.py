"""Calibrations simulated with everything that goes wrong on a real stand."""

from acalx.simulation.campaign import Campaign, Trials
from acalx.simulation.outcome import Outcome
from acalx.simulation.procedure import default_estimator, simulate
from acalx.simulation.sources import ErrorSources

__all__ = ["Campaign", "ErrorSources", "Outcome", "Trials", "default_estimator", "simulate"]
