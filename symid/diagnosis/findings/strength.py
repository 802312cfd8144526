"""Strength of each effect of a model: the error of the force that the effect alone would leave.

A gap is weighted by noise, so that at high frequencies, where the noise of the position hides much, it hardly counts;
and near a reversal a late force or friction errs for some milliseconds only, but by much. Shares of the gap thus
depend on the encoder and on how often the axis turns. The strength does not: it is the rms of the force, in one fixed
band and away from reversals, by which the prediction changes if the effect is left out and the parameters are fitted
to what remains.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symid.arrays import BoolArray, FloatArray, IntArray
from symid.diagnosis.fitting.gauss_newton import solved
from symid.diagnosis.fitting.sensitivity import prediction_jacobian
from symid.diagnosis.fitting.state import State, evaluated
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS


def strengths_of(state: State, weighting: Weighting, away: BoolArray, n_declared: int) -> FloatArray:
    """Strength of each effect found, in multiples of the noise of the force; shape (n_effects,).

    Only the kept rows `away` from reversals count, a bool array of shape (n_kept,). The first `n_declared` effects are
    declared imperfections. An error of a further reading, which no force shows, counts in multiples of the noise of
    that reading.
    """
    flat = _flat(weighting)
    rows = np.flatnonzero(weighting.kept)[away]
    n_physical = len(state.prediction.parameters)
    columns = flat.rows(prediction_jacobian(state)[:n_physical])[:, :, rows]
    return np.array(
        [_strength(state, flat, at, columns, rows) for at in range(n_declared, len(state.placed))]
    )


def _flat(weighting: Weighting) -> Weighting:
    """Weights that are the same at all frequencies of the band, and multiples of the noise of each output."""
    record = weighting.record
    inside = record.omega <= 2 * np.pi * THRESHOLDS.strength_hz
    return replace(weighting, density=np.multiply.outer(1 / record.noise_of_outputs, inside))


def _strength(state: State, flat: Weighting, at: int, columns: FloatArray, rows: IntArray) -> float:
    """Strength of one effect; `columns` are those of the parameters, shape (n_parameters, n_outputs, n_rows)."""
    item, outputs = state.placed[at], state.prediction.record.outputs
    rest = (*state.placed[:at], *state.placed[at + 1 :])
    without = evaluated(state, flat, state.prediction.parameters, rest)
    change = flat.rows(without.errors - state.errors)[:, rows]
    n_drives = state.prediction.record.n_drives
    seen = [outputs.index(item.at)] if item.at in outputs[n_drives:] else list(range(n_drives))
    errors, parts = change[seen].ravel(), columns[:, seen].reshape(len(columns), -1)
    left = (errors - parts.T @ solved(parts.T, errors)).reshape(len(seen), -1)
    return float(np.sqrt(np.mean(left**2, axis=1).max()))
