"""The displacements of the bodies that a set of sensors determines.

A sensor of order m (0 position, 1 velocity, 2 acceleration) gives the m-th derivative of a linear function of
the absolute displacements. Independent ones form a basis, positions first; a sensor that repeats a function of
the basis at a higher order serves for the higher derivatives, as in method 3 of the paper.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symid.axis import MotionSensor, Sensor
from symid.symbolic.lagrange import Kinematics
from symid.symbolic.operators import Functional, OperatorModel, add, parents
from symid.symbolic.span import Span

"""Coefficients of absolute displacements, by body name."""


@dataclass(frozen=True)
class MeasuredFunction:
    """A linear function of the displacements whose derivative of an order is a signal, or gain * signal + offset."""

    signal: str
    order: int
    is_scaled: bool = False


@dataclass(frozen=True)
class RepeatedFunction:
    """A sensor whose function is a combination of the basis, by basis index."""

    signal: str
    order: int
    combination: Mapping[int, Any]
    is_scaled: bool = False


@dataclass(frozen=True)
class Measurement:
    """Sensors as a basis of measured functions, and the displacements that remain unknown."""

    basis: tuple[MeasuredFunction, ...]  # independent functions, by rising order of derivative
    repeated: tuple[RepeatedFunction, ...]  # sensors that add no function
    # each body's displacement as a combination of basis functions (column ``"y<i>"``) and of the displacements of
    # unknown bodies (column: body name)
    displacements: Mapping[str, Functional]

    @property
    def unknown(self) -> tuple[str, ...]:
        """Bodies whose displacement has to be eliminated."""
        return tuple(body for body, row in self.displacements.items() if row.keys() == {body})

    @property
    def in_equations(self) -> tuple[str, ...]:
        """Repeated sensors that determine a gain or an offset: their own, or one of the basis."""
        scaled = {i for i, function in enumerate(self.basis) if function.is_scaled}
        return tuple(r.signal for r in self.repeated if r.is_scaled or scaled & r.combination.keys())

    def substitute(self, functional: Mapping[str, Any]) -> dict[str, Any]:
        """A function of displacements (or an operator row) in basis functions and unknown displacements."""
        row: dict[str, Any] = {}
        for body, coefficient in functional.items():
            for column, share in self.displacements[body].items():
                row = add(row, {column: coefficient * share}, 1)
        return row

    def derivative(
        self, index: int, order: int, without: Collection[str] = ()
    ) -> tuple[tuple[str, int, Any], ...]:
        """The derivative of a basis function as (signal, order, coefficient), differentiating as little as possible.

        Signals `without` do not serve for it: an equation of their reading would otherwise say 0 = 0.
        """
        function = self.basis[index]
        best: tuple[tuple[str, int, Any], ...] = ((function.signal, order - function.order, 1),)
        reached = function.order
        for other in (repeated for repeated in self.repeated if repeated.signal not in without):
            share = other.combination.get(index)
            rest = {i: c for i, c in other.combination.items() if i != index}
            saves = reached < other.order <= order and all(self.basis[i].order == other.order for i in rest)
            if share is not None and saves and not other.is_scaled:
                reached, left = other.order, order - other.order
                best = (
                    (other.signal, left, 1 / share),
                    *((self.basis[i].signal, left, -c / share) for i, c in rest.items()),
                )
        return best


def measurement(model: OperatorModel, sensors: Sequence[Sensor]) -> Measurement:
    """Basis of the measured functions, and every displacement in terms of it."""
    kinematics, span = Kinematics(model.source.axis), Span()
    basis: list[MeasuredFunction] = []
    repeated: list[RepeatedFunction] = []
    of_motion = (sensor for sensor in sensors if isinstance(sensor, MotionSensor))
    for sensor in sorted(of_motion, key=lambda sensor: (sensor.derivative, sensor.is_scaled)):
        functional = model.functional(kinematics.displacement(sensor.joint))
        if span.add(functional, pivot=sensor.body.name):
            basis.append(MeasuredFunction(sensor.signal, sensor.derivative, sensor.is_scaled))
        else:
            combination = span.coordinates(functional) or {}
            repeated.append(RepeatedFunction(sensor.signal, sensor.derivative, combination, sensor.is_scaled))
    one = model.ring.domain.one
    displacements: dict[str, Functional] = {body: {body: one} for body in parents(model.source.axis)}
    for pivot, row, coordinates in span.reduced():
        measured = {f"y{i}": share for i, share in sorted(coordinates.items())}
        displacements[str(pivot)] = measured | {body: -c for body, c in row.items() if body != pivot}
    return Measurement(tuple(basis), tuple(repeated), displacements)
