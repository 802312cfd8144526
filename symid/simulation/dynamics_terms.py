"""Laws and sensors of an axis whose coefficients are polynomials of its parameters."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.law_code import array_function
from symid.simulation.parameter_polynomials import Polynomial
from symid.simulation.plant import LawFunction, SensorRow
from symid.simulation.postfix import program


@dataclass(frozen=True, eq=False)
class LawTerm:
    """A nonlinear law of a joint: a parameter times an expression of displacement q and velocity v."""

    parameter: Polynomial
    code: str  # NumPy code of the expression
    forces: LawFunction  # the expression

    @classmethod
    def of(cls, parameter: Polynomial, code: str) -> LawTerm:
        """The law of NumPy code; SymidError if the code is not in the law language."""
        program(code, ("q", "v"))  # refuses any other code before it is evaluated
        return cls(parameter, code, array_function(code))

    def geared(self, ratio: float) -> LawTerm:
        """The law in a joint that moves 1/ratio times as far: ratio f(ratio q, ratio v).

        >>> term = LawTerm.of(Polynomial(((2.0, (1,)),)), "np.sign(v)").geared(-0.5)
        >>> term.parameter.at([3.0]), float(term.forces(0.0, 1.0))
        (-3.0, -1.0)
        """
        scaled = Polynomial(
            tuple((ratio * coefficient, powers) for coefficient, powers in self.parameter.terms)
        )
        return LawTerm.of(scaled, re.sub(r"\b([qv])\b", rf"({ratio!r}*\1)", self.code))


class SensorTerms(NamedTuple):
    """The reading of a sensor, (motion + drives - offset) / gain, with polynomials as coefficients.

    A sensor without parameters has only `row` and `order`, as in `SensorRow`. `scale` holds gain and offset,
    `law` is as in `SensorRow`.
    """

    row: FloatArray
    order: int | None
    n_drives: int
    motion: tuple[tuple[Polynomial, ...], ...] = ()
    drives: tuple[Polynomial, ...] = ()
    scale: tuple[Polynomial, ...] = ()
    law: int | None = None

    def at(self, values: Sequence[float]) -> SensorRow:
        """The reading at parameter values; SettingError if the gain is not positive."""
        if not self.motion:
            motion = np.zeros((3, self.row.size))
            motion[self.order] = self.row
            return SensorRow(self.row, self.order, motion, np.zeros(self.n_drives))
        gain, offset = (polynomial.at(values) for polynomial in self.scale)
        if not gain > 0:
            raise SettingError(f"the gain of a sensor is {gain:g}: it must be positive")
        motion = np.array([[p.at(values) for p in row] for row in self.motion]) / gain
        drives = np.array([p.at(values) for p in self.drives]) / gain
        row = self.row if self.order is None else motion[self.order]
        return SensorRow(row, self.order, motion, drives, -offset / gain, self.law, 1 / gain)


class JointTerms(NamedTuple):
    """Nonlinear laws of one joint; its displacement is `direction` times the displacements of the bodies."""

    direction: FloatArray
    terms: tuple[LawTerm, ...]
