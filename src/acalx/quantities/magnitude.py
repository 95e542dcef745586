"""Positive figures of any size, kept as logarithms: a determinant of 36 coefficients is no double."""

from __future__ import annotations

import math

__all__ = ["double_of", "from_log", "significant", "with_decimals", "written_from_log"]

# Decimal exponents between which figures are written without one.
_PLAIN = (-5, 7)


def from_log(log: float) -> float:
    """exp(log) as a double: 0 or inf where it is out of range.

    Examples
    --------
    >>> from_log(-2000.0), from_log(2000.0)
    (0.0, inf)
    """
    try:
        return math.exp(log)
    except OverflowError:
        return math.inf


def with_decimals(value: float, decimals: int = 4, digits: int = 4) -> str:
    """A figure with so many decimals, or with so many significant digits where those would be fewer.

    Examples
    --------
    >>> with_decimals(0.584), with_decimals(1.4077123), with_decimals(0.01234567), with_decimals(1.4077e-12)
    ('0.5840', '1.4077', '0.01235', '1.408e-12')
    """
    plain = f"{value:.{decimals}f}"
    ordinary = 10.0 ** (digits - decimals - 1) <= abs(value) < 10.0 ** _PLAIN[1]
    return plain if ordinary and math.isfinite(value) else significant(value, digits)


def double_of(log: float) -> float | None:
    """exp(log) for a record: None where no double holds it, since 0 would be false."""
    value = from_log(log)
    return value if 0.0 < value < math.inf else None


def written_from_log(log: float, digits: int = 6) -> str:
    """exp(log) with so many significant digits, whatever its size.

    Examples
    --------
    >>> written_from_log(math.log(0.048931522), 7), written_from_log(-2000.0)
    ('0.04893152', '2.57654e-869')
    """
    if math.isnan(log) or math.isinf(log):
        return f"{from_log(log):g}"
    if abs(log) < 690.0:
        return f"{math.exp(log):.{digits}g}"
    exponent = math.floor(log / math.log(10.0))
    mantissa = f"{math.exp(log - exponent * math.log(10.0)):.{digits}g}"
    if float(mantissa) >= 10.0:  # rounded up
        mantissa, exponent = f"{float(mantissa) / 10.0:.{digits}g}", exponent + 1
    return f"{mantissa}e{exponent:+03d}"


def significant(value: float, digits: int = 4) -> str:
    """A figure with so many significant digits at 1e-12 as at 1e3, zeros at the end included.

    Examples
    --------
    >>> significant(0.584), significant(1.4077e-12), significant(1234.5), significant(0.0)
    ('0.5840', '1.408e-12', '1234', '0')
    """
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    scientific = f"{value:.{digits - 1}e}"
    exponent = int(scientific.partition("e")[2])
    if not _PLAIN[0] < exponent < _PLAIN[1]:
        return scientific
    return f"{value:.{max(0, digits - 1 - exponent)}f}"
