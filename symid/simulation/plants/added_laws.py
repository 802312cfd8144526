"""Forward dynamics of an axis with added laws, from stored dynamics: this avoids loading sympy, which takes 0.5 s."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from symid.axis import Axis, Imperfection, Law
from symid.codegen import stored_dynamics
from symid.errors import DeclarationError
from symid.simulation.plants.law_code import array_function, law_code, moves
from symid.simulation.plants.plant import direction_of


def stored_with_laws(axis: Axis) -> dict[str, Any] | None:
    """Record of forward dynamics (see `dynamics_record`) of an axis that is stored without its last laws.

    None if the axis is not stored without the laws and imperfections at the end of its declaration either.
    """
    laws = list[Law]()
    for base, law in _without_last(axis):
        if law is not None:
            laws.insert(0, law)
        if (record := stored_dynamics(base)) is not None:
            if laws and any("motion" in sensor for sensor in record["sensors"].values()):
                return None  # the reading of a force sensor may depend on the laws
            return _extended(record, laws, [body.name for body in axis.free_bodies])
    return None


def _without_last(axis: Axis) -> Iterator[tuple[Axis, Law | None]]:
    """The axis with ever fewer laws and imperfections at its end, each with the law that was removed last."""
    yield axis, None
    for n in range(len(axis.elements) - 1, 0, -1):
        last = axis.elements[n]
        if not isinstance(last, Law | Imperfection):
            return
        try:
            base = replace(axis, elements=axis.elements[:n])
        except DeclarationError:  # for example nothing left to identify
            return
        yield base, last if isinstance(last, Law) else None


def _extended(record: dict[str, Any], laws: list[Law], bodies: list[str]) -> dict[str, Any]:
    """The record with the terms of laws: linear ones in stiffness or damping, constants as forces, others as laws."""
    terms = [(direction_of(law.at, bodies), term) for law in laws for term in law.terms()]
    generators = list(dict.fromkeys([*record["generators"], *(term.parameter for _, term in terms)]))
    matrices = ("stiffness", "damping", "mass", "drives", "constant")
    found = {name: [[_padded(p, len(generators)) for p in row] for row in record[name]] for name in matrices}
    found_laws = [{**law, "parameter": _padded(law["parameter"], len(generators))} for law in record["laws"]]
    for direction, term in terms:
        powers = [int(name == term.parameter) for name in generators]
        if term.is_linear:
            matrix = found["stiffness" if term.expression == "q" else "damping"]
            for i, k in np.argwhere(np.outer(direction, direction)):
                matrix[i][k].append([float(direction[i] * direction[k]), powers])
        elif not moves(term.expression):
            value = float(array_function(law_code(term.expression))(0.0, 0.0))
            for i in np.flatnonzero(direction):
                found["constant"][i][0].append([-float(direction[i]) * value, powers])
        else:
            found_laws.append(
                {
                    "direction": direction.tolist(),
                    "parameter": [[1.0, powers]],
                    "code": law_code(term.expression),
                }
            )
    return {**record, "generators": generators, **found, "laws": found_laws}


def _padded(polynomial: list[Any], n: int) -> list[Any]:
    """The polynomial in `n` parameters; the exponents of further ones are 0."""
    return [[coefficient, [*powers, *[0] * (n - len(powers))]] for coefficient, powers in polynomial]
