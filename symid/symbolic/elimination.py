"""Elimination of the displacements that no sensor sees: equations in measured signals and their derivatives.

The balances of the bodies are combined with polynomial multipliers in s = d/dt such that unknown displacements
vanish and displacements known from a derivative only (an accelerometer) appear in that derivative. The multipliers
form a minimal basis (`symid.symbolic.kernel`): every balance is differentiated as little as possible. For the
paper's axis this gives [14]-[16] from q2, and [17]-[19] from q2 and ddq1.

The derivative of a jump, such as that of sign(v), is taken as zero, as the paper does; each result says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Axis, Between, Body, Joint, Sensor
from symid.errors import EliminationError
from symid.signals import derivative_name, split_derivative
from symid.symbolic.expressions import is_smooth, positive, time_derivative
from symid.symbolic.kernel import EliminationRow, divisible, left_kernel, primitive
from symid.symbolic.lagrange import InverseDynamicModel, Kinematics, LawInput
from symid.symbolic.measurement import Measurement, measurement, motion_columns
from symid.symbolic.operators import OperatorModel, Row, add, operator_model

_DISPLACEMENT = sp.symbols("u:2", real=True)


@dataclass(frozen=True)
class RegressorTerm:
    """One signal term of an equation and its coefficient.

    Parameters
    ----------
    expression : sympy.Expr
        In flat signal names: ``q2_d3``, ``sign(q2_d1)``.
    order : int
        Order of derivative of the displacement in it; -1 for a constant.
    smooth : bool
        False for values of nonlinear laws.
    coefficient : PolyElement
        Polynomial in the physical parameters.
    """

    expression: sp.Expr
    order: int
    smooth: bool
    coefficient: PolyElement


@dataclass(frozen=True)
class InputOutputEquation:
    """sum(motion) = sum_k force[k] F(k), all coefficients polynomials in the physical parameters.

    Parameters
    ----------
    motion : tuple of RegressorTerm
        Terms of the measured motion.
    force : mapping of int to PolyElement
        Coefficients of the drive force by order of its derivative; empty if the drive does not enter.
    multipliers : mapping of str to PolyElement
        What each body's balance was multiplied by.
    """

    motion: tuple[RegressorTerm, ...]
    force: Mapping[int, PolyElement]
    multipliers: Mapping[str, PolyElement]

    @property
    def is_linear(self) -> bool:
        """Whether the coefficients are linear in the physical parameters and the force has numbers for coefficients."""
        linear = all(sum(m) == 1 for t in self.motion for m in t.coefficient.itermonoms())
        return linear and all(c.is_ground for c in self.force.values())

    def plus(self, other: InputOutputEquation) -> InputOutputEquation:
        """Sum of two equations."""
        terms = {t.expression: t for t in self.motion}
        for t in other.motion:
            mine = terms.get(t.expression)
            terms[t.expression] = replace(t, coefficient=t.coefficient + mine.coefficient) if mine else t
        motion = sorted((t for t in terms.values() if t.coefficient), key=lambda t: (not t.smooth, -t.order))
        force = add(self.force, other.force, 1)
        return InputOutputEquation(tuple(motion), force, add(self.multipliers, other.multipliers, 1))


@dataclass(frozen=True)
class InputOutputModel:
    """Equations of an axis in the signals of a set of sensors.

    Parameters
    ----------
    source : InverseDynamicModel
        Lagrange's equations.
    operators : OperatorModel
        The same as operators.
    measured : tuple of Sensor
        The sensors used.
    equations : tuple of InputOutputEquation
        As many as there are independent sensors.
    assumptions : tuple of str
        What was assumed on the way.
    """

    source: InverseDynamicModel
    operators: OperatorModel
    measured: tuple[Sensor, ...]
    equations: tuple[InputOutputEquation, ...]
    assumptions: tuple[str, ...]


def eliminate(model: InverseDynamicModel, measured: Sequence[Sensor]) -> InputOutputModel:
    """Eliminate every displacement that the sensors do not see.

    Parameters
    ----------
    model : InverseDynamicModel
        Lagrange's equations.
    measured : sequence of Sensor
        Sensors to use; any set.

    Raises
    ------
    EliminationError
        If a nonlinear law acts on a motion that is not measured, or the sensors leave a motion undetermined.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.symbolic.lagrange import inverse_dynamics
    >>> axis = load_axis("direct_2m1s")
    >>> io = eliminate(inverse_dynamics(axis), axis.measured(("q2", "ddq1")))
    >>> [str(term.expression) for term in io.equations[1].motion]
    ['ddq1_d2', 'q2_d3', 'ddq1_d1', 'ddq1']
    """
    operators = operator_model(model)
    known = measurement(operators, measured)
    rows = {balance: motion_columns(operators, known, balance) for balance in operators.motion}
    kernel = left_kernel(rows, known.unknown, operators.ring)
    combined = divisible(kernel, {f"y{i}": f.order for i, f in enumerate(known.basis) if f.order})
    signals = _SignalWriter(operators, known)
    equations = [signals.equation(row) for row in _distinct(combined, operators)]
    equations.sort(
        key=lambda e: (not e.force, min(e.force, default=0), max((t.order for t in e.motion), default=0))
    )
    driven = tuple(_driven(equation, equations) for equation in equations)
    return InputOutputModel(model, operators, tuple(measured), driven, signals.assumptions(equations))


def _distinct(rows: Sequence[EliminationRow], operators: OperatorModel) -> list[EliminationRow]:
    """Rows reduced until none holds every signal of another one, or of its derivatives.

    Otherwise a multiple of the other could be added to it without a trace, and no data would determine its parameters.
    A row linear in the physical parameters is never added: they stand in other equations too, and cannot change alone.
    """
    reduced = list(rows)
    while True:
        pairs = ((i, j) for i in range(len(reduced)) for j in range(len(reduced)) if i != j)
        smaller = ((i, _reduced_by(reduced[i], reduced[j], operators)) for i, j in pairs)
        found = next(((i, row) for i, row in smaller if row), None)
        if found is None:
            return reduced
        reduced[found[0]] = found[1]


def _reduced_by(
    row: EliminationRow, other: EliminationRow, operators: OperatorModel
) -> EliminationRow | None:
    """The row without its highest signal of the other row, if it holds all signals of that row or of a derivative."""
    if other.is_linear:
        return None
    s = operators.ring.gens[0]
    for order in range(1 + max(0, row.degree - other.degree)):
        mine = _signals_of(row, operators)
        shifted = other.scaled(s**order)
        theirs = _signals_of(shifted, operators)
        if theirs.keys() <= mine.keys():
            leading = max(theirs, key=lambda signal: (signal[0] == "", signal[1]))
            _, own_factor, other_factor = mine[leading].cofactors(theirs[leading])
            return primitive(
                row.combine(other_factor, shifted, -own_factor), operators.ring, keep_powers_of_s=True
            )
    return None


def _signals_of(row: EliminationRow, operators: OperatorModel) -> dict[tuple[str, int], PolyElement]:
    """Coefficients of a row by signal and order of derivative; the drive's name is empty here."""
    columns = dict(row.entries)
    for balance, multiplier in row.multipliers.items():
        columns = add(columns, {"": operators.force[balance]} if operators.force[balance] else {}, multiplier)
        columns = add(columns, operators.inputs[balance], multiplier)
    smooth = {
        "",
        *row.entries,
        *(str(w.symbol) for w in operators.source.inputs if _has_derivatives(w.expression)),
    }
    powers = (
        (column, order, c) for column, entry in columns.items() for order, c in _by_power(entry).items()
    )
    return {(column, order): c for column, order, c in powers if order == 0 or column in smooth}


