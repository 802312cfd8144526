"""Readings that are late by their nature: a second encoder beside its spring, an accelerometer beside a held force.

Through a spring of stiffness K, a load whose position is read T late seems to feel K T more of viscous friction, and
the drive K T less. Errors hardly distinguish the two; negative friction, which no machine has, does.

A held force makes the acceleration jump at each sample. An accelerometer with the same clock is read just before the
jump: its reading belongs to the force of the sample before, and is half a sample later than the motion.
"""

from collections.abc import Mapping
from dataclasses import replace

from symid.axis import Acceleration, Axis, Between, Position, Spring, ViscousFriction
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.thresholds import THRESHOLDS

_AS_GOOD = 1.1
"""Error that the model found may leave with the late reading, relative to that with the reading as it is."""
_TEXT = "{} read {:.3g} ms {} against {}, which looks like negative friction"


READ_BEFORE_STEPS = (
    "{} is read just before each step of the held force, half a sample late, which is accounted for."
)


def before_steps(axis: Axis, found: Diagnosis, hold: float) -> dict[str, float]:
    """Time by which accelerometers are late, s, that a diagnosis names as late by half of the time of a hold."""
    read = {own.signal for own in axis.sensors if isinstance(own, Acceleration)}
    late = (e for e in found.effects if e.effect == "sensor_delay" and e.at in read)
    half = (e.at for e in late if abs(e.parameters["T"].value / hold - 0.5) < THRESHOLDS.half_sample)
    return dict.fromkeys(half, hold / 2)


def lateness(axis: Axis, found: Diagnosis) -> dict[str, float]:
    """Time by which the reading of a load is late, s, if a friction far below zero shows it; else empty.

    A negative time is that of an early reading. Axes of two bodies joined by a spring, each with a position, count.
    """
    springs = [
        (own, own.at) for own in axis.elements if isinstance(own, Spring) and isinstance(own.at, Between)
    ]
    sensors = [own for own in axis.sensors if isinstance(own, Position) and own.signal in found.measured]
    if not (len(axis.free_bodies) == len(sensors) == 2 and len(axis.drives) == len(springs) == 1):
        return {}
    driven, load = sorted(sensors, key=lambda own: own.signal != found.measured[0])
    values = {own.name: own for own in found.parameters}
    spring, joint = springs[0]
    stiffness = values.get(spring.named("stiffness"))
    if driven.body == load.body or stiffness is None or not stiffness.explained > 0:
        return {}
    for law in (own for own in axis.laws if isinstance(own, ViscousFriction)):
        own = values.get(law.terms()[0].parameter)
        if own is not None and own.is_far_from_physical and law.at in (driven.body, load.body):
            lost = (own.nominal - own.explained) / stiffness.explained
            return {load.signal: lost / joint.ratio**2 if law.at == driven.body else -lost}
    return {}


def with_late_reading(found: Diagnosis, late: Diagnosis, times: Mapping[str, float]) -> Diagnosis:
    """The diagnosis with the late reading if it explains as much by values that a machine can have.

    If its values are possible, but it explains less, the other one gets a note that the reading may be late.
    """
    if any(own.is_far_from_physical for own in late.parameters):
        return found
    driven, ((signal, time),) = found.measured[0], times.items()
    when = 1e3 * abs(time), "late" if time > 0 else "early", driven
    if late.gap.explained.rms < _AS_GOOD * found.gap.explained.rms:
        text = _TEXT.format(f"{signal} is", *when) + ": it is accounted for."
        return replace(late, faults=(text, *late.faults))
    text = _TEXT.format(f"{signal} may be", *when) + f": try `late` {signal}={1e3 * time:.3g}ms."
    return replace(found, faults=(text, *found.faults))
