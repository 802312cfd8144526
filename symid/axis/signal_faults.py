"""Faults of drives, sensors and imperfections of their signals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symid.axis.drive_imperfections import DriveImperfection
from symid.axis.elements import (
    Drive,
    Spring,
    joint_label,
)
from symid.axis.imperfections import (
    EncoderRipple,
    ForceConstantRipple,
    JointImperfection,
    PayloadChange,
)
from symid.axis.laws import Law
from symid.axis.sensors import Sensor
from symid.axis.type_faults import label_of
from symid.units import Unit

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
            yield f"{label} reads {label_of(read)}, which is not of the axis: declare it there"
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
    own = [e for e in there if isinstance(e, Law) and e.in_spring]
    return [e for e in there if e not in own] if own else []


def force_ripple_faults(elements: Sequence[object], drives: Sequence[Drive]) -> Iterator[str]:
    """Ripples of the force constant that are not in the joint of the one drive whose force they share."""
    for element in elements:
        if not isinstance(element, ForceConstantRipple):
            continue
        if len(drives) > 1:
            yield f"ForceConstantRipple: the axis has {len(drives)} drives, one is required: leave the ripple out"
        elif drives and element.at != drives[0].at:
            yield (
                f"ForceConstantRipple at {joint_label(element.at)!r}: a force constant is of the drive: "
                f"put it at {joint_label(drives[0].at)!r}"
            )


def drive_imperfection_faults(elements: Sequence[object], drives: Sequence[Drive]) -> Iterator[str]:
    """Imperfections in a drive that the axis does not have."""
    signals = [drive.signal for drive in drives]
    for element in elements:
        if isinstance(element, DriveImperfection) and element.drive not in (None, *signals):
            kind = type(element).__name__
            yield f"{kind}: drive={element.drive!r} is not a drive: choose from {', '.join(signals)}"


def imperfection_faults(elements: Sequence[object], sensors: Sequence[Sensor]) -> Iterator[str]:
    """Changes of a known mass, and ripples of a sensor that reads no position."""
    for element in elements:
        if isinstance(element, PayloadChange) and element.body.numbers():
            body = element.body.name
            yield f"PayloadChange of {body!r}, whose mass is a known number: give it a name, and its value to simulate"
    positions = [sensor.signal for sensor in sensors if sensor.derivative == 0]
    for element in elements:
        if isinstance(element, EncoderRipple) and element.signal not in positions:
            known = ", ".join(positions) or "none is declared"
            yield f"EncoderRipple of {element.signal!r}: that is not a position sensor: choose from {known}"
