"""The sensors in a log, and the position next to each drive."""

from collections.abc import Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.errors import LogError, SettingError
from symid.simulation import ForwardDynamics


def signals_of(dynamics: ForwardDynamics, log: Log) -> tuple[str, ...]:
    """Sensors in a log, first the position that moves most with each drive."""
    present = [name for name in dynamics.sensors if name in log.signals]
    positions = [name for name in present if dynamics.sensors[name][1] == 0]
    if not positions:
        declared = [name for name, sensor in dynamics.sensors.items() if sensor.order == 0]
        way = f"such as {declared[0]}" if declared else "declare one or a speed, and log it"
        raise LogError(f"log {log.source!r} has no position: a diagnosis needs one, {way}")
    drives, driven = _drive_directions(dynamics), list[str]()
    if np.linalg.matrix_rank(drives) < len(drives):
        names = [drive.signal for drive in dynamics.axis.drives]
        raise SettingError(
            f"drives {', '.join(names)} of axis {dynamics.axis.name!r} push the same way, so that the motion "
            "determines their sum alone: log the sum, and declare one drive, or an elastic part between them"
        )
    for drive in drives:
        left = [name for name in positions if _independent(dynamics, (*driven, name))]
        if not left:
            raise LogError(
                f"log {log.source!r} has independent positions {', '.join(driven)}: a diagnosis of {len(drives)} "
                "drives needs one for each"
            )
        driven.append(max(left, key=lambda name: _collocation(drive, dynamics.sensors[name][0])))
    return *driven, *(name for name in present if name not in driven)


def _drive_directions(dynamics: ForwardDynamics) -> FloatArray:
    """Factors of each drive force on the bodies, at parameters of 1, of shape (n_drives, n_bodies)."""
    ones = np.ones(len(dynamics.generators))
    return np.array([[effect.at(ones) for effect in row] for row in dynamics.drives]).T


def _independent(dynamics: ForwardDynamics, names: Sequence[str]) -> bool:
    """Whether the readings of sensors are linearly independent."""
    return bool(np.linalg.matrix_rank(np.stack([dynamics.sensors[name][0] for name in names])) == len(names))


def _collocation(drive: FloatArray, row: FloatArray) -> float:
    """Collocation of a sensor with a drive: the cosine of both directions."""
    return float(abs(drive @ row) / (np.linalg.norm(drive) * np.linalg.norm(row)))
