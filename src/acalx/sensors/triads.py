"""What triads have in common: three channels along three axes, nearly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from acalx.errors import ArgumentError
from acalx.quantities.parameter import Parameter
from acalx.sensors.polynomial import Term

__all__ = [
    "GROUPS",
    "ORDERS",
    "SHAPES",
    "axis_terms",
    "g_sensitivity_terms",
    "part_terms",
    "require_triad",
    "triangular_terms",
]

# The matrix between what is felt and what is read: with the attitude unknown only its size and its angles can be
# told, so three of the six misalignments are taken for zero.
SHAPES = ("triangular", "full")
# Of a channel in its own component: linear, with its square, with its cube too.
ORDERS = (1, 2, 3)
_POWERS = {2: ("quadratic", "/{unit}"), 3: ("cubic", "/{unit}^2")}
PAIRS = ("xy", "xz", "zy")
GROUPS = ("bias", "scale", "nonorthogonality")
# How much inexpensive triads differ, in their units; of a bias in any unit but these 1 %.
_SCATTER = {
    "scale": 0.01,
    "nonorthogonality": 0.01,
    "misalignment": 0.01,
    "quadratic": 1e-3,
    "cubic": 1e-3,
    "g_sensitivity": 0.05,
}
_BIAS = {"g": 0.02, "field": 0.05, "deg/s": 0.5}


def _parameter(name: str, group: str, unit: str) -> Parameter:
    scatter = _BIAS.get(unit, 0.01) if group == "bias" else _SCATTER[group]
    return Parameter(name, group, unit, scatter=scatter)


def require_triad(matrix: object, order: object) -> None:
    """Raise ArgumentError for a shape of the matrix, or an order, that there is not."""
    if matrix not in SHAPES:
        raise ArgumentError.of("matrix", matrix, f"give one of {', '.join(SHAPES)}")
    if order not in ORDERS or isinstance(order, bool):
        raise ArgumentError.of("order", order, "give 1, 2 or 3, the highest power of what is felt along an axis")


def triangular_terms(
    letter: str, unit: str, groups: Sequence[str], order: int = 1, factor: float = 1.0
) -> tuple[Term, ...]:
    """W = bias + (I + diag(scale) + N) s, N = [[0, xy, xz], [0, 0, 0], [0, zy, 0]]: group by group, axis by axis."""
    terms = [Term(None, letter + axis, factor, k) for k, axis in enumerate("xyz")]
    if "bias" in groups:
        terms += [Term(_parameter(f"bias_{axis}", "bias", unit), (), 1.0, k) for k, axis in enumerate("xyz")]
    if "scale" in groups:
        terms += [
            Term(_parameter(f"scale_{axis}", "scale", "1"), letter + axis, factor, k) for k, axis in enumerate("xyz")
        ]
    if "nonorthogonality" in groups:
        terms += [
            Term(_parameter(f"nonorthogonality_{pair}", "nonorthogonality", "rad"), letter + pair[1], factor, own)
            for pair in PAIRS
            for own in ("xyz".index(pair[0]),)
        ]
    return (*terms, *(term for k, axis in enumerate("xyz") for term in _powers(letter, unit, axis, k, order, factor)))


def axis_terms(letter: str, unit: str, axis: str, channel: int, order: int = 1, factor: float = 1.0) -> list[Term]:
    """One channel of W = bias + (I + diag(scale) + M) s, with a full matrix M of misalignments."""
    return [
        Term(None, letter + axis, factor, channel),
        Term(_parameter(f"bias_{axis}", "bias", unit), (), 1.0, channel),
        Term(_parameter(f"scale_{axis}", "scale", "1"), letter + axis, factor, channel),
        *(
            Term(_parameter(f"misalignment_{axis}{other}", "misalignment", "rad"), letter + other, factor, channel)
            for other in "xyz"
            if other != axis
        ),
        *_powers(letter, unit, axis, channel, order, factor),
    ]


def g_sensitivity_terms(axis: str, channel: int) -> list[Term]:
    """What the specific force does to a gyro."""
    return [
        Term(_parameter(f"g_sensitivity_{axis}{other}", "g_sensitivity", "deg/s/g"), f"f{other}", 1.0, channel)
        for other in "xyz"
    ]


def part_terms(terms: Iterable[Term], prefix: str, first: int, *, grouped: bool = True) -> list[Term]:
    """Terms of a part of a sensor, from those that it has alone.

    Parameters
    ----------
    terms : iterable of Term
    prefix : str
        Before the names of the parameters here.
    first : int
        The number of its first channel here.
    grouped : bool
        Whether the groups have the prefix too.
    """

    def here(own: Parameter) -> Parameter:
        return replace(own, name=prefix + own.name, group=prefix * grouped + own.group)

    return [replace(t, parameter=t.parameter and here(t.parameter), channel=t.channel + first) for t in terms]


def _powers(letter: str, unit: str, axis: str, channel: int, order: int, factor: float) -> list[Term]:
    """The square, and the cube, of what is felt along an axis, in the unit of the channel."""
    return [
        Term(
            _parameter(f"{name}_{axis}", name, "1" + per.format(unit=unit)),
            " ".join([letter + axis] * n),
            factor**n,
            channel,
        )
        for n, (name, per) in _POWERS.items()
        if n <= order
    ]
