"""The effect of one more column on the residual of an estimate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray, unexplained_by

_INDEPENDENT = 1e-8
"""Least share of a column's power that is linearly independent of the model's columns."""


@dataclass(frozen=True)
class AddedColumn:
    """The effect of one more column on the residual.

    Share of the residual's power that it takes away; rms that the other columns do not explain, as part of the output
    and with the sign of the factor; factor that multiplies it.
    """

    share: float = 0.0
    size: float = 0.0
    factor: float = 0.0

    @classmethod
    def of(cls, Z: FloatArray, r: FloatArray, column: FloatArray, y: FloatArray) -> AddedColumn:
        """Effect of `column` on residual r, beside the columns Z of the model; y is the output.

        It does not depend on the scale of the column.

        >>> r = np.array([1.0, -1.0, 2.0, -2.0])
        >>> [round(AddedColumn.of(np.ones((4, 1)), r, scale * r**3, r).share, 3) for scale in (1.0, 1e-170)]
        [0.889, 0.889]
        """
        power, largest = float(r @ r), float(np.max(np.abs(column), initial=0.0))
        if not power > 0.0 or not largest > np.finfo(float).tiny:
            return cls()
        # Only the component orthogonal to the model's columns can reduce the residual (Frisch-Waugh-Lovell theorem).
        unit = column / largest  # of a filter's tail alone, its squares would underflow
        own = unexplained_by(Z, unit)
        rest = float(own @ own)
        if rest < _INDEPENDENT * float(unit @ unit):
            return cls()
        taken = float(own @ r) / math.sqrt(rest)
        size = taken / math.sqrt(max(float(y @ y), np.finfo(float).tiny))
        return cls(taken**2 / power, size, taken / math.sqrt(rest) / largest)
