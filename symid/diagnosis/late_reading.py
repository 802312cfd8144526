"""Delays of readings that a diagnosis shows: of a load behind a spring, of an accelerometer beside a held force.

If the position of a load on a spring of stiffness K is read T late, the viscous friction of the load is identified K T
too high and that of the drive K T too low. The errors hardly show the difference, but a negative friction does.

A held force makes the acceleration jump at each sample. An accelerometer with the same clock is read just before the
jump. Its reading belongs to the force of the sample before, and is half a sample late.
"""

from collections.abc import Mapping
from dataclasses import replace

from symid.axis import Acceleration, Axis, Between, Position, Spring, ViscousFriction
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.thresholds import THRESHOLDS

_AS_GOOD = 1.1
"""Largest error with the delay of the reading, relative to that without, with which the delay is accepted."""
_TEXT = "{} read {:.3g} ms {} against {}, which looks like negative friction"


READ_BEFORE_STEPS = (
    "{} is read just before each step of the held force, half a sample late, which is accounted for."
)


def delays_of_accelerometers(axis: Axis, found: Diagnosis, hold: float) -> dict[str, float]:
    """Delay of each accelerometer that a diagnosis finds late by half the time `hold` of a force, s."""
    read = {own.signal for own in axis.sensors if isinstance(own, Acceleration)}
    late = (e for e in found.effects if e.effect == "sensor_delay" and e.at in read)
    half = (e.at for e in late if abs(e.parameters["T"].value / hold - 0.5) < THRESHOLDS.half_sample)
    return dict.fromkeys(half, hold / 2)


def delay_of_load_reading(axis: Axis, found: Diagnosis) -> dict[str, float]:
    """Delay of the reading of a load by its signal, s, from a friction far below zero; empty if none is.

    The delay of an early reading is negative. Only axes of two bodies joined by a spring, each with a position, are
    examined.
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


def with_delayed_reading(found: Diagnosis, late: Diagnosis, times: Mapping[str, float]) -> Diagnosis:
    """The diagnosis `late` with the delayed reading, if it explains as much by values that a machine can have.

    If its values are possible but it explains less, the diagnosis without the delay notes that the reading may be late.
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
