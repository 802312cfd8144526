"""Elimination of unmeasured displacements: equations in measured signals and their derivatives.

The balances of the bodies are combined with polynomial multipliers in s = d/dt such that unknown displacements
vanish and displacements known from a derivative only (an accelerometer) appear in that derivative. The multipliers
form a minimal basis (`symid.symbolic.kernel`): every balance is differentiated as little as possible. For the
paper's axis this gives [14]-[16] from q2, and [17]-[19] from q2 and ddq1.

The derivative of a jump, such as that of sign(v), is taken as zero, as the paper does; each result says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy import QQ
from sympy.polys.rings import PolyElement

from symid.axis import Sensor
from symid.errors import EliminationError
from symid.symbolic.equations import InputOutputEquation, SignalWriter, driving_terms
from symid.symbolic.expressions import positive
from symid.symbolic.kernel import (
    EliminationRow,
    differentiated,
    divisible,
    left_kernel,
    local_kernel,
    primitive,
)
from symid.symbolic.lagrange import InverseDynamicModel, Kinematics
from symid.symbolic.measurement import Measurement, measurement
from symid.symbolic.operators import OperatorModel, Row, by_power, operator_model
from symid.symbolic.polynomials import TooLargeError, common_divisor, quotient
from symid.symbolic.readings import with_readings
from symid.symbolic.scaling import Scaling, scaling_of

_SEPARATE = "each equation is the balance of one measured body: those of lower order have too many terms"
_MOST_TERMS_WITH_RATIOS = 1000
"""Largest number of terms in which ratios keep their names; larger results are computed faster with numbers."""
_FORCE = "force "
"""Before the signal of a drive among columns, which may be called as a body is."""


@dataclass(frozen=True)
class InputOutputModel:
    """Equations of an axis in the signals of a set of sensors."""

    source: InverseDynamicModel  # Lagrange's equations
    operators: OperatorModel  # the same equations as operators
    measured: tuple[Sensor, ...]  # the sensors used
    equations: tuple[InputOutputEquation, ...]  # as many as there are independent sensors
    assumptions: tuple[str, ...]  # assumptions made on the way


def eliminate(model: InverseDynamicModel, measured: Sequence[Sensor]) -> InputOutputModel:
    """Eliminate every displacement that the sensors do not measure.

    >>> from symid.axis import load_axis
    >>> from symid.symbolic.lagrange import inverse_dynamics
    >>> axis = load_axis("direct_2m1s")
    >>> io = eliminate(inverse_dynamics(axis), axis.measured(("q2", "ddq1")))
    >>> [str(term.expression) for term in io.equations[1].motion]
    ['ddq1_d2', 'q2_d3', 'ddq1_d1', 'ddq1']
    """
    # Ratios of gears make polynomial arithmetic slow. They are scaled out as units of the coordinates; a ratio in a
    # loop, where that is impossible, becomes an exact number in the coefficients.
    operators, known, same = _posed(model, measured)
    rows, scaling = _rows(operators, known), None
    while operators.ring.domain != QQ and scaling is None:
        found = scaling_of(rows, operators)
        if isinstance(found, Scaling):
            scaling = found
        else:
            operators, known, same = _posed(model, measured, (*map(str, operators.numbers), *found))
            rows = _rows(operators, known)
    powers = {f"y{i}": f.order for i, f in enumerate(known.basis) if f.order}
    if scaling is None:
        combined, separate = _combined(rows, known, powers, operators)
    else:
        plain = {balance: scaling.scaled(row) for balance, row in rows.items()}
        found_rows, separate = _combined(plain, known, powers, scaling.operators(operators, rows))
        if sum(len(entry) for row in found_rows for entry in row.entries.values()) > _MOST_TERMS_WITH_RATIOS:
            operators, known, same = _posed(model, measured, tuple(model.constants))
        combined = [scaling.restored(row, operators.ring, model.constants) for row in found_rows]
    # The entries are polynomials in s, and s^k of a measured function is its k-th derivative: each row is an equation
    # in derivatives of signals. Equations with the force in its lowest derivative come first.
    signals = SignalWriter(operators, known)
    equations = [signals.equation(row) for row in combined]
    drives = [*(d.signal for d in model.axis.drives), *(s.signal for s in model.axis.sensors)]

    def place(equation: InputOutputEquation) -> tuple[bool, int, int, int]:
        lowest = min((order for order, _ in equation.force), default=0)
        first = min((drives.index(d) for order, d in equation.force if order == lowest), default=0)
        return not equation.force, lowest, max((t.order for t in equation.motion), default=0), first

    equations.sort(key=place)
    driven = tuple(_driven(equation, equations, operators) for equation in equations)
    assumptions = (
        *signals.assumptions(equations),
        *(f"{signal} repeats what its drive's record says and is not used" for signal in same),
        *([_SEPARATE] if separate else []),
    )
    return InputOutputModel(model, operators, tuple(measured), driven, assumptions)


def _posed(
    model: InverseDynamicModel, measured: Sequence[Sensor], numbers: Sequence[str] = ()
) -> tuple[OperatorModel, Measurement, tuple[str, ...]]:
    operators = operator_model(model, numbers)
    known = measurement(operators, measured)
    whole, same = with_readings(operators, measured, known.in_equations)
    return whole, known, same


def _combined(
    rows: Mapping[str, Row], known: Measurement, powers: Mapping[str, int], operators: OperatorModel
) -> tuple[list[EliminationRow], bool]:
    """Minimal combinations of the balances, and False; one of each balance, and True, where those grow too large."""
    # With several measured functions left, the basis is found order by order, and its polynomials may grow too large on
    # the way. The combination of a single balance with those of the unknown bodies consists of minors.
    try:
        kernel = left_kernel(rows, known.unknown, operators.ring)
        return _distinct(divisible(kernel, powers), operators), False
    except TooLargeError:
        pass
    try:
        local = local_kernel(rows, known.unknown, operators.ring)
        return [differentiated(row, powers, operators.ring) for row in local], True
    except TooLargeError as error:
        axis = operators.source.axis.name
        raise EliminationError(
            f"axis {axis!r}: eliminating {', '.join(known.unknown)} leads to too many terms: "
            f"add a sensor at one of these bodies"
        ) from error


def _rows(operators: OperatorModel, known: Measurement) -> dict[str, Row]:
    """Balances in measured functions and unknown displacements."""
    return {balance: known.substitute(motion) for balance, motion in operators.motion.items()}


def _distinct(rows: Sequence[EliminationRow], operators: OperatorModel) -> list[EliminationRow]:
    """Rows reduced until none contains every signal of another one, or of its derivatives.

    Otherwise any multiple of the other row could be added without changing the signals, and no data would determine the
    parameters. A row linear in the physical parameters is never added: it shares its parameters with other equations.
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
    """The row reduced by another whose signals, or their derivatives, it all contains; None if it does not."""
    if other.is_linear:
        return None
    mine = _signals_of(row, operators)
    for order in range(1 + max(0, row.degree - other.degree)):
        theirs = _signals_of(other, operators, order)
        if theirs.keys() <= mine.keys():
            shifted = other.scaled(operators.ring.gens[0] ** order)
            leading = max(theirs, key=lambda signal: (signal[0].startswith(_FORCE), signal[1]))
            common = common_divisor([mine[leading], theirs[leading]])
            own_factor, other_factor = quotient(mine[leading], common), quotient(theirs[leading], common)
            reduced = row.combine(other_factor, shifted, -own_factor)
            return primitive(reduced, operators.ring, keep_powers_of_s=True)
    return None


