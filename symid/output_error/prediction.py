"""One-step predictions of the readings of a log with identified parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.identification import EquationResidual
from symid.output_error.prediction_error import PredictionError
from symid.output_error.search import Search


@dataclass(frozen=True, eq=False)
class OutputErrorPrediction:
    """Readings of a log and what of them could not be predicted from earlier ones.

    Parameters
    ----------
    log : str
        Source of the log.
    time : array of shape (n_samples,)
        Times of the log, s.
    readings, innovations : array of shape (n_samples, n_outputs)
        SI; nan where the axis rests.
    signals : tuple of str
        Names of the outputs.
    """

    log: str
    time: FloatArray
    readings: FloatArray
    innovations: FloatArray
    signals: tuple[str, ...]

    @property
    def residuals(self) -> tuple[EquationResidual, ...]:
        """How well each reading is predicted, relative to its own deviation."""
        found = []
        for signal, readings, innovations in zip(
            self.signals, self.readings.T, self.innovations.T, strict=True
        ):
            used = np.isfinite(innovations)
            found.append(
                EquationResidual.of_rows(signal, innovations[used], readings[used] - np.mean(readings[used]))
            )
        return tuple(found)


def prediction_of(
    log: Log, error: PredictionError, search: Search, nuisance: FloatArray
) -> OutputErrorPrediction:
    """Predictions of a log with the parameters of a search."""
    innovations = np.full((log.n_samples, len(error.run.signals)), np.nan)
    innovations[error.run.kept] = error.innovations(search.parameters, nuisance)
    readings = np.where(
        np.isfinite(innovations), np.stack([log[s] for s in error.run.signals], axis=1), np.nan
    )
    return OutputErrorPrediction(log.source, log.time, readings, innovations, error.run.signals)
