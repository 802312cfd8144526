"""A law without a given shape, against which laws of the library are tested."""

import numpy as np

from symid.arrays import ComplexArray, FloatArray
from symid.diagnosis.effects.effect import JointEffect, Shape, joint_units, sampled
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction

_KNOTS = {"position": 48, "velocity": 24, "acceleration": 24}  # along the range of the quantity
_PIECES = 8  # of a log, in which functions are combined
_RANK = 1e-3  # singular value, relative to the largest, of functions that depend on others


class NonparametricLaw(JointEffect):
    """A piecewise linear function of one quantity, one in either direction; of the position also times the velocity."""

    def __init__(self, of: str) -> None:
        self.name, self.of = f"law_of_{of}", of
        kinds = ("even", "odd", "viscous") if of == "position" else ("even", "odd")
        self.amplitudes = tuple(f"{kind}{k}" for kind in kinds for k in range(_KNOTS[of]))

    def forces(self, prediction: Prediction, joint: RecordedJoint, shape: Shape) -> ComplexArray:
        functions = self._functions(prediction, joint)
        # Inertia and friction of the axis are such functions too. They are taken out, or a large mass and its opposite
        # here would fit with the small difference of how the two are computed.
        of_axis = np.stack([joint.a, joint.v, np.sign(joint.v)])
        # the log stands at the beginning of its period
        inside = slice(np.count_nonzero(prediction.record.in_log))
        shares = functions[:, inside] @ np.linalg.pinv(of_axis[:, inside])
        for i, share in enumerate(shares):
            functions[i] -= share @ of_axis
        combined = _independent(functions, inside)
        return np.concatenate([sampled(prediction, function, joint=joint) for function in combined])

    def _functions(self, prediction: Prediction, joint: RecordedJoint) -> FloatArray:
        if self.of == "position":
            hats, direction = self._hats(prediction, joint.q), np.sign(joint.v)
            return np.concatenate([hats, hats * direction, hats * joint.v])
        signed = joint.v if self.of == "velocity" else joint.a
        hats = self._hats(prediction, np.abs(signed))
        return np.concatenate([hats, hats * np.sign(signed)])

    def _hats(self, prediction: Prediction, x: FloatArray) -> FloatArray:
        """Functions of a quantity on the fine grid that are 1 at a knot and 0 at the others, of shape (n_knots, n)."""
        inside = x[prediction.record.in_log]
        knots = np.linspace(inside.min(), inside.max(), _KNOTS[self.of])
        return np.stack([np.interp(x, knots, unit) for unit in np.eye(knots.size)])

    def units(self, prediction: Prediction, place: str) -> tuple[str, ...]:
        return (str(joint_units(prediction, place)[0]),) * len(self.amplitudes)


def _independent(functions: FloatArray, inside: slice) -> FloatArray:
    """The functions, replaced by combinations that are orthogonal within the log; zero in place of dependent ones."""
    # in pieces (TSQR), as all functions over a long log are large
    pieces = np.array_split(functions[:, inside], _PIECES, axis=1)
    triangles = np.concatenate([np.linalg.qr(piece.T, mode="r") for piece in pieces])
    left, sizes, _ = np.linalg.svd(np.asarray(np.linalg.qr(triangles, mode="r")).T)
    weights = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=sizes > _RANK * sizes[0])
    for piece in np.array_split(functions, _PIECES, axis=1):
        piece[:] = (left * weights).T @ piece
    return functions
