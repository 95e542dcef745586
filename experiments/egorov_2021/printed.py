"""What the paper prints: figures of merit, as text, with as many digits as it gives."""

from __future__ import annotations

from decimal import Decimal

GROUPS = ("bias", "scale", "nonorthogonality")
KEYS = ("D", *(f"theta {group}" for group in GROUPS), *(f"inequality {group}" for group in GROUPS))

# In the order of KEYS, inequalities in %.
TABLE_5 = ["0.0517", "0.59", "0.79", "1.42", "0.08", "0.10", "0.09"]
PRINTED = {
    "egorov_2021_table_1": ("Table 1, optimized for D", ["0.0489", "0.59", "0.93", "1.35", "2.78", "7.90", "13.16"]),
    "axes_and_vertices_9": ("[7]: 6 faces, 3 vertices of a cube", ["0.7119", "0.71", "0.71", "2.74", "0", "0", "0"]),
    "axes_and_edges_9": ("[4, 5]: 6 faces, 3 edge midpoints", ["1.0000", "0.71", "0.71", "2.64", "0", "0", "0"]),
    "egorov_2021_table_2": ("Table 2, optimized for D", ["7.8e-5", "0.41", "0.58", "0.91", "0.03", "0.05", "0.04"]),
    "faces_and_edges_18": ("[4, 16]: 6 faces, 12 edge midpoints", ["8.6e-5", "0.41", "0.53", "1.00", "0", "0", "0"]),
    "rotations_18": ("[6]: rotations in steps of 60 deg", ["1.3e-4", "0.41", "0.48", "1.15", "0", "0", "0"]),
}

# Where each stands: by table, the numbers in front of the programs there; Table 5 has the fair one alone.
TABLES = {
    "Table 3": {"1": "egorov_2021_table_1", "3": "axes_and_vertices_9", "4": "axes_and_edges_9"},
    "Table 4": {"1": "egorov_2021_table_2", "2": "faces_and_edges_18", "3": "rotations_18"},
}


def agrees(printed: str, computed: float) -> bool:
    """Whether the computed figure, rounded to as many digits, is the printed one."""
    return Decimal(computed).quantize(Decimal(printed)) == Decimal(printed)


def smaller(computed: float, printed: str) -> bool:
    """Whether a figure is smaller than every number that rounds to the printed one."""
    half_a_unit = Decimal(5).scaleb(int(Decimal(printed).as_tuple().exponent) - 1)
    return Decimal(computed) < Decimal(printed) - half_a_unit


# Table 6: s of bias, scale and non-orthogonality, then the inequalities in %; the row of Table 5 last.
TABLE_6 = {
    "egorov_2021_table_1": ["0.59", "0.94", "1.35", "3.0", "9.1", "13.5"],
    "axes_and_vertices_9": ["0.72", "0.71", "2.76", "1.3", "0.5", "1.0"],
    "axes_and_edges_9": ["0.71", "0.71", "2.66", "1.4", "0.6", "1.1"],
    "egorov_2021_table_2": ["0.41", "0.58", "0.91", "0.7", "1.3", "0.7"],
    "faces_and_edges_18": ["0.41", "0.53", "1.01", "0.6", "0.3", "1.6"],
    "rotations_18": ["0.41", "0.48", "1.16", "1.0", "0.6", "0.8"],
}
TABLE_6_FAIR = ["0.59", "0.79", "1.43", "0.9", "1.0", "0.8"]

# Table 7: R^2 in four repetitions.
TABLE_7 = {
    "egorov_2021_table_1": ["0.9956", "0.9958", "0.9964", "0.9959"],
    "axes_and_vertices_9": ["0.9864", "0.9893", "0.9842", "0.9907"],
    "egorov_2021_table_2": ["0.9973", "0.9979", "0.9977", "0.9977"],
    "faces_and_edges_18": ["0.9952", "0.9977", "0.9956", "0.9962"],
}
