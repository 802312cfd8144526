"""Forward dynamics of an axis as numbers and NumPy code, for simulation without sympy."""

from collections.abc import Sequence
from typing import Any

import sympy as sp
from sympy.polys.rings import PolyElement

from symid.axis import Axis, Sensor
from symid.codegen.generation.lowering import numpy_code
from symid.symbolic import ForwardTerms, Functional, Kinematics, by_power, forward_terms


def dynamics_record(axis: Axis) -> dict[str, Any]:
    """Terms of M x(2) + C x(1) + K x = B F + c - laws; a polynomial is a list of coefficients and exponents.

    >>> from symid.axis import load_axis
    >>> record = dynamics_record(load_axis("rigid_1m"))
    >>> record["mass"], record["laws"][0]["code"]
    ([[[[1.0, [1, 0, 0]]]]], 'np.sign(v)')
    """
    terms = forward_terms(axis)
    written = _TermsAsNumbers(terms)
    # Only polynomials with numbers and NumPy code of laws: a simulation reads this without sympy.
    return {
        "generators": list(map(str, terms.operators.ring.symbols[1:])),
        "bodies": [body for body, entries in zip(terms.bodies, terms.mass, strict=True) if any(entries)],
        "stiffness": written.matrix(terms.stiffness),
        "damping": written.matrix(terms.damping),
        "mass": written.matrix(terms.mass),
        "drives": written.matrix(terms.drives),
        "constant": written.matrix(terms.constant),
        "laws": [
            {
                "direction": written.row(law.displacement),
                "parameter": written.polynomial(law.parameter),
                "code": numpy_code(law.expression),
            }
            for law in terms.laws
        ],
        "sensors": {sensor.signal: written.sensor(axis, sensor) for sensor in axis.sensors},
    }


class _TermsAsNumbers:
    """Terms of an axis as numbers."""

    def __init__(self, terms: ForwardTerms) -> None:
        self._terms, self._domain = terms, terms.operators.ring.domain
        self._constants = {sp.Symbol(name): value for name, value in terms.constants.items()}

    def number(self, element: Any) -> float:
        return float(self._domain.to_sympy(self._domain.convert(element)).xreplace(self._constants))

    def polynomial(self, polynomial: PolyElement) -> list[list[Any]]:
        return [[self.number(c), list(map(int, m[1:]))] for m, c in polynomial.terms()]

    def matrix(self, matrix: Sequence[Sequence[PolyElement]]) -> list[list[list[list[Any]]]]:
        return [list(map(self.polynomial, row)) for row in matrix]

    def row(self, functional: Functional) -> list[float]:
        bodies = self._terms.bodies
        return [self.number(functional[b]) if b in functional else 0.0 for b in bodies]

    def sensor(self, axis: Axis, sensor: Sensor) -> dict[str, Any]:
        """Displacement of its joint and which derivative of that is read, and all terms if there are parameters."""
        reading, operators = self._terms.readings[sensor.signal], self._terms.operators
        joint = operators.functional(Kinematics(axis).displacement(sensor.joint))
        plain = {"row": self.row(joint), "order": sensor.derivative}
        if sensor.derivative is not None and not sensor.is_scaled:
            return plain
        zero, bodies = operators.ring.zero, self._terms.bodies
        motion = [[by_power(reading.motion.get(b)).get(k, zero) for b in bodies] for k in range(3)]
        return {
            **plain,
            **({"law": True} if reading.laws else {}),
            "motion": self.matrix(motion),
            "drives": [self.polynomial(reading.drives.get(drive.signal, zero)) for drive in axis.drives],
            "scale": [self.polynomial(reading.gain), self.polynomial(reading.offset)],
        }