def _signals_of(
    row: EliminationRow, operators: OperatorModel, derivative: int = 0
) -> dict[tuple[str, int], PolyElement]:
    """Coefficients of a derivative of a row by signal and order of derivative."""
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
    powers = (
        (column, power + derivative, c)
        for column, entry in columns.items()
        for power, c in by_power(entry).items()
    )
    return {(column, order): c for column, order, c in powers if order == 0 or column in smooth}


def _driven(
    equation: InputOutputEquation, equations: Sequence[InputOutputEquation], operators: OperatorModel
) -> InputOutputEquation:
    """Add an equation that contains the force to one that does not, if both are linear in the physical parameters.

    X = 0 also solves 0 = D X: with noise in D, least squares would shrink the parameters towards it. The sum and the
    other equation together are equivalent. The equation with the force that gives fewest terms is added.
    A balance of forces is multiplied by a ratio of the axis before it is added to one of torques, and vice versa.
    """
    if equation.force or not equation.is_linear:
        return equation
    axis = operators.source.axis
    turns = {body.name: body.turns for body in axis.free_bodies}
    metres_per_radian = operators.element(Kinematics(axis).metres_per_radian(axis))

    def of_torques(balances: Mapping[str, PolyElement]) -> bool:
        return turns[next(iter(balances))]

    def of_balances(one: InputOutputEquation) -> bool:
        return one.multipliers.keys() <= turns.keys()

    sums = []
    for other in equations:
        if other.force and other.is_linear and of_balances(other) and of_balances(equation):
            power = int(of_torques(other.multipliers)) - int(of_torques(equation.multipliers))
            sums.append(equation.scaled(metres_per_radian**power).plus(other))
    return min(
        sums,
        key=lambda e: (max(order for order, _ in e.force), sum(len(t.coefficient) for t in e.motion)),
        default=equation,
    )
