"""Residuals of the equations of a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray


@dataclass(frozen=True)
class EquationResidual:
    """Residual of one equation."""

    output: str
    """Left-hand side of the equation."""
    rows: int
    """Rows compared."""
    norm: float
    """||y - W X||, in the unit of the output."""
    deviation: float
    """Estimated standard deviation sigma_rho of the equation [25]."""
    relative: float
    """||y - W X|| / ||y||; nan for an output that is always 0."""

    @classmethod
    def of(cls, output: str, rows: int, norm: float, y_norm: float, deviation: float) -> EquationResidual:
        """Record from the norms of residual and output."""
        return cls(output, rows, norm, deviation, norm / y_norm if y_norm > 0 else float("nan"))

    @classmethod
    def of_rows(cls, output: str, errors: FloatArray, y: FloatArray) -> EquationResidual:
        """Record from the errors themselves."""
        deviation = float(np.std(errors, ddof=1)) if errors.size > 1 else float("nan")
        return cls.of(output, errors.size, float(np.linalg.norm(errors)), float(np.linalg.norm(y)), deviation)

    @property
    def rms(self) -> float:
        """Root mean square of the error, in the unit of the output."""
        return float(self.norm / np.sqrt(self.rows)) if self.rows else float("nan")
