"""Unit of a position or a velocity from the other one, whose unit is known: one is the rate of the other."""

from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from symid.arrays import FloatArray
from symid.errors import LogError
from symid.units import Unit, to_si

PositionOrVelocity = Literal["position", "velocity"]

_POSITIONS: Final = MappingProxyType({"rad": ("rad", "deg", "turn"), "m": ("m", "mm", "um")})
_VELOCITIES: Final = MappingProxyType(
    {"rad": ("rad/s", "deg/s", "rpm", "turn/s"), "m": ("m/s", "mm/s", "mm/min", "m/min")}
)
_ALIKE, _CLOSE = 0.98, 0.05
"""Least correlation of a position with the integral of its velocity, and largest error of a factor between them: a
stated speed may be that of another shaft, and the next unit is off by 1.6 or more."""
_MOST_ROWS = 200_000


def unit_by_motion(
    position: FloatArray,
    velocity: FloatArray,
    time: FloatArray,
    known: PositionOrVelocity,
    unit: str,
) -> str | None:
    """Unknown unit of a position or of a velocity, from the other one; None if the data do not decide.

    Parameters
    ----------
    position, velocity : array of shape (n,)
        Both in their units.
    time : array of shape (n,)
        In seconds.
    known : 'position' or 'velocity'
        The one whose unit is known.
    unit : str
        That unit.

    Examples
    --------
    >>> t = np.arange(2000) / 1000
    >>> turns, rpm = 0.4 * np.sin(9 * t), 0.4 * 60 * 9 * np.cos(9 * t)
    >>> unit_by_motion(turns, rpm, t, "velocity", "rpm"), unit_by_motion(turns, rpm, t, "position", "turn")
    ('turn', 'rpm')
    >>> unit_by_motion(turns, 3 * rpm, t, "velocity", "rpm")  # of a motor behind a gear
    """
    stride = max(1, time.size // _MOST_ROWS)
    q, v, t = position[::stride], velocity[::stride], time[::stride]
    if t.size < 3 or not np.all(np.diff(t) > 0):
        return None
    way = np.append(0.0, np.cumsum((v[1:] + v[:-1]) / 2 * np.diff(t)))
    # The zero of the position and the offset of the velocity are unknown: without their straight lines, the position is
    # proportional to the integral of its velocity.
    q, way = (x - np.polyval(np.polyfit(t - t[0], x, 1), t - t[0]) for x in (q, way))
    sizes = float(np.linalg.norm(q)), float(np.linalg.norm(way))
    if min(sizes) == 0.0 or not float(q @ way) > _ALIKE * sizes[0] * sizes[1]:
        return None
    ratio = sizes[1] / sizes[0]  # of units
    # The known unit is a linear or an angular one, which decides the candidates for the other.
    for base in _POSITIONS:
        here, there = _POSITIONS[base], _VELOCITIES[base]
        wanted, candidates = (f"{base}/s", here) if known == "velocity" else (base, there)
        if (known_factor := _factor(unit, wanted)) is None:
            continue
        factor = known_factor * ratio if known == "velocity" else known_factor / ratio
        target = base if known == "velocity" else f"{base}/s"
        return next(
            (name for name in candidates if abs(factor / to_si(name, Unit.of(target)) - 1) < _CLOSE), None
        )
    return None


def _factor(unit: str, wanted: str) -> float | None:
    try:
        return to_si(unit, Unit.of(wanted))
    except LogError:
        return None
