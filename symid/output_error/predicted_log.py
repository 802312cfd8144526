"""Prediction of a log by identified parameters."""

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.identification import EquationResidual


@dataclass(frozen=True, eq=False)
class OutputErrorPrediction:
    """Readings of a log and their prediction errors, from earlier readings or from the simulated closed loop."""

    log: str
    """Source of the log."""
    time: FloatArray
    """Times of the log, s; shape (n_samples,)."""
    readings: FloatArray
    """SI; shape (n_samples, n_outputs)."""
    innovations: FloatArray
    """SI; nan where the axis rests; shape (n_samples, n_outputs)."""
    signals: tuple[str, ...]
    """Names of the outputs."""

    @property
    def residuals(self) -> tuple[EquationResidual, ...]:
        """Residual of each reading, relative to its standard deviation."""
        residuals = []
        for signal, readings, innovations in zip(
            self.signals, self.readings.T, self.innovations.T, strict=True
        ):
            used = np.isfinite(innovations)
            residuals.append(
                EquationResidual.of_rows(signal, innovations[used], readings[used] - np.mean(readings[used]))
            )
        return tuple(residuals)
