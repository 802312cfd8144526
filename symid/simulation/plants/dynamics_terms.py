"""Polynomials of the physical parameters, and laws and sensors of an axis whose coefficients they are."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from math import prod
from typing import NamedTuple

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.plants.law_code import array_function
from symid.simulation.plants.plant import LawFunction, SensorRow
from symid.simulation.plants.postfix import program

Factors = tuple[tuple[int, int], ...]
"""Index and power of each parameter in a product."""


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A polynomial of the physical parameters: coefficient and exponents of each term."""

    terms: tuple[tuple[float, tuple[int, ...]], ...]

    @classmethod
    def of(cls, terms: Iterable[tuple[float, Iterable[int]]]) -> Polynomial:
        """The polynomial of a stored record."""
        return cls(tuple((coefficient, tuple(powers)) for coefficient, powers in terms))

    def at(self, values: Sequence[float] | FloatArray) -> float:
        """Value at parameter values."""
        return float(sum(c * _product(factors, values) for c, factors in self.factors))

    @cached_property
    def factors(self) -> tuple[tuple[float, Factors], ...]:
        """Terms as a coefficient and the index and power of each parameter in them."""
        return tuple((c, tuple((i, p) for i, p in enumerate(powers) if p)) for c, powers in self.terms)


@dataclass(frozen=True, eq=False)
class PolynomialArrays:
    """Arrays of polynomials, mostly zero, whose products of powers are evaluated once and shared.

    >>> squared, linear = Polynomial(((2.0, (2, 0)),)), Polynomial(((1.0, (0, 1)), (3.0, (1, 0))))
    >>> arrays = PolynomialArrays([(1,), (1, 1)], [squared, linear])
    >>> [x.tolist() for x in arrays.at([5.0, 7.0])], [x.tolist() for x in arrays.derivative([5.0, 7.0], 0)]
    ([[50.0], [[22.0]]], [[20.0], [[3.0]]])
    """

    shapes: Sequence[tuple[int, ...]]  # shapes of the arrays
    entries: Sequence[Polynomial]  # entries of all arrays, concatenated

    def at(self, values: Sequence[float]) -> list[FloatArray]:
        """The arrays at parameter values."""
        products = [_product(factors, values) for factors in self._products]
        return self._arrays((place, c * products[k]) for place, c, k in self._terms)

    def derivative(self, values: Sequence[float], by: int) -> list[FloatArray]:
        """Derivatives of the arrays by the parameter with an index."""
        return self._arrays(
            (place, c * power * values[by] ** (power - 1) * _product(others, values))
            for place, c, power, others in self._terms_with.get(by, ())
        )

    def _arrays(self, terms: Iterable[tuple[int, float]]) -> list[FloatArray]:
        """The arrays from terms, each an index among all entries and a value; terms of one entry are summed."""
        flat = [0.0] * self._ends[-1]
        for place, value in terms:
            flat[place] += value
        whole, begins = np.array(flat), (0, *self._ends)
        parts = zip(begins, self._ends, self.shapes, strict=False)
        return [whole[begin:end].reshape(shape) for begin, end, shape in parts]

    @cached_property
    def _ends(self) -> list[int]:
        """End of each array among the entries of all."""
        return list(accumulate(prod(shape) for shape in self.shapes))

    @cached_property
    def _products(self) -> list[Factors]:
        """The distinct products of powers."""
        return list(dict.fromkeys(factors for p in self.entries for _, factors in p.factors))

    @cached_property
    def _terms(self) -> list[tuple[int, float, int]]:
        """Index of the entry, coefficient and index of the product of each term."""
        places = {factors: k for k, factors in enumerate(self._products)}
        return [(i, c, places[factors]) for i, p in enumerate(self.entries) for c, factors in p.factors]

    @cached_property
    def _terms_with(self) -> dict[int, list[tuple[int, float, int, Factors]]]:
        """Terms by parameter: index of the entry, coefficient, power of the parameter, other factors."""
        found: dict[int, list[tuple[int, float, int, Factors]]] = {}
        for place, c, k in self._terms:
            for own in self._products[k]:
                others = tuple(factor for factor in self._products[k] if factor is not own)
                found.setdefault(own[0], []).append((place, c, own[1], others))
        return found


def _product(factors: Factors, values: Sequence[float] | FloatArray) -> float:
    return prod(values[i] ** power for i, power in factors)


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
