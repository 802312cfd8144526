"""Strength of the effects of a model: the force error that each alone would leave.

Shares of the gap depend on the encoder, whose noise weights frequencies, and on the number of reversals, at which a
late force or friction makes large errors for some milliseconds. The strength does not. It is the rms change of the
predicted force, in a fixed band and away from reversals, if the effect is left out and the parameters are fitted to the
remaining error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import BoolArray, FloatArray, IntArray, unexplained_by
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.gauss_newton import RANK
from symid.diagnosis.fitting.sensitivity import prediction_jacobian
from symid.diagnosis.fitting.state import State, evaluated
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class FixedBand:
    """A model with effects under a record, in a fixed band and away from reversals."""

    state: State  # the model with all effects
    flat: Weighting  # equal weights of all frequencies of the band, in multiples of the noise of each output
    rows: IntArray  # kept rows away from reversals
    columns: FloatArray  # shape (n_parameters, n_outputs, n_rows): derivatives by the parameters
    n_declared: int  # declared imperfections, which stand before the effects found

    @classmethod
    def of(cls, state: State, weighting: Weighting, away: BoolArray, n_declared: int) -> FixedBand:
        """The model under a record with these weights; `away`, shape (n_kept,), are kept rows away from reversals."""
        flat, rows = _flat(weighting), np.flatnonzero(weighting.kept)[away]
        columns = flat.rows(prediction_jacobian(state)[: len(state.prediction.parameters)])[:, :, rows]
        return cls(state, flat, rows, columns, n_declared)

    def strengths(self) -> FloatArray:
        """Strength of each effect found, in multiples of the noise of the force; shape (n_effects,).

        An error of a further reading, which no force shows, counts in multiples of the noise of that reading.
        """
        return np.array([self._strength(at) for at in range(self.n_declared, len(self.state.placed))])

    def removed(self, output: int) -> FloatArray:
        """Share of each effect in the error of an output that all remove, 0 if nothing; shape (n_effects,).

        Each is added, with its value beside all others, to those before it, and the parameters are fitted to the
        remaining error.
        """
        placed, counts = self.state.placed, range(self.n_declared, len(self.state.placed) + 1)
        left = [float(np.mean(self._left(self._errors(placed[:n])[[output]], [output]) ** 2)) for n in counts]
        taken = left[0] - left[-1]
        return np.asarray(-np.diff(left) / taken if taken > 0 else np.zeros(len(left) - 1))

    def _errors(self, placed: tuple[Placed, ...]) -> FloatArray:
        """Errors with some of the effects, all values unchanged; shape (n_outputs, n_rows)."""
        state = evaluated(self.state, self.flat, self.state.prediction.parameters, placed)
        return self.flat.rows(state.errors)[:, self.rows]

    def _left(self, errors: FloatArray, outputs: list[int]) -> FloatArray:
        """Part of the errors of some outputs that the parameters cannot explain; shape (n_outputs, n_rows)."""
        columns = self.columns[:, outputs].reshape(len(self.columns), -1)
        return unexplained_by(columns.T, errors.ravel(), RANK).reshape(len(outputs), -1)

    def _strength(self, at: int) -> float:
        """Strength of one effect; 0 if the motion without it diverges."""
        placed, record = self.state.placed, self.state.prediction.record
        try:
            change = self._errors((*placed[:at], *placed[at + 1 :])) - self._errors(placed)
        except OverflowError:
            return 0.0
        own = placed[at].at
        further = own in record.outputs[record.n_drives :]
        seen = [record.outputs.index(own)] if further else list(range(record.n_drives))
        found = np.sqrt(np.mean(self._left(change[seen], seen) ** 2, axis=1))
        measured = np.sqrt(np.mean(self.flat.rows(record.measured)[seen][:, self.rows] ** 2, axis=1))
        return float(found.max()) if np.all(found < measured) else 0.0


def _flat(weighting: Weighting) -> Weighting:
    """Weights that are the same at all frequencies of the band, and multiples of the noise of each output."""
    record = weighting.record
    inside = record.omega <= 2 * np.pi * THRESHOLDS.strength_hz
    return replace(weighting, density=np.multiply.outer(1 / record.noise_of_outputs, inside))
