"""What the measured units showed, as tables and figures for the page."""

from __future__ import annotations

import numpy as np
from resting import RestingGyros
from sessions import (
    SESSIONS,
    TRIADS,
    Session,
    Sessions,
    arrays,
    boards,
    left_out_of_mean,
    random_order,
    unseen,
    visited,
)

from acalx.estimation import Calibration
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import parameter_groups
from acalx.reporting.tables import markdown

__all__ = ["array_parts", "gyro_parts", "visited_parts"]

SETS = {"mimu4444": "mimu4444, 72", "mikoff": "mpu9150, 5"}


def _sets(sessions: Sessions) -> dict[str, list[Session]]:
    return {"mimu4444": list(sessions.mimu.values()), "mikoff": [session for session, _ in sessions.mikoff]}


def visited_parts(sessions: Sessions) -> dict[str, str]:
    """How efficient the positions were, and their order; what they can't show; the noise."""
    head = ["units", "positions", "accelerometers", "gyros at rest", "with a drift, as visited", "in random order"]
    rows, parts = [head], {}
    for name, each in _sets(sessions).items():
        by_length, by_force, share = visited(each)
        shuffled = random_order(each[0])
        counts = sorted({session.accel.n for session in each})
        cells = [f"{100 * value:.1f} %" for value in (by_length, by_force, share, shuffled)]
        rows.append([SETS[name], " and ".join(map(str, counts)), *cells])
        parts |= {f"share_{name}": f"{100 * share:.0f}", f"shuffled_{name}": f"{100 * shuffled:.0f}"}
        parts[f"accel_noise_{name}"] = f"{1e3 * np.median([session.calibration.noise for session in each]):.2f}"
        parts[f"efficiency_{name}"] = f"{100 * by_length:.0f}"
    said, combinations = unseen(sessions.mimu[1, 1])
    moved = [count for _, count in sessions.mikoff]
    return parts | {
        "visited": markdown(rows),
        "said": said,
        "unseen_count": str(len(combinations)),
        "unseen": ", ".join(combinations),
        "moved": str(sum(moved)),
    }


def gyro_parts(sessions: Sessions) -> dict[str, str]:
    """Gyros at rest, with and without a drift."""
    rows = [["units, what is estimated", "left out, mdeg/s", "noise", "g-sensitivity", "standard error", "beyond two"]]
    between = [["mimu4444", "g-sensitivity", "between sessions", "standard error", "bias between sessions"]]
    parts = {}
    for name, each in _sets(sessions).items():
        alone = float(np.median([left_out_of_mean(session) for session in each]))
        rows.append([f"{SETS[name]}: bias", f"{1e3 * alone:.1f}", "", "", "", ""])
        parts[f"alone_{name}"] = f"{1e3 * alone:.1f}"
        for drift in (False, True):
            found = boards(each, RestingGyros(drift=drift))
            value, error = found["g_sensitivity"], found["g_sensitivity_error"]
            cells = [f"{1e3 * np.median(found[key]):.1f}" for key in ("left_out", "noise")]
            cells += [f"{1e3 * _rms(one):.1f}" for one in (value, error)]
            beyond = f"{100 * np.mean(np.abs(value) > 2 * error):.0f} %"
            title = "and drift" if drift else "and g-sensitivity"
            rows.append([f"{SETS[name]}: {'bias, g-sensitivity ' if drift else 'bias '}{title}", *cells, beyond])
            key = f"{name}_{'drift' if drift else 'still'}"
            parts |= {f"g_{key}": cells[2], f"left_{key}": cells[0], f"beyond_{key}": beyond}
            if name == "mimu4444":
                moves = [_between(found[group]) for group in ("g_sensitivity", "bias")]
                cells = [f"{1e3 * size:.1f}" for size in (_rms(value), moves[0], _rms(error), moves[1])]
                between.append([title if drift else "without drift", *cells])
                parts[f"between_{'drift' if drift else 'still'}"] = cells[1]
                parts[f"error_{'drift' if drift else 'still'}"] = cells[2]
                parts[f"noise_{'drift' if drift else 'still'}"] = f"{1e3 * np.median(found['noise']):.1f}"
    still, drifting = float(parts["g_mimu4444_still"]), float(parts["g_mimu4444_drift"])
    found = boards(_sets(sessions)["mimu4444"], RestingGyros())
    return parts | {
        "gyros": markdown(rows),
        "between": markdown(between),
        "disguise": f"{still / drifting:.0f}",
        "bias_rms": f"{_rms(found['bias']):.1f}",
        "bias_error": f"{1e3 * np.median(found['bias_error']):.1f}",
        "bias_between": f"{1e3 * _between(found['bias']):.0f}",
    }


def array_parts(sessions: Sessions) -> dict[str, str]:
    """Several triads of the board as one array, medians over the sessions."""
    head = [
        "triads",
        "parameters",
        "residuals, mg",
        "bias mg",
        "scale 1e-3",
        "non-orthogonality mrad",
        "alignment mrad",
    ]
    rows = [head]
    one = [sessions.mimu[session, 1].calibration for session in range(1, SESSIONS + 1)]
    errors = np.median([1e3 * each.estimate.standard_errors.reshape(3, 3).mean(axis=1) for each in one], axis=0)
    rows.append(["1 alone", "9", f"{1e3 * np.median([each.noise for each in one]):.2f}", *map(_digits, errors), "-"])
    parts = {"bias_one": _digits(errors[0])}
    for count in (2, 4, TRIADS):
        found = [arrays(sessions.mimu, range(1, count + 1), session) for session in range(1, SESSIONS + 1)]
        model = found[0].estimate.model
        groups = parameter_groups(model.parameters)
        first = [k for k, parameter in enumerate(model.parameters) if parameter.name.startswith("triad_1_")]
        chosen = [[k for k in groups[group] if k in first] for group in ("bias", "scale", "nonorthogonality")]
        chosen.append(groups["misalignment"])
        sizes = [[1e3 * each.estimate.standard_errors[members].mean() for members in chosen] for each in found]
        noise = 1e3 * np.median([each.noise for each in found])
        cells = [_digits(size) for size in np.median(sizes, axis=0)]
        rows.append([f"1 to {count}", str(len(model.parameters)), f"{noise:.2f}", *cells])
        parts |= {f"bias_{count}": cells[0], f"alignment_{count}": cells[-1], f"residual_{count}": f"{noise:.2f}"}
        moves = np.array([each.estimate.parameters for each in found]).std(axis=0, ddof=1)
        for group in ("misalignment", "bias"):
            move, error = (1e3 * _rms(values[groups[group]]) for values in (moves, np.median(_errors(found), axis=0)))
            parts |= {f"{group}_moves_{count}": f"{move:.2f}", f"{group}_ratio_{count}": f"{move / error:.0f}"}
    return parts | {"arrays": markdown(rows)}


def _errors(found: list[Calibration]) -> Array:
    return np.array([each.estimate.standard_errors for each in found])


def _between(values: Array) -> float:
    """Standard deviation of what a gyro showed in the sessions, (72, k) in the order of the file."""
    return float(np.sqrt(values.reshape(SESSIONS, TRIADS, -1).var(axis=0, ddof=1).mean()))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _digits(value: float) -> str:
    return f"{value:.3f}"
