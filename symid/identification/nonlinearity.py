"""Is the recorded force in proportion to what the motion takes? A cubic of the prediction as one more column.

A force that is clipped, limited softly or wrapped around falls short where the prediction is large. The residual then
holds a cubic of the prediction (J. B. Ramsey, J. Royal Statistical Society B 31, 1969), less the part that the model
itself explains. A force that was smoothed lacks, in the same way, a part of its second derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA, Criteria
from symid.identification.excerpts import Excerpt
from symid.identification.lag_scan import delayed_together, shiftable
from symid.identification.misfit import unexplained
from symid.identification.whitened import WhitenedRows

_NOISE_EXPLAINS = 1.5
"""Times the noise of the columns and the output up to which a residual says nothing of a force that was smoothed."""
_INDEPENDENT = 1e-8
"""Part of a column's power that the model's columns must leave of it."""


def nonlinearity_of(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    every: Sequence[WhitenedRows],
    inflation: float,
    criteria: Criteria = CRITERIA,
) -> str:
    """Compression of the force where it is large, in words; empty if it is in proportion."""
    of_force = [(j, name) for j, name in enumerate(model.output_names) if name in model.forces]
    beyond_noise = unexplained(model, parts, fit, replace(criteria, noise_explains=_NOISE_EXPLAINS))
    for j, force in of_force:
        rows, Z, rest, y = _of_equation(every, j)
        scale = max(float(np.max(np.abs(y), initial=0.0)), np.finfo(float).tiny)
        cubic = _Column.of(Z, rest, (y / scale) ** 3, y)
        is_bent = cubic.share > min(criteria.nonlinear, _certain(rest, inflation, criteria))
        if is_bent and abs(cubic.size) > criteria.nonlinear_output:
            less = "less" if cubic.factor < 0 else "more"
            return (
                f"where {force} is large it is {less} than in proportion to the motion (a cubic takes away "
                f"{100 * cubic.share:.2g} % of the residual's power): it is clipped, limited, or its gain changes with "
                "it; record with a wider range"
            )
        if any(name.startswith(f"{force}_d") for name in model.signals):
            continue  # flexible bodies make the same difference
        if not beyond_noise[j]:
            continue  # noise in W does too
        bent = np.concatenate([_bent(parts[r.part], fit, j) for r in rows])
        missing = _Column.of(Z, rest, bent, y)
        if missing.share > criteria.nonlinear and missing.size > criteria.smoothed_output:
            return (
                f"{force} lacks what is fast in the motion (its second derivative takes away "
                f"{100 * missing.share:.2g} % of the residual's power): it was smoothed; record it raw, or lower "
                "--cutoff"
            )
    return ""


def drift_of_gain(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    every: Sequence[WhitenedRows],
    inflation: float,
    criteria: Criteria = CRITERIA,
) -> str:
    """Whether the gain of a force drifts along the logs, in words; empty if it does not."""
    for j, force in enumerate(model.output_names):
        if force not in model.forces:
            continue
        rows, Z, rest, y = _of_equation(every, j)
        grown = [_growing(parts, fit, r, parts[r.part].moved(force).rows) for r in rows]
        drift = _Column.of(Z, rest, np.concatenate(grown), y)
        if drift.share > _certain(rest, inflation, criteria) and abs(drift.factor) > criteria.gain_drift:
            return (
                f"{force} changes by {100 * drift.factor:+.2g} % from begin to end of the log against what the same "
                "motion takes: its gain drifts, or the machine changes; identify the parts apart (--trim)"
            )
    return ""


def gain_of_sensors(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    every: Sequence[WhitenedRows],
    inflation: float,
    criteria: Criteria = CRITERIA,
) -> str:
    """Whether a sensor's gain contradicts the other signals, in words; empty if none does.

    Equations tie signals together: a body's mass takes the second derivative of a scale as it takes an accelerometer.
    """
    Z, rest, y = _of_all(every)
    for name in shiftable(model):
        if name in model.forces:
            continue
        own = [_of_rows(parts, fit, r, parts[r.part].moved(name).rows) for r in every]
        gain = _Column.of(Z, rest, np.concatenate(own), y)
        if gain.share > _certain(rest, inflation, criteria) and abs(gain.factor) > criteria.sensor_gain:
            return (
                f"{name} would have to be {1.0 - gain.factor:.2g} times as large to agree with the other signals: "
                "correct its unit, sign or gain (--unit, --gain)"
            )
    return ""


def drift_of_clocks(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    every: Sequence[WhitenedRows],
    inflation: float,
    criteria: Criteria = CRITERIA,
) -> str:
    """Whether a delay grows along the logs by less than a row, in words; empty if none does."""
    Z, rest, y = _of_all(every)
    period = parts[0].log.sampling_period
    for names in delayed_together(model):
        grown = [_growing(parts, fit, r, parts[r.part].moved(*names).slope) for r in every]
        drift = _Column.of(Z, rest, np.concatenate(grown), y)
        certain = drift.share > max(
            criteria.clock_explains, _certain(rest, inflation, criteria, criteria.clock_certain)
        )
        if certain and abs(drift.factor) > criteria.clock_drift * period:
            return (
                f"the time of {' and '.join(names)} drifts by {drift.factor / period:+.2g} samples from begin to end "
                "of the log against the other signals: clocks run at different rates; resample by their own time stamps"
            )
    return ""


def _of_all(every: Sequence[WhitenedRows]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns, residual and prediction of all equations and parts."""
    Z, rest, y = (
        np.concatenate([getattr(r, name) for r in every]) for name in ("Z", "residual", "prediction")
    )
    return Z, rest, y


