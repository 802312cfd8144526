"""Combined rows whose parameters data determine: none contains every signal of another one."""

from collections.abc import Mapping, Sequence
from random import Random
from typing import Any, TypeAlias

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.symbolic.equations import driving_terms
from symid.symbolic.expressions import positive
from symid.symbolic.kernel import EliminationRow, primitive
from symid.symbolic.operators import OperatorModel, by_power
from symid.symbolic.parameter_function import ParameterFunction
from symid.symbolic.polynomials import common_divisor, quotient
from symid.symbolic.span import Span

_FORCE = "force "
"""Before the signal of a drive among columns, which may be called as a body is."""
SignalKey: TypeAlias = tuple[str, int]
"""A column of a row, and an order of derivative."""
SignalKeys: TypeAlias = dict[SignalKey, PolyElement]
"""Coefficients of signals."""


def distinct(
    rows: Sequence[EliminationRow], powers: Mapping[str, int], operators: OperatorModel
) -> list[EliminationRow]:
    """Rows reduced until none contains every signal of another one, or of its derivatives.

    Otherwise any multiple of the other row could be added without changing the signals, and no data would determine the
    parameters. A row linear in the physical parameters is not added to another such row, with which it shares them.
    """
    reduced = list(rows)
    while True:
        scaled = _with_scale(reduced, operators)
        pairs = ((i, j) for i in range(len(reduced)) for j in range(len(reduced)) if i != j)
        smaller = (
            (i, _reduced_by(reduced[i], reduced[j], powers, operators, shared=scaled[j])) for i, j in pairs
        )
        smallest = next(((i, row) for i, row in smaller if row), None)
        if smallest is None:
            return reduced
        reduced[smallest[0]] = smallest[1]


def _with_scale(rows: Sequence[EliminationRow], operators: OperatorModel) -> list[bool]:
    """Which rows are linear in parameters that data determine, and not up to a factor only.

    Those hold a force, or a parameter of a linear row that does.
    """

    def parameters(row: EliminationRow) -> set[int]:
        entries = _signals_of(row, operators).values()
        return {i for entry in entries for m in entry.itermonoms() for i, power in enumerate(m) if power}

    driven = [row.is_linear and bool(driving_terms(row, operators)[0]) for row in rows]
    known = {i for row, is_driven in zip(rows, driven, strict=True) if is_driven for i in parameters(row)}
    return [
        is_driven or (row.is_linear and bool(known & parameters(row)))
        for row, is_driven in zip(rows, driven, strict=True)
    ]


def _reduced_by(
    row: EliminationRow,
    other: EliminationRow,
    powers: Mapping[str, int],
    operators: OperatorModel,
    *,
    shared: bool,
) -> EliminationRow | None:
    """The row reduced by a multiple of another whose signals it all contains; None if there is no such multiple.

    `shared`: the other row determines parameters that this row holds too.
    """
    if shared and row.is_linear:
        return None
    mine = _signals_of(row, operators)
    for multiple in _multiples_within(mine, other, row.degree - other.degree, operators):
        theirs = _signals_of(multiple, operators)
        if shared and _is_distinct(mine, theirs, _signals_of(other, operators)):
            continue
        # The force goes first. Beside a linear row it stays the output, and what is differentiated most goes.
        of_force = {signal: signal[0].startswith(_FORCE) for signal in theirs}
        taken = {(c, order): order - powers.get(c, 0) for c, order in theirs}
        leading = max(theirs, key=lambda signal: (of_force[signal] != shared, taken[signal]))
        reduced = _cleared(row, multiple, mine[leading], theirs[leading])
        return primitive(reduced, operators.ring, keep_powers_of_s=True)
    return None


def _multiples_within(
    signals: SignalKeys, row: EliminationRow, degree: int, operators: OperatorModel
) -> list[EliminationRow]:
    """Basis of the multiples p(s) row, p of at most a degree, without signals other than these."""
    # Each signal beyond these is eliminated from the derivatives of the row, at the cost of one of them.
    multiples = [row.scaled(operators.ring.gens[0] ** k) for k in range(1 + max(0, degree))]
    while multiples:
        signals_of_each = [_signals_of(multiple, operators) for multiple in multiples]
        beyond = next(
            (signal for present in signals_of_each for signal in present if signal not in signals), None
        )
        if beyond is None:
            break
        pivot = next(i for i, present in enumerate(signals_of_each) if beyond in present)
        multiples = [
            _cleared(multiple, multiples[pivot], present[beyond], signals_of_each[pivot][beyond])
            if beyond in present
            else multiple
            for i, (multiple, present) in enumerate(zip(multiples, signals_of_each, strict=True))
            if i != pivot
        ]
    return multiples


def _cleared(
    row: EliminationRow, other: EliminationRow, mine: PolyElement, theirs: PolyElement
) -> EliminationRow:
    """The row less the multiple of another that clears a signal with these coefficients."""
    common = common_divisor([mine, theirs])
    return row.combine(quotient(theirs, common), other, -quotient(mine, common))


def _is_distinct(mine: SignalKeys, theirs: SignalKeys, linear: SignalKeys) -> bool:
    """Whether a multiple of a linear row, added to another row, would show in its minimal parameters.

    The parameters of the linear row are those of both, and signals of the other one with the same coefficient share
    one.
    """
    ring = next(iter(mine.values())).ring
    output = min(mine, key=lambda signal: (not signal[0].startswith(_FORCE), signal[1]))
    draw = Random(len(ring.gens))
    point = [(generator, draw.randrange(1, 10**9)) for generator in ring.gens]

    def change(signal: SignalKey) -> Any:
        """Change of a signal's coefficient beside that of the output, at a random point."""
        added = theirs.get(signal, ring.zero) * mine[output] - theirs.get(output, ring.zero) * mine[signal]
        return ring(added).evaluate(point)

    # The minimal parameters: those of the linear row first, then a basis of the coefficients beside the output.
    span, changes = Span(), Span()
    monomials = [m for entry in linear.values() for m in entry.itermonoms()]
    shared = [x for i, x in enumerate(ring.gens) if i and any(m[i] for m in monomials)]
    for parameter in shared:
        span.add(ParameterFunction(parameter, ring.one).coordinates({}))
    functions = {
        signal: ParameterFunction.quotient(mine[signal], mine[output]).coordinates({})
        for signal in mine
        if signal != output
    }
    for function in functions.values():
        span.add(function)
    # A minimal parameter of this row alone may change freely, in proportion to its shares of the signals. The multiple
    # shows unless such changes together are what it does to the coefficients.
    shares = {signal: span.coordinates(function) or {} for signal, function in functions.items()}
    for j in range(len(shared), max((max(s, default=0) for s in shares.values()), default=0) + 1):
        changes.add({signal: s[j] for signal, s in shares.items() if j in s})
    return changes.coordinates({signal: c for signal in shares if (c := change(signal))}) is None


def _signals_of(row: EliminationRow, operators: OperatorModel) -> SignalKeys:
    """Coefficients of a row by signal and order of derivative; derivatives of jumps are taken as zero."""
    drives, inputs = driving_terms(row, operators)
    forces = {_FORCE + signal: entry for signal, entry in drives.items()}
    columns = {**row.entries, **inputs, **forces}
    smooth = {
        *forces,
        *row.entries,
        *(
            str(w.symbol)
            for w in operators.source.inputs
            if w.expression.free_symbols and not isinstance(w.expression, (sp.sign, positive))
        ),
    }
    powers = ((column, power, c) for column, entry in columns.items() for power, c in by_power(entry).items())
    return {(column, order): c for column, order, c in powers if order == 0 or column in smooth}