def _has_derivatives(expression: sp.Expr) -> bool:
    return bool(expression.free_symbols) and not isinstance(expression, (sp.sign, positive))


def _driven(equation: InputOutputEquation, equations: Sequence[InputOutputEquation]) -> InputOutputEquation:
    """Add an equation that holds the force to one that does not, if both are linear in the physical parameters.

    0 = D X holds for X = 0 too: with noise in D, least squares would shrink the parameters towards it. The sum says
    the same in common with the other equation. Of those that hold the force, the one that leaves fewest terms is taken.
    """
    if equation.force or not equation.is_linear:
        return equation
    sums = [equation.plus(other) for other in equations if other.force and other.is_linear]
    return min(
        sums, key=lambda e: (max(e.force), sum(len(t.coefficient) for t in e.motion)), default=equation
    )


class _SignalWriter:
    """Writes combined rows in flat signal names."""

    def __init__(self, operators: OperatorModel, known: Measurement) -> None:
        self.operators, self.known = operators, known
        self.axis: Axis = operators.source.axis
        self.constants = {sp.Symbol(name): value for name, value in operators.source.constants.items()}
        self.dropped: dict[str, None] = {}

    def equation(self, row: EliminationRow) -> InputOutputEquation:
        """Equation that a row stands for."""
        force: Row = {}
        inputs: Row = {}
        for balance, multiplier in row.multipliers.items():
            inputs = add(inputs, self.operators.inputs[balance], multiplier)
            force = (
                add(force, {"": self.operators.force[balance]}, multiplier)
                if self.operators.force[balance]
                else force
            )
        terms = [*self._motion_terms(row), *self._law_terms(inputs)]
        forces = {order: -c for order, c in _by_power(force[""]).items()} if force else {}
        return InputOutputEquation(tuple(terms), dict(sorted(forces.items())), row.multipliers)

    def _motion_terms(self, row: EliminationRow) -> list[RegressorTerm]:
        collected: dict[tuple[str, int], RegressorTerm] = {}
        for index in range(len(self.known.basis)):
            for order, coefficient in sorted(_by_power(row.entries.get(f"y{index}")).items(), reverse=True):
                for signal, left, share in self.known.derivative(index, order):
                    previous = collected.get((signal, left))
                    total = coefficient * share + (previous.coefficient if previous else 0)
                    term = RegressorTerm(sp.Symbol(derivative_name(signal, left)), order, True, total)
                    collected[signal, left] = term
        return [term for _, term in sorted(collected.items(), key=self._place) if term.coefficient]

    def _place(self, item: tuple[tuple[str, int], RegressorTerm]) -> tuple[int, int]:
        (signal, _), term = item
        return -term.order, [sensor.signal for sensor in self.axis.sensors].index(signal)

    def _law_terms(self, inputs: Row) -> list[RegressorTerm]:
        terms: dict[sp.Expr, RegressorTerm] = {}
        for entry in self.operators.source.inputs:
            for power, coefficient in sorted(_by_power(inputs.get(str(entry.symbol))).items()):
                expression = self._law_signal(entry, power)
                if expression == 0:
                    continue
                expression, factor = self._without_factor(expression)
                if -expression in terms:
                    expression, factor = -expression, -factor
                total = coefficient * factor + (terms[expression].coefficient if expression in terms else 0)
                order = (
                    -1
                    if not expression.free_symbols
                    else 1 + power
                    if entry.expression.has(sp.Symbol("v"))
                    else power
                )
                terms[expression] = RegressorTerm(expression, order, False, total)
        return list(terms.values())

    def _law_signal(self, entry: LawInput, power: int) -> sp.Expr:
        """The power-th derivative of a law's expression in flat signal names."""
        if not entry.expression.free_symbols:
            return sp.Integer(0) if power else entry.expression
        displacements = sp.symbols(f"u:{power + 2}", real=True)
        expression = entry.expression.xreplace(
            {sp.Symbol("q"): displacements[0], sp.Symbol("v"): displacements[1]}
        )
        if power and not is_smooth(expression):
            jumps = sorted(
                {str(self._written(e, entry)) for e in expression.atoms(sp.Function) if not is_smooth(e)}
            )
            self.dropped.update(dict.fromkeys(jumps))
        for _ in range(power):
            expression = time_derivative(expression, displacements)
        return self._written(expression, entry) if expression != 0 else expression

    def _written(self, expression: sp.Expr, entry: LawInput) -> sp.Expr:
        used = {symbol: int(str(symbol)[1:]) for symbol in expression.free_symbols}
        lowest = min(used.values(), default=0)
        functional = self.operators.functional(Kinematics(self.axis).displacement(entry.joint))
        columns = self.known.substitute(functional)
        unseen = [c for c in columns if not c.startswith("y") or self.known.basis[int(c[1:])].order > lowest]
        if unseen:
            raise EliminationError(_advice(self.axis, entry, lowest))
        field = self.operators.ring.domain
        values = {
            symbol: sp.Add(
                *(
                    field.to_sympy(field.convert(share * weight)) * sp.Symbol(derivative_name(signal, left))
                    for column, weight in columns.items()
                    for signal, left, share in self.known.derivative(int(column[1:]), order)
                )
            )
            for symbol, order in used.items()
        }
        return self._with_plain_jumps(expression.xreplace(values))

    def _with_plain_jumps(self, expression: sp.Expr) -> sp.Expr:
        """Jumps in arguments whose first signal has the factor 1 or -1: sign(ratio*v) is sign(v) or -sign(v).

        Friction on both sides of a gear would otherwise give two columns that are multiples of each other.
        """
        plain = {}
        for jump in expression.atoms(sp.sign, positive):
            argument = sp.expand(jump.args[0])
            first = min(argument.free_symbols - set(self.constants), key=str)
            factor = argument.coeff(first)
            if factor not in (1, -1):
                direction = 1 if factor.subs(self.constants) > 0 else -1
                plain[jump] = jump.func(direction * sp.expand(argument / factor))
        return expression.xreplace(plain)

    def _without_factor(self, expression: sp.Expr) -> tuple[sp.Expr, Any]:
        """A law's signal without a constant factor, and that factor as an element of the coefficient field."""
        field = self.operators.ring.domain
        factor, rest = expression.as_independent(
            *(expression.free_symbols - set(self.constants)), as_Add=False
        )
        return (expression, field.one) if factor in (1, -1) or rest == 1 else (rest, field.from_sympy(factor))

    def assumptions(self, equations: Sequence[InputOutputEquation]) -> tuple[str, ...]:
        """What has to be said about the equations written."""
        said = [f"derivatives of {jump} are taken as zero" for jump in self.dropped]
        written = {symbol for e in equations for term in e.motion for symbol in term.expression.free_symbols}
        used = {split_derivative(str(symbol))[0] for symbol in written}
        said += [
            f"{sensor.signal} repeats what the other sensors measure and is not used"
            for sensor in self.known.repeated
            if sensor.signal not in used
        ]
        return tuple(said)


def _by_power(entry: PolyElement | None) -> dict[int, PolyElement]:
    """Coefficients of a polynomial by powers of s, as polynomials in the parameters."""
    powers: dict[int, dict[tuple[int, ...], Any]] = {}
    if entry is not None:
        for monomial, value in entry.terms():
            powers.setdefault(monomial[0], {})[(0, *monomial[1:])] = value
    return (
        {power: entry.ring.from_dict(terms) for power, terms in powers.items()} if entry is not None else {}
    )


def _advice(axis: Axis, entry: LawInput, lowest: int) -> str:
    quantity = "position" if lowest == 0 else "position or velocity"
    return (
        f"axis {axis.name!r}: {entry.element} acts on a motion that the sensors do not see, and a nonlinear law "
        f"cannot be eliminated: add a {quantity} sensor of {_motion(entry.joint)}, or leave the law out"
    )


def _motion(joint: Joint) -> str:
    if isinstance(joint, Between):
        return f"{joint.second.name!r} relative to {joint.first.name!r}"
    assert isinstance(joint, Body)
    return f"{joint.name!r} relative to {joint.on.name!r}"
