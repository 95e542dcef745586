"""What a sensor and its stand cost in code lines, and that they cost nothing elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import acalx
from costs import code_lines

ROOT = Path(acalx.__file__).parent
PAGE = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")

ONE_AXIS = '''
"""A gyro that feels the temperature."""

from dataclasses import dataclass

from acalx import Parameter, Polynomial, Term


@dataclass(frozen=True)
class WarmGyro(Polynomial):
    """It reads W = bias + (1 + scale) wz + drift t, in units of its noise."""

    @property
    def terms(self):
        """What it reads without errors, then each parameter."""
        return (
            Term(None, "wz"),
            Term(Parameter("bias", "bias", "1")),
            Term(Parameter("scale", "scale", "1"), "wz"),
            Term(Parameter("drift", "drift", "1/degC"), "t"),
        )
'''
EXAMPLE = re.search(r"```python cubic.py\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)

# Files with the code lines that each may have, and what they are called.
SHIPPED = {
    "sensors/imu.py": (43, "IMU"),
    "stands/two_axis_rate_table.py": (17, "TwoAxisRateTable"),
    "sensors/accel_temperature.py": (20, "AccelTemperature"),
    "stands/chamber.py": (20, "Chamber"),
}


def test_what_counts() -> None:
    assert (
        code_lines('"""A module."""\n\nimport math\n\n# why\nX = 1\n\n\n@final\nclass A:\n    """It."""\n\n    x = 1\n')
        == 3
    )
    assert code_lines("@dataclass(\n    frozen=True,\n)\nclass A:\n    x = (\n        1,\n    )\n") == 4


def test_a_polynomial_sensor_costs_a_few_lines() -> None:
    assert EXAMPLE is not None
    assert code_lines(EXAMPLE[1]) <= 15
    assert code_lines(ONE_AXIS) <= 15


@pytest.mark.parametrize("path", SHIPPED)
def test_a_shipped_part_costs_no_more_than_it_does(path: str) -> None:
    most, _ = SHIPPED[path]
    assert code_lines((ROOT / path).read_text(encoding="utf-8")) <= most


@pytest.mark.parametrize("path", SHIPPED)
def test_a_shipped_part_touches_no_other_module(path: str) -> None:
    _, name = SHIPPED[path]
    module = Path(path).stem
    for other in ROOT.rglob("*.py"):
        if other != ROOT / path:
            text = other.read_text(encoding="utf-8")
            assert not re.search(rf"\b{name}\b", text), other
            assert not re.search(rf"import\b.*\b{module}\b|\b{module} import\b", text), other
