"""The effect of one more column on the residual of an estimate."""

from __future__ import annotations

from collections.abc import Sequence
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
        return cls.of_each(Z, r, [column], y)[0]

    @classmethod
    def of_each(
        cls, Z: FloatArray, r: FloatArray, columns: Sequence[FloatArray], y: FloatArray
    ) -> list[AddedColumn]:
        """Effect of each of some columns alone, as `of`."""
        if not columns:
            return []
        C, tiny = np.stack(columns, axis=1), np.finfo(float).tiny
        power, size = float(r @ r), np.sqrt(max(float(y @ y), tiny))
        largest = np.max(np.abs(C), axis=0, initial=0.0)
        units = C / np.maximum(largest, tiny)  # of a filter's tail alone, its squares would underflow
        # Only the component orthogonal to the model's columns can reduce the residual (Frisch-Waugh-Lovell theorem).
        outside = unexplained_by(Z, units)
        outside_power, unit_power = np.sum(outside**2, axis=0), np.sum(units**2, axis=0)
        counts = (largest > tiny) & (outside_power >= _INDEPENDENT * unit_power) & (power > 0.0)
        length = np.sqrt(np.where(counts, outside_power, 1.0))
        taken = r @ outside / length
        factors = taken / length / np.maximum(largest, tiny)
        return [
            cls(t**2 / power, t / size, factor) if counted else cls()
            for t, factor, counted in zip(taken.tolist(), factors.tolist(), counts, strict=True)
        ]
