"""Forward dynamics of an axis as numbers and NumPy code, which a simulation reads without sympy."""

from __future__ import annotations

from typing import Any

import sympy as sp

from symid.axis import Axis
from symid.codegen.dynamics_store import dynamics_text
from symid.codegen.lowering import code
from symid.symbolic.forward_terms import Functional, Matrix, forward_terms


def dynamics_record(axis: Axis) -> dict[str, Any]:
    """Terms of M x(2) + C x(1) + K x = B F + c - laws; a polynomial is a list of coefficients and exponents.

    >>> from symid.axis import load_axis
    >>> record = dynamics_record(load_axis("rigid_1m"))
    >>> record["mass"], record["laws"][0]["code"]
    ([[[[1.0, [1, 0, 0]]]]], 'np.sign(v)')
    """
    terms = forward_terms(axis)
    ring, bodies = terms.operators.ring, terms.bodies
    constants = {sp.Symbol(name): value for name, value in terms.constants.items()}

    def number(element: Any) -> float:
        return float(ring.domain.to_sympy(ring.domain.convert(element)).xreplace(constants))

    def numbers(matrix: Matrix) -> list[list[list[list[Any]]]]:
        return [[[[number(c), list(map(int, m[1:]))] for m, c in p.terms()] for p in row] for row in matrix]

    def row(functional: Functional) -> list[float]:
        return [number(functional[b]) if b in functional else 0.0 for b in bodies]

    return {
        "generators": list(map(str, ring.symbols[1:])),
        "bodies": [body for body, entries in zip(bodies, terms.mass, strict=True) if any(entries)],
        "stiffness": numbers(terms.stiffness),
        "damping": numbers(terms.damping),
        "mass": numbers(terms.mass),
        "drives": numbers(terms.drives),
        "constant": numbers(terms.constant),
        "laws": [
            {
                "direction": row(law.displacement),
                "parameter": numbers(((law.parameter,),))[0][0],
                "code": code(law.expression),
            }
            for law in terms.laws
        ],
        "sensors": {
            s.signal: {"row": row(terms.readings[s.signal]), "order": s.derivative} for s in axis.sensors
        },
    }


def generated_dynamics(axis: Axis) -> str:
    """Text of the file that holds the forward dynamics of an axis."""
    return dynamics_text(axis, dynamics_record(axis))
