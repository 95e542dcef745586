"""Where measurements of real sensors are; tests that need them skip where they are not."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from acalx.estimation import Unit

MEASURED = Path(os.environ.get("ACALX_DATA", Path(__file__).parents[2] / "shared" / "data")) / "measured"

needs_measured = pytest.mark.skipif(
    not MEASURED.is_dir(), reason="no measurements here; ACALX_DATA says where they are"
)

MIMU = MEASURED / "mimu4444_static.csv"
MIKOFF = [MEASURED / f"mikoff_mpu9150_{k}_static.csv" for k in range(5)]
XSENS, XSENS_RAW = MEASURED / "imu_tk_xsens_static.csv", MEASURED / "imu_tk_xsens_raw.csv"
FERRARIS = MEASURED / "imucal_ferraris_static.csv"

METERS = Unit("m/s^2", 9.80665)
MIMU_COUNTS = Unit("counts", 2048.0)
XSENS_COUNTS = Unit("counts", None)
