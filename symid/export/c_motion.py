"""C statements for the motion of an axis: the derivative of its state, and the readings of its sensors."""

import textwrap
from collections.abc import Callable, Iterable

import sympy as sp

from symid.axis import Axis
from symid.errors import SettingError
from symid.export.c_code import assignments, c_code, c_name
from symid.export.dynamics import DISPLACEMENT, VELOCITY, SymbolicDynamics
from symid.export.imperfect_terms import NOW, Memory, acting, added, sent
from symid.symbolic import READING, misread


def derivative(dynamics: SymbolicDynamics) -> str:
    """Statements for dx/dt: the forces of the laws in each joint, then the accelerations M^-1 (sum of all forces)."""
    n, axis = len(dynamics.bodies), dynamics.axis
    x, v = state_symbols(n)

    def lagging(_: str, memory: Memory) -> tuple[list[str], str]:
        return [f"d{memory.symbol} = {c_code(memory.rate)};"], str(memory.symbol)

    statements = [*clock(dynamics, "0.0"), *acting_force(dynamics, lagging)]
    force = smooth_force(dynamics)
    taken = {*axis.physical_parameters, *dynamics.constants, *(drive.signal for drive in axis.drives)}
    rates = []
    for joint in dynamics.laws:
        symbol, q, velocity = (sp.Symbol(f"{letter}_{joint.name}_") for letter in "fqv")
        names = {DISPLACEMENT: q, VELOCITY: velocity}
        remembered = {memory.symbol: memory.rate.xreplace(names) for memory in joint.memories}
        rates += [f"d{place} = {c_code(rate)};" for place, rate in remembered.items()]
        law = joint.force.xreplace(names)
        needed = {symbol}.union(law.free_symbols, *(rate.free_symbols for rate in remembered.values()))
        values = {q: (joint.direction @ x)[0], velocity: (joint.direction @ v)[0], symbol: law}
        statements += [
            f"const double {name} = {c_code(renamed(value))};"
            for name, value in values.items()
            if name in needed
        ]
        taken.add(str(symbol))
        force -= joint.direction.T * symbol
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
    if dynamics.imperfect.clock:
        statements.append(f"d{dynamics.imperfect.clock} = 1.0;")
    matrices = (dynamics.mass, dynamics.damping, dynamics.stiffness, dynamics.drives, dynamics.constant)
    laws = [sp.Matrix([joint.force]) for joint in dynamics.laws]
    return lines([*members(used_parameters(dynamics, *matrices, *laws)), *statements])


def state_symbols(n: int) -> tuple[sp.Matrix, sp.Matrix]:
    """Displacements and velocities of n bodies as entries of the state in C."""
    x, v = ([sp.Symbol(f"x[{first + i}]") for i in range(n)] for first in (0, n))
    return sp.Matrix(x), sp.Matrix(v)


def smooth_force(dynamics: SymbolicDynamics) -> sp.Matrix:
    """B F + c - C v - K x with the acting forces F."""
    x, v = state_symbols(len(dynamics.bodies))
    otherwise = acts_otherwise(dynamics)
    forces = sp.Matrix([acting(d) if otherwise else sp.Symbol(d.signal) for d in dynamics.axis.drives])
    return dynamics.drives * forces + dynamics.constant - dynamics.damping * v - dynamics.stiffness * x


def sent_forces(axis: Axis) -> str:
    """The drive forces as arguments of a C function."""
    return ", ".join(c_name(drive.signal) for drive in axis.drives)


def force_parameters(axis: Axis) -> str:
    """The drive forces as parameters of a C function."""
    return ", ".join(f"double {c_name(drive.signal)}" for drive in axis.drives)


def acts_otherwise(dynamics: SymbolicDynamics) -> bool:
    """Whether an acting force differs from the commanded one, or friction depends on it."""
    symbols = set().union(*(joint.law.free_symbols for joint in dynamics.imperfect.joints))
    return any(path.elements or acting(path.drive) in symbols for path in dynamics.imperfect.drives)


def clock(dynamics: SymbolicDynamics, ahead: str) -> list[str]:
    """Statements for the time of forces and masses, `ahead` of the state's, and for the added masses at that time."""
    imperfect = dynamics.imperfect
    if not imperfect.clock:
        return []
    now = f"const double {NOW} = {imperfect.clock} + {ahead};"
    grown: dict[sp.Symbol, list[str]] = {}
    for change in imperfect.changes:
        term = f"({NOW} >= {float(change.time)!r} ? {float(change.change)!r} : 0.0)"
        grown.setdefault(added(change), []).append(term)
    return [now, f"(void){NOW};", *(f"const double {name} = {' + '.join(t)};" for name, t in grown.items())]


