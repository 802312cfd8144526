"""Equations in measured signals: their terms, and the translation of operator rows into flat signal names.

The derivative of a jump, such as that of sign(v), is set to zero, as in the paper below [11]; every equation lists
these jumps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Axis, Between
from symid.errors import EliminationError
from symid.signal_names import derivative_name, split_derivative
from symid.symbolic.expressions import positive, time_derivative
from symid.symbolic.kernel import EliminationRow
from symid.symbolic.lagrange import ONE_INPUT, Kinematics, LawInput
from symid.symbolic.measurement import Measurement, measurement
from symid.symbolic.operators import OperatorModel, Row, add, by_power
from symid.symbolic.readings import reading_of, sensor_terms


@dataclass(frozen=True)
class RegressorTerm:
    """One signal term of an equation and its coefficient."""

    expression: sp.Expr  # in flat signal names: ``q2_d3``, ``sign(q2_d1)``
    order: int  # order of derivative of the displacement in it; -1 for a constant
    smooth: bool  # false for values of nonlinear laws
    coefficient: PolyElement  # polynomial in the physical parameters


@dataclass(frozen=True)
class InputOutputEquation:
    """sum(motion) = sum_kd force[k, d] F_d(k), all coefficients polynomials in the physical parameters."""

    motion: tuple[RegressorTerm, ...]  # terms of the measured motion
    # coefficients of the drive forces by order of derivative and signal; empty if no drive enters
    force: Mapping[tuple[int, str], PolyElement]
    multipliers: Mapping[str, PolyElement]  # multiplier of each body's balance
    # jumps such as ``sign(q2_d1)`` whose derivative is omitted: the equation does not hold where they jump
    dropped: tuple[sp.Expr, ...] = ()

    @property
    def is_linear(self) -> bool:
        """Whether coefficients are linear in the physical parameters, and those of the force are numbers."""
        linear = all(sum(m) == 1 for t in self.motion for m in t.coefficient.itermonoms())
        return linear and all(c.is_ground for c in self.force.values())

    @property
    def parameters(self) -> set[int]:
        """Places of its physical parameters among the generators of the ring."""
        coefficients = (*(term.coefficient for term in self.motion), *self.force.values())
        used = (m for coefficient in coefficients for m in coefficient.itermonoms())
        return {i for m in used for i, power in enumerate(m) if power}

    def scaled(self, factor: Any) -> InputOutputEquation:
        """The equation times a number of the coefficient field."""
        motion = tuple(replace(t, coefficient=t.coefficient.mul_ground(factor)) for t in self.motion)
        force = {key: c.mul_ground(factor) for key, c in self.force.items()}
        multipliers = {balance: c.mul_ground(factor) for balance, c in self.multipliers.items()}
        return InputOutputEquation(motion, force, multipliers, self.dropped)

    def cancelling(self, other: InputOutputEquation) -> list[Any]:
        """Numbers of the coefficient field by which a term of it cancels one of another equation in the sum."""
        terms = {t.expression: t.coefficient for t in self.motion}
        pairs = ((terms[t.expression], t.coefficient) for t in other.motion if t.expression in terms)
        factors = (-c / mine[m] for mine, its in pairs for m, c in its.terms() if m in mine)
        return list(dict.fromkeys(factors))

    def plus(self, other: InputOutputEquation) -> InputOutputEquation:
        """Sum of both equations."""
        terms = {t.expression: t for t in self.motion}
        for t in other.motion:
            mine = terms.get(t.expression)
            terms[t.expression] = replace(t, coefficient=t.coefficient + mine.coefficient) if mine else t
        motion = sorted((t for t in terms.values() if t.coefficient), key=lambda t: (not t.smooth, -t.order))
        force = add(self.force, other.force, 1)
        dropped = tuple(dict.fromkeys((*self.dropped, *other.dropped)))
        return InputOutputEquation(tuple(motion), force, add(self.multipliers, other.multipliers, 1), dropped)


class SignalWriter:
    """Writes combined rows in flat signal names."""

    def __init__(self, operators: OperatorModel, known: Measurement) -> None:
        self.operators, self.known = operators, known
        self.axis: Axis = operators.source.axis
        self.constants = {sp.Symbol(name): value for name, value in operators.source.constants.items()}
        self.scales = {s.signal: sensor_terms(operators, s) for s in self.axis.sensors if s.is_scaled}

    def equation(self, row: EliminationRow) -> InputOutputEquation:
        """Equation of a row of operators."""
        drives, inputs = driving_terms(row, self.operators)
        motion, offsets = self._motion_terms(row)
        terms = [*motion, *self._law_terms(add(inputs, {str(ONE_INPUT): offsets}, 1) if offsets else inputs)]
        force = {
            (order, signal): -c for signal, entry in drives.items() for order, c in by_power(entry).items()
        }
        return InputOutputEquation(
            tuple(terms), dict(sorted(force.items())), row.multipliers, self._dropped(inputs)
        )

    def _motion_terms(self, row: EliminationRow) -> tuple[list[RegressorTerm], PolyElement]:
        """Terms of the measured motion, and the constant that the offsets of sensors leave."""
        offsets = self.operators.ring.zero
        in_reading = {signal for signal in self.known.in_equations if reading_of(signal) in row.multipliers}
        collected: dict[tuple[str, int], RegressorTerm] = {}
        for index in range(len(self.known.basis)):
            for order, coefficient in sorted(by_power(row.entries.get(f"y{index}")).items(), reverse=True):
                for signal, left, share in self.known.derivative(index, order, in_reading):
                    previous = collected.get((signal, left))
                    part = coefficient * share
                    if scale := self.scales.get(signal):
                        offsets += part * scale.offset if left == 0 else 0
                        part *= scale.gain
                    total = part + (previous.coefficient if previous else 0)
                    term = RegressorTerm(sp.Symbol(derivative_name(signal, left)), order, True, total)
                    collected[signal, left] = term
        places = {sensor.signal: place for place, sensor in enumerate(self.axis.sensors)}
        ordered = sorted(collected.items(), key=lambda item: (-item[1].order, places[item[0][0]]))
        return [term for _, term in ordered if term.coefficient], offsets

    def _law_terms(self, inputs: Row) -> list[RegressorTerm]:
        terms: dict[sp.Expr, RegressorTerm] = {}
        for entry in self.operators.source.inputs:
            for power, coefficient in sorted(by_power(inputs.get(str(entry.symbol))).items()):
                if entry.expression.free_symbols:
                    law = _derivatives(entry.expression, power)[-1]
                    expression = self._written(law, entry) if law != 0 else law
                else:
                    expression = sp.Integer(0) if power else entry.expression
                if expression == 0:
                    continue
                expression, factor = self._without_factor(expression)
                if -expression in terms:
                    expression, factor = -expression, -factor
                total = coefficient * factor + (terms[expression].coefficient if expression in terms else 0)
                order = power + entry.expression.has(sp.Symbol("v")) if expression.free_symbols else -1
                terms[expression] = RegressorTerm(expression, order, False, total)
        return list(terms.values())

    def _dropped(self, inputs: Row) -> tuple[sp.Expr, ...]:
        """Jumps that the equation would have to differentiate."""
        dropped: dict[sp.Expr, None] = {}
        for entry in self.operators.source.inputs:
            power = max(by_power(inputs.get(str(entry.symbol))), default=0)
            for law in _derivatives(entry.expression, power)[:-1]:
                jumps = sorted(law.atoms(sp.sign, positive), key=sp.default_sort_key)
                dropped.update(dict.fromkeys(self._written(jump, entry) for jump in jumps))
        return tuple(sorted(dropped, key=str))

    def _written(self, expression: sp.Expr, entry: LawInput) -> sp.Expr:
        """A law, or a derivative of it, in the signals that measure the displacement of its joint."""
        used = {symbol: int(str(symbol)[1:]) for symbol in expression.free_symbols}
        lowest = min(used.values(), default=0)
        functional = self.operators.functional(Kinematics(self.axis).displacement(entry.joint))
        columns = self.known.substitute(functional)
        if not _sees(self.known, columns, lowest):
            measured = [f.signal for f in self.known.basis] + [f.signal for f in self.known.repeated]
            sensors = [s for s in self.axis.sensors if s.signal in measured]
            others = (other for other in self.axis.sensors if other.signal not in measured)
            more = ((other, measurement(self.operators, [*sensors, other])) for other in others)
            helps = (o.signal for o, known in more if _sees(known, known.substitute(functional), lowest))
            raise EliminationError(_advice(self.axis, entry, lowest, next(helps, None)))
        # Each derivative of the joint's displacement is a sum of measured functions; a sensor with gain and offset
        # enters as gain * reading + offset.
        field, values = self.operators.ring.domain, dict.fromkeys(used, sp.Integer(0))
        for symbol, order in used.items():
            for column, weight in columns.items():
                for signal, left, share in self.known.derivative(int(column[1:]), order):
                    factor = field.to_sympy(field.convert(share * weight))
                    reading = sp.Symbol(derivative_name(signal, left))
                    if scale := self.scales.get(signal):
                        reading = scale.gain.as_expr() * reading + (
                            scale.offset.as_expr() if left == 0 else 0
                        )
                    values[symbol] += factor * reading
        written = self._with_plain_jumps(expression.xreplace(values))
        open_ = set(map(sp.Symbol, self.axis.physical_parameters)) & written.free_symbols
        if scaled := [signal for signal, scale in self.scales.items() if scale.symbols & open_]:
            raise EliminationError(
                f"axis {self.axis.name!r}: {entry.element} depends on how large a motion is, which the gain or offset "
                f"of {scaled[0]} leaves open: give that as a known number, or identify by output error (method oe)"
            )
        return written

    def _with_plain_jumps(self, expression: sp.Expr) -> sp.Expr:
        """Jumps whose argument has the factor 1 or -1 at its first signal: sign(ratio*v) becomes sign(v) or -sign(v).

        Friction on both sides of a gear would otherwise give two columns that are multiples of each other.
        """
        plain = {}
        gains = {symbol for scale in self.scales.values() for symbol in scale.symbols}
        for jump in expression.atoms(sp.sign, positive):
            argument = sp.expand(jump.args[0])
            first = min(argument.free_symbols - set(self.constants) - gains, key=str)
            factor = argument.coeff(first)
            if factor not in (1, -1):
                direction = 1 if factor.subs(self.constants).subs(dict.fromkeys(gains, 1)) > 0 else -1
                plain[jump] = jump.func(direction * sp.expand(argument / factor))
        return expression.xreplace(plain)

    def _without_factor(self, expression: sp.Expr) -> tuple[sp.Expr, Any]:
        """A law's signal without its constant factor, and that factor as an element of the coefficient field."""
        field = self.operators.ring.domain
        factor, rest = expression.as_independent(
            *(expression.free_symbols - set(self.constants)), as_Add=False
        )
        if factor in (1, -1) or rest == 1:
            return expression, field.one
        return rest, self.operators.element(factor)

    def assumptions(self, equations: Sequence[InputOutputEquation]) -> tuple[str, ...]:
        """Assumptions made in the equations written so far."""
        jumps = dict.fromkeys(jump for e in equations for jump in e.dropped)
        written = {symbol for e in equations for term in e.motion for symbol in term.expression.free_symbols}
        used = {split_derivative(str(symbol))[0] for symbol in written}
        unused = (sensor.signal for sensor in self.known.repeated if sensor.signal not in used)
        return (
            *(f"derivatives of {jump} are taken as zero" for jump in jumps),
            *(f"{signal} repeats what the other sensors measure and is not used" for signal in unused),
        )


