"""Rational functions of the physical parameters, such as the minimal parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod
from operator import sub
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.symbolic.polynomials import quotient_if_whole
from symid.units import Unit

_LONG = 200  # terms beyond which a function is not printed by sympy


@dataclass(frozen=True)
class ParameterFunction:
    """A rational function of the physical parameters in the ring of the operator model, without common monomials."""

    numerator: PolyElement
    denominator: PolyElement

    @classmethod
    def quotient(cls, numerator: PolyElement, denominator: PolyElement) -> ParameterFunction:
        """numerator / denominator, reduced as far as exact division and common monomials allow."""
        ring = numerator.ring
        if not denominator.is_term and len(numerator) >= len(denominator):
            whole = quotient_if_whole(numerator, denominator)
            if whole is not None:
                return cls(whole, ring.one)
        shared = tuple(
            min(powers) for powers in zip(*numerator.itermonoms(), *denominator.itermonoms(), strict=True)
        )
        sign = ring.domain.one if ring.domain.is_positive(denominator.LC) else -ring.domain.one
        scale = 1 / (denominator.LC if denominator.is_term else sign)
        if not any(shared) and scale == ring.domain.one:
            return cls(numerator, denominator)
        return cls(_over_monomial(numerator, shared, scale), _over_monomial(denominator, shared, scale))

    @cached_property
    def monomials(self) -> dict[Any, Any]:
        """Coordinates by monomial; functions with the same polynomial denominator share a space."""
        if self.denominator.is_term:
            ((powers, scale),) = self.denominator.terms()
            below = ""
        else:
            powers, scale = (0,) * len(self.numerator.ring.gens), self.numerator.ring.domain.one
            below = str(self.denominator)
        if not any(powers) and scale == self.numerator.ring.domain.one:
            return {(below, m): c for m, c in self.numerator.terms()}
        return {(below, tuple(map(sub, m, powers))): c / scale for m, c in self.numerator.terms()}

    def coordinates(self, known: Mapping[int, Any]) -> dict[Any, Any]:
        """Coordinates by monomial in the unknown parameters; `known` holds the values of known generators."""
        if not known:
            return self.monomials
        total: dict[Any, Any] = {}
        for (below, powers), c in self.monomials.items():
            key = (below, tuple(0 if i in known else power for i, power in enumerate(powers)))
            factor = prod((value ** powers[i] for i, value in known.items() if powers[i]), start=c)
            total[key] = total.get(key, 0) + factor
        return {key: c for key, c in total.items() if c}

    @property
    def names(self) -> set[str]:
        """Names of the physical parameters in it."""
        powers = zip(*self.numerator.itermonoms(), *self.denominator.itermonoms(), strict=True)
        return {str(x) for x, used in zip(self.numerator.ring.symbols, powers, strict=True) if any(used)}

    @property
    def is_parameter(self) -> bool:
        """Whether it is one physical parameter."""
        return bool(self.denominator == 1 and self.numerator.is_generator)

    @property
    def is_linear(self) -> bool:
        """Whether it is a sum of physical parameters times numbers."""
        return self.denominator.is_ground and all(sum(m) == 1 for m in self.numerator.itermonoms())

    @property
    def is_long(self) -> bool:
        """Whether sympy would take minutes to sort its terms."""
        return len(self.numerator) + len(self.denominator) > _LONG

    @cached_property
    def expression(self) -> sp.Expr:
        """Sum of fractions with monomials as denominators."""
        ring = self.numerator.ring
        if not self.denominator.is_term:
            return self.numerator.as_expr() / self.denominator.as_expr()
        fractions: dict[sp.Expr, list[sp.Expr]] = {}
        for (_, powers), coefficient in self.monomials.items():
            above = sp.Mul(*(g**p for g, p in zip(ring.symbols, powers, strict=True) if p > 0))
            below = sp.Mul(*(g**-p for g, p in zip(ring.symbols, powers, strict=True) if p < 0))
            fractions.setdefault(below, []).append(ring.domain.to_sympy(coefficient) * above)
        return sp.Add(*(sp.Add(*terms) / below for below, terms in fractions.items()))

    def __str__(self) -> str:
        """The expression. A long one is written term by term."""
        if not self.is_long:
            return str(self.expression)
        names, field = list(map(str, self.numerator.ring.symbols)), self.numerator.ring.domain

        def written(terms: Iterable[tuple[tuple[int, ...], Any]]) -> str:
            texts = []
            for powers, c in terms:
                factors = [f"{n}**{p}" if p != 1 else n for n, p in zip(names, powers, strict=True) if p]
                texts.append(
                    "*".join(factors if factors and c == 1 else [f"({field.to_sympy(c)})", *factors])
                )
            return " + ".join(texts)

        if self.denominator.is_term:
            return written((powers, c) for (_, powers), c in self.monomials.items())
        return f"({written(self.numerator.terms())})/({written(self.denominator.terms())})"

    def unit(self, units: dict[str, Unit]) -> Unit:
        """Unit, from those of the physical parameters; numbers and known constants have none."""
        total = Unit()
        names = [str(symbol) for symbol in self.numerator.ring.symbols[1:]]
        for sign, part in ((1, self.numerator), (-1, self.denominator)):
            for name, power in zip(names, part.LM[1:], strict=True):
                total = total * units[name] ** (sign * power) if power else total
        return total


def _over_monomial(polynomial: PolyElement, powers: tuple[int, ...], scale: Any) -> PolyElement:
    return polynomial.new({tuple(map(sub, m, powers)): c * scale for m, c in polynomial.items()})
