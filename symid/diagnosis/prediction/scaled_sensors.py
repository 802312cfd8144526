"""Logs of sensors whose gain or offset is a parameter, converted to the quantities that they read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from symid.axis import Axis, Sensor
from symid.codegen import model_of
from symid.data import Log
from symid.errors import SettingError, SymidError
from symid.identification import identify


class Unscaled(NamedTuple):
    """An axis and its logs after `with_quantities`."""

    axis: Axis
    logs: list[Log]
    declared: Axis  # with the gains and offsets that were taken as known
    notes: tuple[str, ...]  # sentences on the conversions


def with_quantities(axis: Axis, logs: Sequence[Log], nominal: Mapping[str, float] | None = None) -> Unscaled:
    """The axis and its logs with quantities in place of the signals of scaled sensors.

    Gains and offsets come from `nominal`, or else are identified from the first log; SettingError if it does not
    determine them.

    >>> from symid import Body, Drive, Position
    >>> table = Body("table", mass="M")
    >>> axis = Axis("t", (table,), Drive("F", table), (Position("q", table, gain="c", offset="o"),))
    >>> log = Log.from_arrays({"q": np.ones(3), "F": np.ones(3)}, sampling_period=0.1)
    >>> plain = with_quantities(axis, [log], {"M": 1.0, "c": 2.0, "o": 0.5})
    >>> plain.axis.sensors[0].gain, plain.logs[0]["q"].tolist(), plain.notes[0]
    (None, [2.5, 2.5, 2.5], 'q is taken with gain 2 and offset 0.5.')
    """
    scaled = [sensor for sensor in axis.sensors if sensor.is_scaled]
    if not scaled:
        return Unscaled(axis, list(logs), axis, ())
    read = [sensor for sensor in scaled if all(sensor.signal in log.signals for log in logs)]
    values = _values(axis, read, logs[0], nominal or {})
    notes, changed = [], list(logs)
    for sensor in read:
        gain = 1.0 if sensor.gain is None else values[sensor.named("gain")]
        offset = 0.0 if sensor.offset is None else values[sensor.named("offset")]
        changed = [
            replace(log, signals={**log.signals, sensor.signal: gain * log[sensor.signal] + offset})
            for log in changed
        ]
        notes.append(f"{sensor.signal} is taken with gain {gain:.6g} and offset {offset:.6g}.")
    plain = tuple(
        replace(sensor, gain=None, offset=None, unit=None) if sensor in read else sensor
        for sensor in axis.sensors
        if sensor in read or sensor not in scaled
    )
    own = {sensor.named(field) for sensor in scaled for field in ("gain", "offset")}
    known = {name: value for name, value in axis.known.items() if name not in own}
    taken = {name: values[name] for name in own if name in values and name in axis.physical_parameters}
    return Unscaled(replace(axis, sensors=plain, known=known), changed, axis.with_known(taken), tuple(notes))


def _values(axis: Axis, read: Sequence[Sensor], log: Log, nominal: Mapping[str, float]) -> dict[str, float]:
    """Known, nominal or else identified gains and offsets of sensors."""
    names = [
        sensor.named(field)
        for sensor in read
        for field in ("gain", "offset")
        if getattr(sensor, field) is not None
    ]
    values = axis.with_known_values(nominal)
    if any(name not in values for name in names):
        measured = [sensor.signal for sensor in axis.sensors if sensor.signal in log.signals]
        try:
            found = identify(model_of(axis, measured), log, examine=False).physical_parameters
        except SymidError as error:
            raise SettingError(f"no gains of sensors can be identified ({error}): give `nominal`") from error
        values = {**found, **values}
    if lacking := [name for name in names if not np.isfinite(values.get(name, np.nan))]:
        raise SettingError(
            f"the log does not determine {', '.join(lacking)}: give what is known with `fixed`, or `nominal`"
        )
    return values
