"""Elimination of unmeasured displacements: equations in measured signals and their derivatives.

The balances of the bodies are combined with polynomial multipliers in s = d/dt such that unknown displacements
vanish and displacements known from a derivative only (an accelerometer) appear in that derivative. The multipliers
form a minimal basis (`symid.symbolic.kernel`): every balance is differentiated as little as possible. For the
paper's axis this gives [14]-[16] from q2, and [17]-[19] from q2 and ddq1.

The derivative of a jump, such as that of sign(v), is taken as zero, as in the paper; each result states it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sympy import QQ
from sympy.polys.rings import PolyElement

from symid.axis import Sensor
from symid.errors import EliminationError
from symid.symbolic.distinct_rows import distinct
from symid.symbolic.equations import InputOutputEquation, SignalWriter
from symid.symbolic.kernel import EliminationRow, differentiated, divisible, left_kernel, local_kernel
from symid.symbolic.lagrange import InverseDynamicModel, Kinematics
from symid.symbolic.measurement import Measurement, measurement
from symid.symbolic.operators import OperatorModel, Row, operator_model
from symid.symbolic.polynomials import TooLargeError
from symid.symbolic.readings import with_readings
from symid.symbolic.scaling import Scaling, scaling_of

_SEPARATE = "each equation is the balance of one measured body: those of lower order have too many terms"
_MOST_TERMS_WITH_RATIOS = 1000
"""Largest number of terms in which ratios keep their names; larger results are computed faster with numbers."""


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
        exponents = scaling_of(rows, operators)
        if isinstance(exponents, Scaling):
            scaling = exponents
        else:
            operators, known, same = _posed(model, measured, (*map(str, operators.numbers), *exponents))
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
    pairs = [(signals.equation(row), row) for row in combined]
    drives = [*(d.signal for d in model.axis.drives), *(s.signal for s in model.axis.sensors)]

    def place(pair: tuple[InputOutputEquation, EliminationRow]) -> tuple[bool, int, int, int]:
        equation, _ = pair
        lowest = min((order for order, _ in equation.force), default=0)
        first = min((drives.index(d) for order, d in equation.force if order == lowest), default=0)
        return not equation.force, lowest, max((t.order for t in equation.motion), default=0), first

    pairs.sort(key=place)
    equations = [equation for equation, _ in pairs]
    # The relation of sensors of known gains holds no parameter.
    driven = tuple(_driven(equation, row, pairs, signals) for equation, row in pairs if equation.parameters)
    assumptions = (
        *signals.assumptions(equations),
        *(f"{signal} repeats the record of its drive and is not used" for signal in same),
        *([_SEPARATE] if separate else []),
    )
    return InputOutputModel(model, operators, tuple(measured), driven, assumptions)


def _posed(
    model: InverseDynamicModel, measured: Sequence[Sensor], numbers: Sequence[str] = ()
) -> tuple[OperatorModel, Measurement, tuple[str, ...]]:
    operators = operator_model(model, numbers)
    known = measurement(operators, measured)
    with_sensors, same = with_readings(operators, measured, known.in_equations)
    return with_sensors, known, same


def _combined(
    rows: Mapping[str, Row], known: Measurement, powers: Mapping[str, int], operators: OperatorModel
) -> tuple[list[EliminationRow], bool]:
    """Minimal combinations of the balances, and False; one of each balance, and True, where those grow too large."""
    # With several measured functions left, the basis is found order by order, and its polynomials may grow too large on
    # the way. The combination of a single balance with those of the unknown bodies consists of minors.
    try:
        kernel = left_kernel(rows, known.unknown, operators.ring)
        return distinct(divisible(kernel, powers), powers, operators), False
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


def _driven(
    equation: InputOutputEquation,
    row: EliminationRow,
    pairs: Sequence[tuple[InputOutputEquation, EliminationRow]],
    signals: SignalWriter,
) -> InputOutputEquation:
    """Add an equation that contains the force to one that does not, if both are linear in the physical parameters.

    X = 0 also solves 0 = D X: with noise in D, least squares would shrink the parameters towards it. The sum and the
    other equation together are equivalent. The equation with the force that gives fewest terms is added, of those that
    share a parameter with it and so determine its scale. Both are differentiated alike first, and multiplied such that
    a term cancels where they have one in common: the force of a spring after a gear, whose noise would outweigh the
    sum. Where they have none, a balance of forces is multiplied by a ratio of the axis before it is added to one of
    torques, and vice versa: terms of other units would be of other sizes.
    """
    if equation.force or not equation.is_linear:
        return equation
    axis, operators = signals.axis, signals.operators
    turns = {body.name: body.turns for body in axis.free_bodies}
    metres_per_radian = operators.element(Kinematics(axis).metres_per_radian(axis))

    def of_torques(balances: Mapping[str, PolyElement]) -> bool:
        return turns[next(iter(balances))]

    def of_balances(written: InputOutputEquation) -> bool:
        return written.multipliers.keys() <= turns.keys()

    sums: list[InputOutputEquation] = []
    for other, its_row in pairs:
        if not (other.force and other.is_linear and equation.parameters & other.parameters):
            continue
        if of_balances(other) and of_balances(equation):
            power = int(of_torques(other.multipliers)) - int(of_torques(equation.multipliers))
            more = max(0, row.degree - its_row.degree)
            alike = signals.equation(its_row.scaled(operators.ring.gens[0] ** more)) if more else other
            factors = equation.cancelling(alike) or [metres_per_radian**power]
            sums.extend(equation.scaled(factor).plus(alike) for factor in factors)
    return min(
        sums,
        key=lambda e: (max(order for order, _ in e.force), sum(len(t.coefficient) for t in e.motion)),
        default=equation,
    )