def _of_equation(
    every: Sequence[WhitenedRows], equation: int
) -> tuple[list[WhitenedRows], FloatArray, FloatArray, FloatArray]:
    """Rows of an equation by part, and of all parts together columns, residual and prediction."""
    rows = [r for r in every if r.equation == equation]
    return rows, *_of_all(rows)


def _certain(
    residual: FloatArray, inflation: float, criteria: Criteria, deviations: float | None = None
) -> float:
    """Part of the residual's power that a column which is certain takes away."""
    ratio = (deviations or criteria.gain_certain) ** 2 * inflation / residual.size
    return ratio / (1.0 + ratio)


def _bent(part: Excerpt, fit: LeastSquares, equation: int) -> FloatArray:
    """Second difference of the predicted output at the used rows of a part."""
    seen = part.observation
    predicted = seen.W[equation] @ fit.solution
    bent = np.zeros_like(predicted)
    bent[1:-1] = predicted[2:] - 2 * predicted[1:-1] + predicted[:-2]
    return np.asarray(bent[seen.valid[equation]])


def _growing(
    parts: Sequence[Excerpt], fit: LeastSquares, rows: WhitenedRows, made: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """What W and y make of the residual, times the time within its log from -0.5 to 0.5."""
    part = parts[rows.part]
    times = np.concatenate([other.observation.time for other in parts if other.of == part.of])
    course = (part.observation.time - times.min()) / np.ptp(times) - 0.5
    return np.asarray(_of_rows(parts, fit, rows, made) * course[part.observation.valid[rows.equation]])


def _of_rows(
    parts: Sequence[Excerpt], fit: LeastSquares, rows: WhitenedRows, made: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """What W and y that some signals make are of the residual, in the rows used."""
    part, j, (W, y) = parts[rows.part], rows.equation, made
    weight = fit.weights[part.of * len(part.observation.valid) + j]
    return np.asarray(weight * (y[j] - W[j] @ fit.solution)[part.observation.valid[j]])


@dataclass(frozen=True)
class _Column:
    """What one more column would do.

    Parameters
    ----------
    share : float
        Part of the residual's power that it takes away beyond the columns of the model.
    size : float
        What is its own (rms), as part of the output, with the sign of the factor.
    factor : float
        Its parameter.
    """

    share: float = 0.0
    size: float = 0.0
    factor: float = 0.0

    @classmethod
    def of(cls, Z: FloatArray, r: FloatArray, column: FloatArray, y: FloatArray) -> _Column:
        """Of columns Z of the model, residual r, and output y."""
        power, whole = float(r @ r), float(column @ column)
        if not power > 0.0 or not whole > 0.0:
            return cls()
        own = column - Z @ np.linalg.lstsq(Z, column, rcond=None)[0]
        rest = float(own @ own)
        if rest < _INDEPENDENT * whole:
            return cls()
        factor = float(own @ r) / rest
        size = np.sign(factor) * np.sqrt(factor**2 * rest / max(float(y @ y), np.finfo(float).tiny))
        return cls(factor**2 * rest / power, float(size), factor)
