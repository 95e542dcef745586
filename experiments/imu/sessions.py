"""What static positions of real inertial sensors show, and what they can't."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from programs import MODEL
from resting import RestingGyros

from acalx.estimation import Calibration, Readings, SingularError, Unit, calibrate, read_groups, read_readings
from acalx.models import Agreement, Compared, ScalarAccel, as_model
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import parameter_groups
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import AccelArray, GyroTriad
from acalx.validation.comparison import directions_of
from acalx.validation.subsets import efficiency

__all__ = [
    "SESSIONS",
    "TRIADS",
    "Session",
    "Sessions",
    "arrays",
    "boards",
    "left_out_of_mean",
    "random_order",
    "unseen",
    "visited",
]

SESSIONS, TRIADS = 9, 8
COUNTS, RATE_COUNTS = Unit("counts", 2048.0), Unit("counts", 16.4)
METERS, RADIANS = Unit("m/s^2", 9.80665), Unit("rad/s", math.radians(1.0))
# Of the samples of a gyro, as of a hand that holds it: a position in which it moved is none.
MOVED_RAD_S = 0.02
TIMES = ("t_start_s", "t_end_s")


@dataclass(frozen=True, eq=False)
class Session:
    """A unit in the positions of one session.

    Parameters
    ----------
    accel, gyro : Readings
        Of the same positions.
    times : array (n,), s
        The middle of each.
    units : pair of Unit
        Of the readings of the accelerometers and of the gyros.
    """

    accel: Readings
    gyro: Readings
    times: Array
    units: tuple[Unit, Unit]

    @cached_property
    def calibration(self) -> Calibration:
        """The accelerometers by the magnitude of gravity, nine parameters."""
        return calibrate(self.accel, ScalarAccel(), unit=self.units[0])

    @cached_property
    def vertical(self) -> Array:
        """The vertical in sensor axes, from the calibrated accelerometers, (n, 3)."""
        return directions_of(self.calibration)

    def gyros(self, sensor: RestingGyros) -> Calibration:
        """The gyros at rest."""
        middle = 0.5 * (self.times.min() + self.times.max())
        time = (self.times - middle)[:, None] / np.ptp(self.times)
        felt = Stimulus(specific_force=self.vertical, temperature=time)
        return calibrate(replace(self.gyro, stimulus=felt), sensor, unit=self.units[1])


class Sessions:
    """The data sets of a directory, session by session."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory

    @cached_property
    def mimu(self) -> dict[tuple[int, int], Session]:
        """The units of the array by session and number, from 1."""
        path, by = self.directory / "mimu4444_static.csv", ["experiment", "imu"]
        accel, gyro = read_groups(path, by), read_groups(path, by, ("gx", "gy", "gz"))
        times = read_groups(path, by, TIMES)
        units = COUNTS, RATE_COUNTS
        return {
            (int(key[0]), int(key[1])): Session(accel[key], gyro[key], times[key].means.mean(axis=1), units)
            for key in accel
        }

    @cached_property
    def mikoff(self) -> list[tuple[Session, int]]:
        """The five units, each with the number of positions in which it moved and which are left out."""
        return [self._mikoff(self.directory / f"mikoff_mpu9150_{k}_static.csv") for k in range(5)]

    def _mikoff(self, path: Path) -> tuple[Session, int]:
        accel, gyro = read_readings(path), read_readings(path, ("m_gx", "m_gy", "m_gz"))
        spread = read_readings(path, ("s_gx", "s_gy", "s_gz")).means.max(axis=1)
        still = np.flatnonzero(spread < MOVED_RAD_S)
        times = read_readings(path, TIMES).means.mean(axis=1)
        session = Session(accel.select(still), gyro.select(still), times[still], (METERS, RADIANS))
        return session, accel.n - len(still)


def left_out(calibration: Calibration) -> float:
    """Root mean square of the residuals of each position when it is left out, deg/s."""
    residual, leverage = calibration.estimate.residual, calibration.leverage
    return float(np.sqrt(np.mean((residual / (1.0 - leverage)) ** 2)))