def acting_force(
    dynamics: SymbolicDynamics, lag: Callable[[str, Memory], tuple[list[str], str]]
) -> list[str]:
    """Statements for the acting forces; `lag` gives those of a lag, and its value, from its place and state."""
    if not acts_otherwise(dynamics):
        return []
    statements = list[str]()
    for path in dynamics.imperfect.drives:
        force = acting(path.drive)
        statements.append(f"double {force} = {c_name(path.drive.signal)};")
        for i, (element, memory) in enumerate(path.elements):
            before, value = (
                ([], c_code(sent(element, path.drive))) if memory is None else lag(f"{force}{i}", memory)
            )
            first, *others = [*before, f"{force} = {value};"]
            statements += [f"{first}  /* {type(element).__name__} */", *others]
    return statements


def settled_lags(dynamics: SymbolicDynamics) -> str:
    """Statements that settle the lags of drives at constant forces; empty without lags."""

    def follows(_: str, memory: Memory) -> tuple[list[str], str]:
        return [f"{memory.symbol} = {c_code(memory.gain / memory.decay)};"], str(memory.symbol)

    lags = any(memory for path in dynamics.imperfect.drives for _, memory in path.elements)
    return lines(["(void)p;", *acting_force(dynamics, follows)]) if lags else ""


def readings(dynamics: SymbolicDynamics) -> str:
    """Readings of the sensors from a state and its derivative, with ripple and resolution."""
    n, statements = len(dynamics.bodies), []
    steps = {sensor.signal: sensor.resolution for sensor in dynamics.axis.sensors}
    parameters = dynamics.axis.physical_parameters
    given = {sp.Symbol(n): sp.Symbol(f"{dynamics.axis.name}_values.{c_name(n)}") for n in parameters}
    places = [
        sp.Symbol(f"{array}[{k}]")
        for array, first in (("x", 0), ("x", n), ("dx", n))
        for k in range(first, first + n)
    ]
    for i, (signal, reading) in enumerate(dynamics.sensors.items()):
        if any(reading.drives):
            raise SettingError(
                f"{signal} reads the force of a drive, which this export is given: leave that sensor out of the axis"
            )
        factors = [factor.xreplace(given) for factor in reading.motion]
        value = sp.Add(*map(sp.Mul, factors, places), sp.sympify(reading.constant).xreplace(given))
        for joint in dynamics.laws if reading.per_force else ():
            if joint.direction == sp.ImmutableMatrix(reading.row):
                q, v = (sp.Add(*map(sp.Mul, joint.direction, places[k : k + n])) for k in (0, n))
                of_law = joint.force.xreplace(given).xreplace({DISPLACEMENT: q, VELOCITY: v})
                value += reading.per_force.xreplace(given) * of_law
        statements.append(f"y[{i}] = {c_code(value)};  /* {signal} */")
        if (law := misread(dynamics.axis, signal)) is not None:
            statements.append(f"y[{i}] = {c_code(law.xreplace({READING: sp.Symbol(f'y[{i}]')}))};")
        if steps[signal]:
            statements.append(quantised(f"y[{i}]", steps[signal]))
    orders = {k for reading in dynamics.sensors.values() for k in range(3) if any(reading.motion.row(k))}
    unused = [*([] if orders & {0, 1} else ["(void)x;"]), *([] if 2 in orders else ["(void)dx;"])]
    return lines([*unused, *statements])


def quantised(name: str, step: float) -> str:
    """Statement that rounds a variable to a resolution."""
    return f"{name} = {float(step)!r}*nearbyint({name}/{float(step)!r});"


def used_parameters(dynamics: SymbolicDynamics, *matrices: sp.Matrix) -> list[str]:
    """Parameters that occur in matrices, in the order of the declaration."""
    symbols = set().union(*(matrix.free_symbols for matrix in matrices))
    return [name for name in dynamics.axis.physical_parameters if sp.Symbol(name) in symbols]


def members(names: Iterable[str]) -> list[str]:
    """Statements that read parameters."""
    return [f"const double {c_name(name)} = p->{c_name(name)};" for name in names]


def renamed(expression: sp.Expr) -> sp.Expr:
    """An expression with names that are free in C."""
    return expression.xreplace({s: sp.Symbol(c_name(str(s))) for s in expression.free_symbols})


def lines(statements: Iterable[str]) -> str:
    """Statements as indented lines."""
    return textwrap.indent("\n".join(statements), "    ")
