"""acalx designs calibration programs for inertial sensors and says how good they are.

The names below are imported when they are first used, so that ``import acalx`` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from acalx.lazy import names_from

if TYPE_CHECKING:
    from acalx.criteria import A, Criterion, D, E, Inequality, Objectives, Product, Target
    from acalx.errors import AcalxError
    from acalx.estimation import (
        Calibration,
        Correction,
        Estimator,
        Iterated,
        Linear,
        Readings,
        StaticIntervals,
        Unit,
        read_correction,
        read_readings,
    )
    from acalx.models import (
        Composite,
        GyroRateTable,
        Joined,
        Model,
        Platform,
        PlatformAccel,
        PlatformGyro,
        Polynomial,
        ScalarAccel,
        ScalarAccelQuadratic,
        Term,
        VectorAccel,
    )
    from acalx.optimizers import (
        NSGA2,
        Convex,
        DifferentialEvolution,
        Exchange,
        Gradient,
        Optimizer,
        Scalarized,
        Traversal,
    )
    from acalx.planning.metrics import figures_of_merit
    from acalx.problem import Problem
    from acalx.programs import Program, find_program, published, read_program
    from acalx.quantities.information import Information
    from acalx.quantities.parameter import Parameter
    from acalx.quantities.stimulus import Stimulus
    from acalx.search.result import Front, Result, Survey
    from acalx.simulation import Campaign, ErrorSources
    from acalx.stands import PlatformGimbals, RateTable, Setting, Stand, TwoAxis

__version__ = "0.1.0"

__all__ = [
    "NSGA2",
    "A",
    "AcalxError",
    "Calibration",
    "Campaign",
    "Composite",
    "Convex",
    "Correction",
    "Criterion",
    "D",
    "DifferentialEvolution",
    "E",
    "ErrorSources",
    "Estimator",
    "Exchange",
    "Front",
    "Gradient",
    "GyroRateTable",
    "Inequality",
    "Information",
    "Iterated",
    "Joined",
    "Linear",
    "Model",
    "Objectives",
    "Optimizer",
    "Parameter",
    "Platform",
    "PlatformAccel",
    "PlatformGimbals",
    "PlatformGyro",
    "Polynomial",
    "Problem",
    "Product",
    "Program",
    "RateTable",
    "Readings",
    "Result",
    "ScalarAccel",
    "ScalarAccelQuadratic",
    "Scalarized",
    "Setting",
    "Stand",
    "StaticIntervals",
    "Stimulus",
    "Survey",
    "Target",
    "Term",
    "Traversal",
    "TwoAxis",
    "Unit",
    "VectorAccel",
    "figures_of_merit",
    "find_program",
    "published",
    "read_correction",
    "read_program",
    "read_readings",
]

_HOMES = {
    "acalx.criteria": ("A", "Criterion", "D", "E", "Inequality", "Objectives", "Product", "Target"),
    "acalx.errors": ("AcalxError",),
    "acalx.estimation": (
        "Calibration",
        "Correction",
        "Estimator",
        "Iterated",
        "Linear",
        "Readings",
        "StaticIntervals",
        "Unit",
        "read_correction",
        "read_readings",
    ),
    "acalx.quantities.information": ("Information",),
    "acalx.quantities.parameter": ("Parameter",),
    "acalx.search.result": ("Front", "Result", "Survey"),
    "acalx.planning.metrics": ("figures_of_merit",),
    "acalx.models": (
        "Composite",
        "GyroRateTable",
        "Joined",
        "Model",
        "Platform",
        "PlatformAccel",
        "PlatformGyro",
        "Polynomial",
        "ScalarAccel",
        "ScalarAccelQuadratic",
        "Term",
        "VectorAccel",
    ),
    "acalx.optimizers": (
        "NSGA2",
        "Convex",
        "DifferentialEvolution",
        "Exchange",
        "Gradient",
        "Optimizer",
        "Scalarized",
        "Traversal",
    ),
    "acalx.problem": ("Problem",),
    "acalx.programs": ("Program", "find_program", "published", "read_program"),
    "acalx.simulation": ("Campaign", "ErrorSources"),
    "acalx.stands": ("PlatformGimbals", "RateTable", "Setting", "Stand", "TwoAxis"),
    "acalx.quantities.stimulus": ("Stimulus",),
}


__getattr__ = names_from(__name__, _HOMES)
