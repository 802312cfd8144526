"""C statements of an axis' motion: the derivative of its state, and what its sensors read."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Sequence

import sympy as sp

from symid.axis import Axis
from symid.export.c_code import assignments, c_code, c_name
from symid.export.dynamics import DISPLACEMENT, VELOCITY, LawJoint, SymbolicDynamics
from symid.export.imperfect_terms import ACTING, NOW, Memory, added, sent
from symid.symbolic.expressions import READING, misread


def derivative(dynamics: SymbolicDynamics) -> str:
    """Velocities, forces of the laws in each joint, then the accelerations that balance them."""
    n, axis = len(dynamics.bodies), dynamics.axis
    x = [sp.Symbol(f"x[{i}]") for i in range(n)]
    v = [sp.Symbol(f"x[{n + i}]") for i in range(n)]
    statements = [*clock(dynamics, "0.0"), *acting_force(dynamics, _lagging)]
    force = smooth_force(dynamics, x, v)
    taken = {*axis.physical_parameters, *dynamics.constants, *(drive.signal for drive in axis.drives)}
    rates = []
    for joint in dynamics.laws:
        symbol, written, effect, remembered = _joint(joint, dynamics, x, v)
        statements += written
        rates += remembered
        taken.add(str(symbol))
        force -= effect * symbol
    balance = sp.Matrix([sp.Symbol(f"r{i}_") for i in range(n)])
    motion = [renamed(f) for f in force]
    statements += [
        f"const double r{i}_ = {c_code(f)};  /* {body} */"
        for i, (body, f) in enumerate(zip(dynamics.bodies, motion, strict=True))
    ]
    accelerations = [renamed(a) for a in dynamics.mass.LUsolve(balance)]
    statements += [f"dx[{i}] = x[{n + i}];" for i in range(n)]
    statements += assignments([f"dx[{n + i}]" for i in range(n)], accelerations, {*map(c_name, taken)})
    statements += rates
    if dynamics.imperfect.is_timed:
        statements.append(f"d{dynamics.imperfect.clock} = 1.0;")
    matrices = (dynamics.mass, dynamics.damping, dynamics.stiffness, dynamics.drives, dynamics.constant)
    laws = [sp.Matrix([joint.force]) for joint in dynamics.laws]
    return lines([*members(used_parameters(dynamics, *matrices, *laws)), *statements])


def smooth_force(
    dynamics: SymbolicDynamics, x: Sequence[sp.Symbol], v: Sequence[sp.Symbol]
) -> sp.ImmutableMatrix:
    """B F + c - C v - K x, F being the forces that act."""
    sent_forces = [sp.Symbol(drive.signal) for drive in dynamics.axis.drives]
    acting = sp.Matrix([ACTING] if acts_otherwise(dynamics) else sent_forces)
    return (
        dynamics.drives * acting
        + dynamics.constant
        - dynamics.damping * sp.Matrix(v)
        - dynamics.stiffness * sp.Matrix(x)
    )


def force_parameters(axis: Axis) -> str:
    """The drive forces as parameters of a C function."""
    return ", ".join(f"double {c_name(drive.signal)}" for drive in axis.drives)


def acts_otherwise(dynamics: SymbolicDynamics) -> bool:
    """Whether the force that acts differs from the force that is sent."""
    imperfect = dynamics.imperfect
    return bool(imperfect.drive) or any(ACTING in law.free_symbols for law in imperfect.laws)


def clock(dynamics: SymbolicDynamics, ahead: str) -> list[str]:
    """The time for which forces and masses are taken, and by how much masses have grown."""
    imperfect = dynamics.imperfect
    if not imperfect.is_timed:
        return []
    now = f"const double {NOW} = {imperfect.clock} + {ahead};"
    grown: dict[sp.Symbol, list[str]] = {}
    for change in imperfect.changes:
        term = f"({NOW} >= {float(change.time)!r} ? {float(change.change)!r} : 0.0)"
        grown.setdefault(added(change), []).append(term)
    return [now, f"(void){NOW};", *(f"const double {name} = {' + '.join(t)};" for name, t in grown.items())]


def acting_force(
    dynamics: SymbolicDynamics, lag: Callable[[int, Memory], tuple[list[str], str]]
) -> list[str]:
    """Statements for the force that acts; `lag` gives those of a force that lags, by its place, and its value."""
    if not acts_otherwise(dynamics):
        return []
    found = [f"double {ACTING} = {c_name(dynamics.axis.only_drive.signal)};"]
    for i, (element, memory) in enumerate(dynamics.imperfect.of_drive):
        before, value = ([], c_code(sent(element))) if memory is None else lag(i, memory)
        first, *others = [*before, f"{ACTING} = {value};"]
        found += [f"{first}  /* {type(element).__name__} */", *others]
    return found


def _lagging(_: int, memory: Memory) -> tuple[list[str], str]:
    return [f"d{memory.symbol} = {c_code(memory.rate)};"], str(memory.symbol)


def _joint(
    joint: LawJoint, dynamics: SymbolicDynamics, x: Sequence[sp.Symbol], v: Sequence[sp.Symbol]
) -> tuple[sp.Symbol, list[str], sp.Matrix, list[str]]:
    """Symbol of a joint's force, what computes it, its effect on each body, and the rates of its memories."""
    symbol = sp.Symbol(f"f_{joint.name}_")
    q, velocity = (sp.Symbol(f"{letter}_{joint.name}_") for letter in "qv")
    names = {DISPLACEMENT: q, VELOCITY: velocity}
    law = joint.force.xreplace(names)
    rates = {memory.symbol: memory.rate.xreplace(names) for memory in joint.memories}
    statements = {
        q: sp.Add(*map(sp.Mul, joint.direction, x)),
        velocity: sp.Add(*map(sp.Mul, joint.direction, v)),
        symbol: law,
    }
    needed = {symbol}.union(law.free_symbols, *(rate.free_symbols for rate in rates.values()))
    written = [
        f"const double {name} = {c_code(renamed(value))};"
        for name, value in statements.items()
        if name in needed
    ]
    remembered = [f"d{place} = {c_code(rate)};" for place, rate in rates.items()]
    return symbol, written, joint.direction.T, remembered


