"""Forward dynamics of an axis as numbers and NumPy code, for simulation without sympy."""

from collections.abc import Sequence
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Axis, Sensor
from symid.codegen.lowering import code
from symid.symbolic.forward_terms import Functional, forward_terms
from symid.symbolic.lagrange import Kinematics
from symid.symbolic.operators import by_power


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

    def numbers(matrix: Sequence[Sequence[PolyElement]]) -> list[list[list[list[Any]]]]:
        return [[[[number(c), list(map(int, m[1:]))] for m, c in p.terms()] for p in row] for row in matrix]

    def row(functional: Functional) -> list[float]:
        return [number(functional[b]) if b in functional else 0.0 for b in bodies]

    def sensor(one: Sensor) -> dict[str, Any]:
        """Displacement of its joint and which derivative of that is read, and all terms if there are parameters."""
        reading = terms.readings[one.signal]
        joint = terms.operators.functional(Kinematics(axis).displacement(one.joint))
        plain = {"row": row(joint), "order": one.derivative}
        if one.derivative is not None and not one.is_scaled:
            return plain
        motion = [[by_power(reading.motion.get(b)).get(k, ring.zero) for b in bodies] for k in range(3)]
        drives = [reading.drives.get(drive.signal, ring.zero) for drive in axis.drives]
        scale = [reading.gain, reading.offset]
        return {
            **plain,
            **({"law": True} if reading.laws else {}),
            "motion": numbers(motion),
            "drives": numbers([drives])[0],
            "scale": numbers([scale])[0],
        }

    # Only polynomials with numbers and NumPy code of laws: a simulation reads this without sympy.
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
        "sensors": {s.signal: sensor(s) for s in axis.sensors},
    }
