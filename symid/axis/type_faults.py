"""Faults of the types in a declaration, and the names of its elements in messages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symid.axis.elements import (
    PARAMETER_FIELDS,
    Between,
    Body,
    Damper,
    Drive,
    Geared,
    Ground,
    PendulumWeight,
    Spring,
    Weight,
)
from symid.axis.imperfections import Imperfection
from symid.axis.laws import Law
from symid.axis.laws.law import is_finite
from symid.axis.sensors import MotionSensor, Sensor
from symid.signal_names import is_signal_name


def type_faults(
    name: object, elements: Sequence[object], drives: Sequence[object], sensors: Sequence[object]
) -> Iterator[str]:
    """Fields of a declaration that hold something of another type; the other faults are looked for without them."""
    if not isinstance(name, str) or not is_signal_name(name):
        yield f"name {name!r} is not an identifier: use letters, digits and underscores"
    if not isinstance(elements, tuple) or not isinstance(sensors, tuple):
        yield "elements and sensors must be tuples: write a comma behind a single one"
        return
    kinds = (Body, Spring, Damper, Weight, PendulumWeight, Law, Imperfection)
    for element in elements:
        if not isinstance(element, kinds):
            known = "Body, Spring, Damper, Weight, PendulumWeight, a Law or an Imperfection"
            yield f"{element!r} is not an element: use {known}"
        else:
            yield from _field_faults(element)
    if not drives:
        yield "there is no drive: declare drive=Drive(signal, body)"
    for drive in drives:
        if not isinstance(drive, Drive):
            yield f"drive {drive!r} is not a Drive: declare drive=Drive(signal, body), or a tuple of these"
        else:
            yield from _field_faults(drive)
    if not sensors:
        yield "there is no sensor: declare at least a Position of the driven body"
    for sensor in sensors:
        reads = isinstance(sensor, Sensor) and type(sensor).parts is not Sensor.parts
        if not reads or (isinstance(sensor, MotionSensor) and sensor.derivative is None):
            yield f"{sensor!r} is not a sensor: use Position, Velocity, Acceleration or Force"
        else:
            yield from _field_faults(sensor)


def _field_faults(element: object) -> Iterator[str]:
    """Bodies given by name, and parameters that are not names."""
    label = label_of(element)
    for field in ("on", "at", "body", "relative_to"):
        value = getattr(element, field, None)
        allowed = (Body, Between) if field == "at" else (Body, Ground)
        if value is not None and not isinstance(value, allowed):
            kinds = " or ".join(kind.__name__ for kind in allowed)
            yield f"{label}: {field}={value!r} must be the {kinds} object itself"
        if isinstance(value, Between):
            for end in (value.first, value.second):
                if not isinstance(end, (Body, Ground)):
                    yield f"{label}: {end!r} must be the Body object itself"
    of = getattr(element, "of", None)
    if isinstance(element, Sensor) and of is not None and not isinstance(of, (Spring, Drive)):
        yield f"{label}: of={of!r} must be the Spring or Drive object itself"
    for field in ("name", "signal", "command"):
        value = getattr(element, field, None)
        if value is not None and not isinstance(value, str):
            yield f"{label}: {field}={value!r} must be a name"
    for field in () if isinstance(element, (Law, Drive)) else PARAMETER_FIELDS:
        value = getattr(element, field, None)
        if value is not None and not isinstance(value, str) and not is_finite(value):
            yield f"{label}: {field}={value!r} must be the name of a parameter, or its value: a finite number"
    if isinstance(element, Law):
        for term in element.terms():
            if not isinstance(term.parameter, str):
                yield f"{label}: parameter {term.parameter!r} must be a name, with its value in known= of the axis"
    gears = element.gears if isinstance(element, Body) else ()
    is_empty = getattr(element, "geared", None) == ()
    if is_empty or not all(isinstance(gear, Geared) and isinstance(gear.to, Body) for gear in gears):
        geared = getattr(element, "geared", None)
        yield f"{label}: geared={geared!r} must be Geared(to=BODY, ratio=NUMBER), or a tuple of these"


def ends_of(at: object) -> tuple[str, ...]:
    """Names of the two bodies of a joint; none for anything else."""
    if isinstance(at, Body):
        return at.name, at.on.name
    if isinstance(at, Between):
        return at.first.name, at.second.name
    return ()


def label_of(element: object) -> str:
    """Name of an element in a message."""
    kind = type(element).__name__
    if isinstance(element, (Body, Spring, Damper)):
        return f"{kind} {element.name!r}"
    if isinstance(element, Sensor):
        return f"sensor {element.signal!r}"
    if isinstance(element, Drive):
        return f"drive {element.signal!r}"
    at = getattr(element, "at", None) or getattr(element, "body", None)
    ends = (
        " and ".join(repr(name) for name in ends_of(at))
        if isinstance(at, Between)
        else repr(getattr(at, "name", at))
    )
    return f"{kind} at {ends}"