def driving_terms(row: EliminationRow, operators: OperatorModel) -> tuple[Row, Row]:
    """Coefficients of the drive forces, by signal, and of the nonlinear laws in a combination of balances."""
    force, inputs = dict[str, PolyElement](), dict[str, PolyElement]()
    for balance, multiplier in row.multipliers.items():
        force = add(force, operators.force[balance], multiplier)
        inputs = add(inputs, operators.inputs[balance], multiplier)
    return force, inputs


def _derivatives(law: sp.Expr, highest: int) -> list[sp.Expr]:
    """A law and its time derivatives, in the displacement u0 and its derivatives u1, u2, ..."""
    displacements = sp.symbols(f"u:{highest + 2}", real=True)
    derivatives = [law.xreplace({sp.Symbol("q"): displacements[0], sp.Symbol("v"): displacements[1]})]
    for _ in range(highest):
        derivatives.append(time_derivative(derivatives[-1], displacements))
    return derivatives


def _sees(known: Measurement, columns: Mapping[str, Any], lowest: int) -> bool:
    """Whether sensors measure a function, given by its columns, or a derivative of it up to an order."""
    return all(c.startswith("y") and known.basis[int(c[1:])].order <= lowest for c in columns)


def _advice(axis: Axis, entry: LawInput, lowest: int, sensor: str | None) -> str:
    quantity, joint = "position" if lowest == 0 else "position or velocity", entry.joint
    body, against = (joint.second, joint.first) if isinstance(joint, Between) else (joint, joint.on)
    added = f"add a {quantity} sensor of {body.name!r} relative to {against.name!r}"
    return (
        f"axis {axis.name!r}: {entry.element} acts on a motion that the sensors do not see, and a nonlinear law "
        f"cannot be eliminated: {added if sensor is None else f'measure {sensor} too'}, leave the law out, or "
        "identify by output error (method oe), which simulates it"
    )
