"""Faults of the types in a declaration, and of its drives, sensors and imperfections of their signals."""

from collections.abc import Iterator, Sequence

from symid.axis.drive_imperfections import DriveImperfection
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
    joint_label,
)
from symid.axis.imperfections import (
    EncoderRipple,
    Imperfection,
    JointImperfection,
    PreslidingFriction,
)
from symid.axis.laws import CoulombFriction, Law
from symid.axis.laws.law import is_finite
from symid.axis.sensors import MotionSensor, Sensor
from symid.signal_names import is_signal_name
from symid.units import Unit


def type_faults(
    name: object, elements: Sequence[object], drives: Sequence[object], sensors: Sequence[object]
) -> Iterator[str]:
    """Fields of a declaration that hold something of another type; the other faults are looked for without them."""
    if not isinstance(name, str) or not is_signal_name(name):
        yield f"name {name!r} is not an identifier: use letters, digits and underscores"
    if not isinstance(elements, tuple) or not isinstance(sensors, tuple):
        yield "elements and sensors must be tuples: write a comma after a single one"
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
    if at is None:  # an imperfection of a drive or a reading
        return kind
    ends = (
        " and ".join(repr(name) for name in ends_of(at))
        if isinstance(at, Between)
        else repr(getattr(at, "name", at))
    )
    return f"{kind} at {ends}"


_FORCES = (Unit.of("N"), Unit.of("N*m"))


def drive_faults(drives: Sequence[Drive]) -> Iterator[str]:
    """Gains, commands and units of drives that do not go together."""
    for drive in drives:
        label = label_of(drive)
        if drive.constant is not None:
            gain = f"{label}: gain {drive.constant!r}"
            if not str(drive.constant).isidentifier():
                yield f"{gain} is not a parameter name: use letters, digits and _"
            if drive.command is not None:
                yield f"{gain} is unknown, so that the command is the signal: leave command= out"
            if drive.unit is None:
                yield f"{gain} is a force per unit of the signal: give that, such as unit='A'"
        elif (drive.command is None) != (drive.gain is None):
            yield f"{label}: command and gain belong together: give both or neither"
        if drive.unit is not None and not Unit.is_named(drive.unit):
            yield f"{label}: unit {drive.unit!r} is not known: use N, N*m, A or V"
    if len({bool(drive.held) for drive in drives}) > 1:
        signals = ", ".join(repr(drive.signal) for drive in drives)
        yield f"drives {signals} are not all held: one controller sends all of them, give each the same held="


def sensor_faults(
    elements: Sequence[object], drives: Sequence[Drive], sensors: Sequence[Sensor]
) -> Iterator[str]:
    """Units of signals, and force sensors whose element is not that of the axis."""
    for sensor in sensors:
        label = label_of(sensor)
        if sensor.unit is not None and not Unit.is_named(sensor.unit):
            yield f"{label}: unit {sensor.unit!r} is not known: use V, A or a unit of its quantity"
        elif sensor.unit is not None and sensor.gain is None:
            yield f"{label}: unit {sensor.unit!r} needs a gain: give its {sensor.quantity} per {sensor.unit} as gain="
        if (read := sensor.element) is None:
            continue
        names = {e.name: e for e in elements if isinstance(e, Spring)} | {d.signal: d for d in drives}
        name = read.name if isinstance(read, Spring) else read.signal
        if getattr(names.get(name), "at", None) != read.at:
            yield f"{label} reads {label_of(read)}, which is not part of the axis: add it to the elements"
        elif isinstance(read, Spring) and (others := _laws_beside_nonlinear_spring(read, elements)):
            yield (
                f"{label} reads {label_of(read)}, whose nonlinear law shares its joint with "
                f"{type(others[0]).__name__}: put that at a body"
            )
        if any(
            drive.unit and drive.constant is None and Unit.of(drive.unit) not in _FORCES for drive in drives
        ):
            yield f"{label} reads a force, and a drive is in another unit: give that an unknown gain, gain='Kt'"


def _laws_beside_nonlinear_spring(
    spring: Spring, elements: Sequence[object]
) -> list[Law | JointImperfection]:
    """Other laws in the joint of a spring with a nonlinear law: a force sensor in it cannot separate them from that."""
    there = [e for e in elements if isinstance(e, (Law, JointImperfection)) and e.at == spring.at]
    of_spring = [e for e in there if isinstance(e, Law) and e.in_spring]
    return [e for e in there if e not in of_spring] if of_spring else []


def drive_imperfection_faults(elements: Sequence[object], drives: Sequence[Drive]) -> Iterator[str]:
    """Imperfections in a drive that the axis does not have."""
    signals = [drive.signal for drive in drives]
    for element in elements:
        if isinstance(element, DriveImperfection) and element.drive not in (None, *signals):
            kind = type(element).__name__
            yield f"{kind}: drive={element.drive!r} is not a drive: choose from {', '.join(signals)}"


def imperfection_faults(elements: Sequence[object], sensors: Sequence[Sensor]) -> Iterator[str]:
    """Friction that builds up in a joint without friction, ripples of no position sensor."""
    rubbing = [element.at for element in elements if isinstance(element, CoulombFriction)]
    for element in elements:
        if isinstance(element, PreslidingFriction) and element.at not in rubbing:
            yield (
                f"PreslidingFriction at {joint_label(element.at)!r}: it is how Coulomb friction of the joint builds "
                "up, and none is declared: declare CoulombFriction there too, or leave it out"
            )
    positions = [sensor.signal for sensor in sensors if sensor.derivative == 0]
    for element in elements:
        if isinstance(element, EncoderRipple) and element.signal not in positions:
            known = ", ".join(positions) or "none is declared"
            yield f"EncoderRipple of {element.signal!r}: that is not a position sensor: choose from {known}"