def readings(dynamics: SymbolicDynamics) -> str:
    """Readings of the sensors from a state and its derivative, with ripple and resolution."""
    n, found = len(dynamics.bodies), []
    steps = {sensor.signal: sensor.resolution for sensor in dynamics.axis.sensors}
    parameters = dynamics.axis.physical_parameters
    for i, (signal, (row, order)) in enumerate(dynamics.sensors.items()):
        array, first = ("x", "x", "dx")[order], (0, n, n)[order]
        given = {sp.Symbol(n): sp.Symbol(f"{dynamics.axis.name}_values.{c_name(n)}") for n in parameters}
        reading = sp.Add(*(f.xreplace(given) * sp.Symbol(f"{array}[{first + k}]") for k, f in enumerate(row)))
        found.append(f"y[{i}] = {c_code(reading)};  /* {signal} */")
        if (law := misread(dynamics.axis, signal)) is not None:
            found.append(f"y[{i}] = {c_code(law.xreplace({READING: sp.Symbol(f'y[{i}]')}))};")
        if steps[signal]:
            found.append(in_steps(f"y[{i}]", steps[signal]))
    orders = {order for _, order in dynamics.sensors.values()}
    unused = [*([] if orders & {0, 1} else ["(void)x;"]), *([] if 2 in orders else ["(void)dx;"])]
    return lines([*unused, *found])


def in_steps(name: str, step: float) -> str:
    """Statement that rounds a number to a resolution."""
    return f"{name} = {float(step)!r}*nearbyint({name}/{float(step)!r});"


def used_parameters(dynamics: SymbolicDynamics, *matrices: sp.Matrix) -> list[str]:
    """Parameters in some matrices, in the order of the declaration."""
    symbols = set().union(*(matrix.free_symbols for matrix in matrices))
    return [name for name in dynamics.axis.physical_parameters if sp.Symbol(name) in symbols]


def members(names: Iterable[str]) -> list[str]:
    """Statements that read parameters."""
    return [f"const double {c_name(name)} = p->{c_name(name)};" for name in names]


def renamed(expression: sp.Expr) -> sp.Expr:
    """An expression with names that C leaves free."""
    return expression.xreplace({s: sp.Symbol(c_name(str(s))) for s in expression.free_symbols})


def lines(statements: Iterable[str]) -> str:
    """Statements as indented lines."""
    return textwrap.indent("\n".join(statements), "    ")
