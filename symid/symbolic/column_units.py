"""Units of signal expressions, such as the columns of a regressor."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod

import sympy as sp

from symid.signal_names import split_derivative
from symid.units import Unit


def unit_of(expression: sp.Expr, signals: Mapping[str, Unit]) -> Unit | None:
    """Unit of an expression in flat signal names; None if a number in it has a unit, such as that of a pitch.

    >>> v = sp.Symbol("q_d1")
    >>> str(unit_of(v * sp.Abs(v) * sp.sign(v), {"q": Unit.of("m")}))
    'm^2/s^2'
    >>> unit_of(12.6 * v**2 * sp.sin(12.6 * sp.Symbol("q")) + sp.Symbol("q_d2"), {"q": Unit.of("m")}) is None
    True
    """
    match expression:
        case sp.Symbol():
            signal, order = split_derivative(expression.name)
            return signals.get(signal, Unit()) / Unit.of("s") ** order
        case sp.Mul():
            factors = [unit_of(factor, signals) for factor in expression.args]
            known = [unit for unit in factors if unit is not None]
            return prod(known, start=Unit()) if len(known) == len(factors) else None
        case sp.Pow() if expression.exp.is_Integer:
            base = unit_of(expression.base, signals)
            return base and base ** int(expression.exp)
        case sp.Abs():
            return unit_of(expression.args[0], signals)
        case sp.Add():
            # Ratios and gravity have units that are not given: terms without them tell.
            plain = [term for term in expression.args if _holds_signals_only(term, signals)]
            units = {unit_of(term, signals) for term in plain}
            return units.pop() if len(units) == 1 else None
        case _:
            return Unit()


def _holds_signals_only(term: sp.Expr, signals: Mapping[str, Unit]) -> bool:
    names = {split_derivative(str(symbol))[0] for symbol in term.free_symbols}
    return bool(names) and names <= set(signals)
