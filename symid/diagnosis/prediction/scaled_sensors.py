"""Conversion of logs of sensors and drives whose gains are parameters of the axis.

The gains are determined before the diagnosis. With a free constant of the drive, all masses, frictions and effects
could grow together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from symid.axis import Axis, Sensor
from symid.codegen import model_of
from symid.data import Log
from symid.errors import EliminationError, SettingError, SymidError
from symid.identification import Preparation, identify_by_least_squares
from symid.identification.parameters import open_by_structure

_CONTRADICTS = 5.0
"""Deviations by which a gain of the log must differ from the nominal one to be taken instead."""


class Unscaled(NamedTuple):
    """An axis and its logs in physical units."""

    axis: Axis
    logs: list[Log]
    declared: Axis  # with the gains and offsets that were taken as known
    notes: tuple[str, ...]  # sentences on the conversions


def with_quantities(
    axis: Axis,
    logs: Sequence[Log],
    nominal: Mapping[str, float] | None = None,
    preparation: Preparation | None = None,
) -> Unscaled:
    """The axis with known constants of its drives, and quantities in place of the signals of scaled sensors.

    Constants, gains and offsets come from `nominal`, or are identified from the first log with the holds and delays of
    the preparation; SettingError if it does not determine them.

    >>> from symid import Body, Drive, Position
    >>> table = Body("table", mass="M")
    >>> axis = Axis("t", (table,), Drive("F", table), (Position("q", table, gain="c", offset="o"),))
    >>> log = Log.from_arrays({"q": np.ones(3), "F": np.ones(3)}, sampling_period=0.1)
    >>> plain = with_quantities(axis.with_known({"c": 2.0, "o": 0.5}), [log])
    >>> plain.axis.sensors[0].gain, plain.logs[0]["q"].tolist(), plain.notes[0]
    (None, [2.5, 2.5, 2.5], 'q is taken with gain 2 and offset 0.5.')
    """
    scaled = [sensor for sensor in axis.sensors if sensor.is_scaled]
    constants = _constants(axis)
    if not (scaled or constants):
        return Unscaled(axis, list(logs), axis, ())
    read = [sensor for sensor in scaled if all(sensor.signal in log.signals for log in logs)]
    names = [*_parameters_of(read), *constants]
    values = _values(axis, names, logs[0], nominal or {}, preparation or Preparation())
    notes = [_taken(axis, name, signals, values, nominal or {}) for name, signals in constants.items()]
    changed = list(logs)
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
    known |= {name: values[name] for name in constants}
    taken = {n: values[n] for n in (*own, *constants) if n in values and n in axis.physical_parameters}
    return Unscaled(replace(axis, sensors=plain, known=known), changed, axis.with_known(taken), tuple(notes))


def _parameters_of(sensors: Sequence[Sensor]) -> list[str]:
    """Names of gains and offsets of sensors."""
    fields = ((sensor, field) for sensor in sensors for field in ("gain", "offset"))
    return [sensor.named(field) for sensor, field in fields if getattr(sensor, field) is not None]


def _values(
    axis: Axis, names: Sequence[str], log: Log, nominal: Mapping[str, float], preparation: Preparation
) -> dict[str, float]:
    """Known or nominal values of gains and offsets, or those of the log if there are none or it contradicts them."""
    given = axis.with_known_values(nominal)
    measured = [sensor.signal for sensor in axis.sensors if sensor.signal in log.signals]
    axis = _determined(axis, measured, given)
    is_open = set(names) - set(axis.known)
    values = given | (_of_log(axis, measured, log, names, given, preparation) if is_open else {})
    if lacking := [name for name in names if not np.isfinite(values.get(name, np.nan))]:
        raise SettingError(
            f"the log does not determine {', '.join(lacking)}: give the known ones with `fixed`, or `nominal`"
        )
    return values


def _taken(
    axis: Axis, name: str, signals: Sequence[str], values: Mapping[str, float], nominal: Mapping[str, float]
) -> str:
    """Sentence on the value of a constant of drives."""
    unit, value = axis.parameter_units[name], values[name]
    given = nominal.get(name, value)
    instead = "" if given == value else f", as the log shows; the nominal value is {given:.6g} {unit}"
    return f"{name} of {' and '.join(signals)} is taken as {value:.6g} {unit}{instead}."


def _constants(axis: Axis) -> dict[str, list[str]]:
    """Unknown constants of drives, with the signals of their drives."""
    found: dict[str, list[str]] = {}
    for drive in axis.drives:
        if drive.constant in axis.physical_parameters:
            found.setdefault(drive.constant, []).append(drive.signal)
    return found


def _determined(axis: Axis, measured: Sequence[str], given: Mapping[str, float]) -> Axis:
    """The axis with as many given values known as no log of these sensors determines beside the others."""
    constants = [name for name in _constants(axis) if name in given]
    try:
        left = open_by_structure(model_of(axis, measured))
    except EliminationError:  # a law acts on hidden motion
        return axis.with_known({name: given[name] for name in constants})
    for name in (*constants, *left):
        if name in left and name in given:
            axis = axis.with_known({name: given[name]})
            left = open_by_structure(model_of(axis, measured))
    return axis


def _of_log(
    axis: Axis,
    measured: Sequence[str],
    log: Log,
    names: Sequence[str],
    given: Mapping[str, float],
    preparation: Preparation,
) -> dict[str, float]:
    """Gains and offsets from the log: those that are not given, and all if it contradicts a given one."""
    lacking = [name for name in names if name not in given]
    try:
        model = model_of(axis, measured)
        found = identify_by_least_squares(model, log, nominal=given, preparation=preparation)
        if found.status == "timing" and preparation.held is None:
            found = identify_by_least_squares(
                model, log, nominal=given, preparation=replace(preparation, held=True)
            )
    except SymidError as error:
        if lacking:
            raise SettingError(f"no gains can be identified ({error}): give `nominal`") from error
        return {}
    values = found.physical_parameters
    deviations = dict(zip(values, found.physical_deviations, strict=True))
    off = [
        abs(value - given.get(name, value)) > _CONTRADICTS * deviations[name]
        for name, value in values.items()
        if name in names
    ]
    taken = names if found.status == "ok" and any(off) else lacking
    return {name: values[name] for name in taken if name in values}
