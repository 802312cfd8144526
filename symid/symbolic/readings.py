"""Readings of sensors as operators: motion x + drives F + values of laws = gain * signal + offset.

A sensor whose reading is a derivative of a displacement, without parameters, adds no equation: it states what is
measured (`symid.symbolic.measurement`). Any other adds an equation to the balances. Where its force stands in a balance
too, the reading replaces it there: the balance is then free of the noise that a stiff spring makes of its deflection.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Drive, Sensor, Spring
from symid.symbolic.expressions import law_expression
from symid.symbolic.lagrange import ONE_INPUT, Kinematics
from symid.symbolic.operators import OperatorModel, Row, add


@dataclass(frozen=True)
class ReadingTerms:
    """motion x + drives F + laws = gain * signal + offset, polynomials in s and the parameters."""

    motion: Row  # by body
    drives: Row  # by signal of the drive
    laws: Row  # by symbol of the law's value
    gain: PolyElement
    offset: PolyElement

    @property
    def symbols(self) -> frozenset[sp.Symbol]:
        """Symbols of its gain and offset."""
        return frozenset(self.gain.as_expr().free_symbols | self.offset.as_expr().free_symbols)


def sensor_terms(operators: OperatorModel, sensor: Sensor) -> ReadingTerms:
    """Terms of a sensor.

    >>> from symid.axis import load_axis
    >>> from symid.symbolic.lagrange import inverse_dynamics
    >>> from symid.symbolic.operators import operator_model
    >>> axis = load_axis("direct_2m1s")
    >>> sensor_terms(operator_model(inverse_dynamics(axis)), axis.sensors[2]).motion
    {'motor': s**2, 'structure': -s**2}
    """
    ring, kinematics = operators.ring, Kinematics(operators.source.axis)
    s, motion, drives = ring.gens[0], Row(), Row()
    for part in sensor.parts:
        factor = ring.one if part.parameter is None else _parameter(operators, part.parameter)
        if isinstance(part.of, Drive):
            constant = part.of.constant
            gain = ring.one if constant is None else _parameter(operators, constant)
            drives = add(drives, {part.of.signal: gain}, factor)
        else:
            shares = operators.functional(kinematics.displacement(part.of))
            column = {body: (factor * s**part.derivative).mul_ground(share) for body, share in shares.items()}
            motion = add(motion, column, ring.one)
    return ReadingTerms(
        motion,
        drives,
        _laws_read(operators, sensor),
        gain=ring.one if sensor.gain is None else _parameter(operators, sensor.named("gain")),
        offset=ring.zero if sensor.offset is None else _parameter(operators, sensor.named("offset")),
    )


def _laws_read(operators: OperatorModel, sensor: Sensor) -> Row:
    """Parameters of the nonlinear laws of the spring whose force is read, by the symbols of their values."""
    source, laws = operators.source, Row()
    kinematics = Kinematics(source.axis)
    read = kinematics.displacement(sensor.joint)
    of_joint = {
        e.expression: str(e.symbol) for e in source.inputs if kinematics.displacement(e.joint) == read
    }
    in_spring = isinstance(sensor.element, Spring)
    for law in source.axis.laws:
        for term in law.terms() if in_spring and law.in_spring and law.at == sensor.joint else ():
            symbol = of_joint[law_expression(term.expression)]
            laws = add(laws, {symbol: _parameter(operators, term.parameter)}, operators.ring.one)
    return laws


def reading_of(signal: str) -> str:
    """Name of the equation of a sensor's reading, which no body can have."""
    return f"reading of {signal}"


def with_readings(
    operators: OperatorModel, sensors: Sequence[Sensor], repeated: Sequence[str]
) -> tuple[OperatorModel, tuple[str, ...]]:
    """Balances and equations of force sensors, and of those of the `repeated` signals; and what repeats a drive.

    A transducer of a drive whose force is known reads the record once more: it has no equation.
    """
    same = []
    for sensor in sensors:
        if sensor.derivative is not None and sensor.signal not in repeated:
            continue
        terms = sensor_terms(operators, sensor)
        if not terms.motion and not sensor.is_scaled and all(e.is_ground for e in terms.drives.values()):
            same.append(sensor.signal)
        else:
            operators = _with_equation(operators, sensor, terms)
    return operators, tuple(same)


def _with_equation(operators: OperatorModel, sensor: Sensor, terms: ReadingTerms) -> OperatorModel:
    """Operators with the equation motion x + drives F + laws - gain * signal - offset = 0 of one more sensor."""
    drives = add(terms.drives, {sensor.signal: terms.gain}, -1)
    constant = add(terms.laws, {str(ONE_INPUT): -terms.offset} if terms.offset else {}, operators.ring.one)
    motion, inputs, force = dict(operators.motion), dict(operators.inputs), dict(operators.force)
    if sensor.derivative is None:
        for body, share in _acts_on(operators, sensor).items():
            factor = operators.ring(-share)
            motion[body] = add(motion[body], terms.motion, factor)
            force[body] = add(force[body], drives, factor)
            inputs[body] = add(inputs[body], constant, factor)
    name = reading_of(sensor.signal)
    motion[name], force[name], inputs[name] = terms.motion, drives, constant
    return replace(operators, motion=motion, inputs=inputs, force=force)


def _acts_on(operators: OperatorModel, sensor: Sensor) -> dict[str, Any]:
    """Share of the force that a sensor reads in the balance of each body."""
    (part, *_) = sensor.parts
    at, sign = (part.of.at, -1) if isinstance(part.of, Drive) else (part.of, 1)
    displacement = Kinematics(operators.source.axis).displacement(at)
    return {body: sign * share for body, share in operators.functional(displacement).items()}


def _parameter(operators: OperatorModel, name: str) -> PolyElement:
    """A parameter as a polynomial; 0 if that is its known value."""
    ring = operators.ring
    symbol = sp.Symbol(name)
    return ring.from_expr(symbol) if symbol in ring.symbols else ring.zero