def left_out_of_mean(session: Session) -> float:
    """The same of a bias alone."""
    values, n = session.gyro.means / session.units[1].per_channel(MODEL.channels[3:]), session.gyro.n
    return float(np.sqrt(np.mean(((values - values.mean(axis=0)) * n / (n - 1)) ** 2)))


def of_group(calibration: Calibration, group: str) -> tuple[Array, Array]:
    """Estimates and standard errors of a group."""
    members = parameter_groups(calibration.estimate.model.parameters)[group]
    return calibration.estimate.parameters[members], calibration.estimate.standard_errors[members]


def boards(sessions: Sequence[Session], sensor: RestingGyros) -> dict[str, Array]:
    """Of each session noise, error on positions left out, estimates and standard errors by group, in deg/s and g."""
    found = [session.gyros(sensor) for session in sessions]
    names = list(parameter_groups(sensor.parameters))
    out = {
        "noise": np.array([one.noise for one in found]),
        "left_out": np.array([left_out(one) for one in found]),
    }
    for name in names:
        values, errors = zip(*(of_group(one, name) for one in found), strict=True)
        out |= {name: np.array(values), f"{name}_error": np.array(errors)}
    return out


def visited(sessions: Sequence[Session]) -> tuple[float, float, float]:
    """Median efficiencies against even positions.

    Of the magnitude; of gyros at rest; and the share of the information on the g-sensitivities that is left
    where a drift has to be told from them, by the order of the positions.
    """
    gyros = as_model(RestingGyros())
    shares = []
    for session in sessions:
        alone, drifting = (session.gyros(RestingGyros(drift=drift)) for drift in (False, True))
        errors = [
            one.estimate.information.variances[parameter_groups(one.estimate.model.parameters)["g_sensitivity"]].mean()
            for one in (alone, drifting)
        ]
        shares.append(errors[0] / errors[1])
    by_length = [float(efficiency(session.vertical, ScalarAccel())) for session in sessions]
    by_force = [float(efficiency(session.vertical, gyros)) for session in sessions]
    return float(np.median(by_length)), float(np.median(by_force)), float(np.median(shares))


def random_order(session: Session, orders: int = 500) -> float:
    """The last of these, had the positions been visited at the same times in another order: median of random ones."""
    rng, model = np.random.default_rng(0), as_model(RestingGyros(drift=True))
    still = as_model(RestingGyros()).information(Stimulus(specific_force=session.vertical))
    time = (session.times - session.times.mean()) / np.ptp(session.times)
    times = rng.permuted(np.tile(time, (orders, 1)), axis=1)[..., None]
    vertical = np.broadcast_to(session.vertical, (orders, *session.vertical.shape))
    drifting = model.information(Stimulus(specific_force=vertical, temperature=times))
    shares = [one.variances[..., one.group("g_sensitivity")].mean(axis=-1) for one in (still, drifting)]
    return float(np.median(shares[0] / shares[1]))


def unseen(session: Session) -> tuple[str, list[str]]:
    """What acalx says of a gyro triad at rest, and the combinations of a whole unit that it can't see."""
    vertical = session.vertical
    still = Stimulus(
        specific_force=vertical, angular_rate=np.zeros_like(vertical), angular_acceleration=np.zeros_like(vertical)
    )
    said = "nothing is missing"
    try:
        calibrate(replace(session.gyro, stimulus=still), GyroTriad(), unit=session.units[1])
    except SingularError as error:
        said = str(error).partition(": ")[2].partition(". Visit")[0]
    return said, MODEL.information(still).inestimable()


def in_axes_of_the_first(readings: Array, triad: int) -> Array:
    """Readings (n, 3) of a triad in axes of the first: every other unit is below the board, upside down."""
    return readings if triad % 2 else -readings[:, [1, 0, 2]]


def arrays(mimu: dict[tuple[int, int], Session], chosen: Sequence[int], session: int = 1) -> Calibration:
    """Several triads of the board in a session, which felt the same gravity, as one array."""
    means = [in_axes_of_the_first(mimu[session, triad].accel.means, triad) for triad in chosen]
    model = Compared(AccelArray(triads=len(chosen), noise_g=1e-3), Agreement())
    name = "triads " + ", ".join(map(str, chosen))
    return calibrate(Readings(name, np.concatenate(means, axis=1)), model, unit=COUNTS)
