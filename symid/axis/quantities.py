"""Units of displacements, forces and parameters, which follow from the bodies and the drives."""

from collections.abc import Iterator, Sequence

from symid.axis.elements import Body, Damper, Drive, Ground, Joint, PendulumWeight, Spring
from symid.axis.laws import Law
from symid.axis.sensors import Sensor
from symid.units import Unit


def end_of(joint: Joint) -> Body | Ground:
    """The body that moves in a joint."""
    if isinstance(joint, Body):
        return joint
    return joint.first if isinstance(joint.second, Ground) else joint.second


def length_unit(joint: Joint) -> Unit:
    """Unit of the displacement in a joint: m where it slides, rad where it turns.

    >>> from symid.axis import Body
    >>> str(length_unit(Body("arm", inertia="J")))
    'rad'
    """
    return Unit.of("rad") if _is_angle(joint) else Unit.of("m")


def force_unit(drives: Sequence[Drive], joint: Joint) -> Unit:
    """Unit of a force (or torque) in a joint, which follows the unit of the drives."""
    known = (drive for drive in drives if drive.constant is None and drive.unit)
    drive, turns = next(known, None), _is_angle(joint)
    if drive is None:
        return Unit.of("N*m") if turns else Unit.of("N")
    unit = Unit.of(drive.unit or "")
    if _is_angle(drive.at) == turns:
        return unit
    return unit * Unit.of("m") if turns else unit / Unit.of("m")


def quantity_unit(drives: Sequence[Drive], sensor: Sensor) -> Unit:
    """Unit of the quantity that a sensor reads."""
    if sensor.derivative is None:
        return force_unit(drives, sensor.joint)
    return length_unit(sensor.joint) / Unit.of("s") ** sensor.derivative


def signal_unit(drives: Sequence[Drive], sent: Drive | Sensor) -> Unit:
    """SI unit of the signal of a drive or a sensor."""
    if isinstance(sent, Drive):
        return force_unit(drives, sent.at) if sent.constant is None else Unit.of(sent.unit or "")
    return quantity_unit(drives, sent) if sent.unit is None else Unit.of(sent.unit)


def parameter_units(elements: Sequence[object], drives: Sequence[Drive]) -> Iterator[tuple[str, Unit]]:
    """Each physical parameter with its unit, as often as an element, a sensor or a drive has it."""
    second = Unit.of("s")
    for element in (*elements, *drives):
        match element:
            case Drive(constant=str(name)):
                yield name, force_unit(drives, element.at) / Unit.of(element.unit or "")
            case Body():
                yield element.inertial, force_unit(drives, element) * second**2 / length_unit(element)
            case Spring() | Damper():
                force, length = force_unit(drives, element.at), length_unit(element.at)
                if isinstance(element, Spring):
                    yield element.named("stiffness"), force / length
                if element.damping is not None:
                    yield element.named("damping"), force * second / length
            case PendulumWeight():
                yield element.named("moment"), force_unit(drives, element.body) / Unit.of("m/s^2")
            case Sensor():
                quantity = quantity_unit(drives, element)
                if element.gain is not None:
                    yield element.named("gain"), quantity / signal_unit(drives, element)
                if element.offset is not None:
                    yield element.named("offset"), quantity
            case Law():
                for term in element.terms():
                    yield term.parameter, term.unit(force_unit(drives, element.at), length_unit(element.at))


def unit_faults(elements: Sequence[object], drives: Sequence[Drive]) -> Iterator[str]:
    """Parameters that stand for two quantities, and drives whose units do not go together."""
    units: dict[str, Unit] = {}
    for name, unit in parameter_units(elements, drives):
        if units.setdefault(name, unit) != unit:
            yield (
                f"parameter {name!r} is in {units[name]} and in {unit}: elements share a parameter only "
                "if it is the same quantity: give each a separate name"
            )
    kinds = {str(force_unit(drives, d.at) / Unit.of(d.unit)) for d in drives if d.unit and not d.constant}
    if len(kinds) > 1:
        yield "the drives have units of different quantities: give all of them in current, or all as forces"


def _is_angle(joint: Joint) -> bool:
    end = end_of(joint)
    return isinstance(end, Body) and end.turns
