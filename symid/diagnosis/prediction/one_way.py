"""Logs with one direction of motion, which do not separate dry friction from a constant force in the same joint."""

from collections.abc import Mapping, Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis, Body, CoulombFriction, OffsetForce, Position
from symid.data import Log

_BACK = 0.002
"""Largest way back, relative to the stroke, of a motion in one direction: encoders and rests show some."""


def indistinct_constant_forces(
    axis: Axis, logs: Sequence[Log], nominal: Mapping[str, float] | None
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Constant forces that logs do not distinguish from dry friction, with the values to take, and notes.

    If both were free, they would grow without bound with opposite signs. The constant force is given its nominal value,
    or 0.

    >>> from symid import Drive, Position
    >>> table = Body("table", mass="M")
    >>> laws = (CoulombFriction(table, "Fc"), OffsetForce(table, "OF"))
    >>> axis = Axis("slide", (table, *laws), Drive("F", table), (Position("q", table),))
    >>> log = Log.from_arrays({"q": np.arange(50.0) ** 2, "F": np.ones(50)}, sampling_period=0.1)
    >>> indistinct_constant_forces(axis, [log], {"OF": 3.0})
    ({'OF': 3.0}, ('q goes one way only, in which OF and Fc are one force: OF is taken as 3 N.',))
    """
    known, notes = dict[str, float](), list[str]()
    free = axis.physical_parameters
    for sensor in axis.sensors:
        if not isinstance(sensor, Position) or sensor.relative_to is not None:
            continue
        if not _is_one_way(logs, sensor.signal):
            continue
        dry, constant = (
            [
                term.parameter
                for law in axis.laws
                if isinstance(law, kind) and isinstance(law.at, Body) and law.at == sensor.body
                for term in law.terms()
                if term.parameter in free
            ]
            for kind in (CoulombFriction, OffsetForce)
        )
        for name in constant if dry else ():
            known[name] = float((nominal or {}).get(name, 0.0))
            notes.append(
                f"{sensor.signal} goes one way only, in which {name} and {dry[0]} are one force: {name} is taken as "
                f"{known[name]:.4g} {free[name]}."
            )
    return known, tuple(notes)


def _is_one_way(logs: Sequence[Log], name: str) -> bool:
    """Whether a position never goes back, in all logs alike."""

    def way_back(q: FloatArray) -> float:
        return float(np.max(np.maximum.accumulate(q) - q))

    return all(name in log.signals for log in logs) and any(
        all(way_back(sign * log[name]) < _BACK * np.ptp(log[name]) for log in logs) for sign in (1.0, -1.0)
    )
