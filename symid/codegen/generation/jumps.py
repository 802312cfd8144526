"""Jumps of friction in a minimal model: the velocities at which they occur, and friction that acts like a drive."""

from collections.abc import Collection
from itertools import product
from typing import NamedTuple

import sympy as sp

from symid.symbolic import DerivedModel, MinimalModel, is_smooth


def jump_velocities(
    minimal: MinimalModel, constants: Collection[sp.Symbol]
) -> tuple[tuple[tuple[int, ...], ...], tuple[sp.Expr, ...]]:
    """For each equation the indices of the velocities in its laws with jumps, and these velocities.

    They include jumps whose derivative an equation omits: it does not hold there, though no column shows the jump.
    """
    velocities: dict[sp.Expr, int] = {}
    by_equation = []
    for row, y, equation in zip(minimal.regressor, minimal.output, minimal.source.equations, strict=True):
        shown = {f for entry in (*row, y) for f in entry.atoms(sp.Function) if not is_smooth(f)}
        jumps = sorted(
            shown.union(*(f.atoms(sp.Function) for f in equation.dropped)), key=sp.default_sort_key
        )
        arguments = [-f.args[0] if f.args[0].could_extract_minus_sign() else f.args[0] for f in jumps]
        # Jumps that do not occur at standstill, such as that of a stiffness at the edge of a gap, are left out.
        arguments = [
            a for a in arguments if not a.xreplace(dict.fromkeys(a.free_symbols.difference(constants), 0))
        ]
        by_equation.append(tuple(sorted({velocities.setdefault(a, len(velocities)) for a in arguments})))
    return tuple(by_equation), tuple(velocities)


class CoulombAtDrive(NamedTuple):
    """Friction that acts like a drive: row of its velocity, index of its minimal parameter, signal of the drive."""

    row: int
    parameter: int
    drive: str


def coulomb_at_drive(model: DerivedModel, velocities: tuple[sp.Expr, ...]) -> list[CoulombAtDrive]:
    """Coulomb friction that acts on the bodies like a drive, if an equation omits its derivatives.

    The drive force minus this friction is smooth where the velocity changes its sign, and can be differentiated.
    """
    if not any(equation.dropped for equation in model.minimal.source.equations):
        return []
    operators = model.minimal.source.operators
    zero = operators.ring.zero
    # A force that is a regressor column must not be changed: no law would restore the friction there.
    columns = {symbol for row in model.minimal.regressor for e in row for symbol in e.free_symbols}
    outputs = [drive.signal for drive in model.axis.drives if sp.Symbol(drive.signal) not in columns]
    found: list[CoulombAtDrive] = []
    for entry in operators.source.inputs:
        if entry.expression != sp.sign(sp.Symbol("v")):
            continue
        for generator, signal in product(operators.ring.gens[1:], outputs):
            # The friction acts like the drive if its coefficient is minus this parameter times the drive's, everywhere.
            if not any(
                row.get(str(entry.symbol), zero) + generator * operators.force[body].get(signal, zero)
                for body, row in operators.inputs.items()
            ):
                places = _places_of_coulomb(model.minimal, velocities, str(generator))
                found += [CoulombAtDrive(*place, signal) for place in places[:1]]
                break
    return found


def _places_of_coulomb(
    model: MinimalModel, velocities: tuple[sp.Expr, ...], parameter: str
) -> list[tuple[int, int]]:
    """Index of the velocity, and of the minimal parameter that equals a physical one and has the column sign(v)."""
    for j, minimal in enumerate(model.parameters):
        if minimal.function.names == {parameter} and str(minimal.function) == parameter:
            columns = {row[j] for row in model.regressor} - {0}
            return [(i, j) for i, velocity in enumerate(velocities) if columns == {sp.sign(velocity)}]
    return []
