"""Lack of fit in parts of a log: the estimated parameters explain the rest, but not these parts.

The residual over the whole log is a mean: a clipped sensor, or a tenth of the log in another unit, distorts the
parameters but hardly raises the mean. Both are visible in the part of the log where they occur.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import BoolArray, FloatArray, runs_of_true
from symid.codegen import GeneratedModel
from symid.data import cut_in_motion
from symid.data.quality import is_switched
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.rows.excerpts import Excerpt, estimate_of
from symid.text import moment

_CLIPPED_SAMPLES = 5
"""Shortest run of an extreme value that counts as a limit, not as a peak."""
_NOISE_AT_LIMIT = 7.0
"""Range, in deviations of the noise, of the samples at a limit: noise was added to a force that had been clipped."""
_PILED = 3.0
"""Ratio of the samples in this range to those in the next one from which they are at a limit: a sine has 2.4."""
_NARROW = 0.1
"""Largest part of the whole range that it may be."""
_LEAST_ROWS = 10
_CLIPPED_SHARE = 0.01
_ROWS_A_PARAMETER = 4
_CERTAIN = 6.0
"""Classical standard deviations by which parameters without the limited rows must differ."""
_NOTICEABLE = 0.02
_WINDOWS = 50
_LEAST_WINDOWS = 3
_LOCAL_RATIO = 20.0
"""Ratio to the median rms residual of all windows above which the residual of a window stands out."""
_SILENT_RATIO = 30.0
"""Least ratio of the prediction to the output in a window with another unit, where few windows are left."""
_SILENT_RESIDUAL = 3.0
"""Least ratio of such a window's residual to the median: an output may pass near zero."""
_LOCAL_SHARE = 0.5
"""Least residual of such a window over its output: in a log that mostly rests, the median is low."""


def contradicting_part(model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> str:
    """Statement on a part of the logs that contradicts the parameters, all determined; empty without one."""
    return (
        _end_of_range(model, parts)
        or next(filter(None, (_clipped(force, parts, fit) for force in model.forces)), "")
        or next(filter(None, (_stands_out(parts, fit, j) for j in range(len(model.output_names)))), "")
    )


def unexplained_outputs(model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> str:
    """Statement on outputs with a large residual that the noise of the signals does not explain."""
    shares = unexplained(model, parts, fit)
    named = [
        f"{100 * share:.3g} % of {name}"
        for name, share in zip(model.output_names, shares, strict=True)
        if share > CRITERIA.worst_fit
    ]
    return unexplained_statement(named)


def unexplained_statement(parts: Sequence[str]) -> str:
    """Statement on signals that the parameters leave partly unexplained; empty without any."""
    cause = "a column or unit differs from its declaration, the log is damaged, or the model does not fit"
    return f"the parameters leave {', '.join(parts)}, more than noise explains: {cause}" if parts else ""


def unexplained(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    multiple: float = CRITERIA.noise_explains,
) -> FloatArray:
    """Residual of each equation as part of its output; 0 where it is at most a multiple of the noise of the signals."""
    equations, error = len(model.output_names), np.append(fit.solution, -1.0)
    residual, y = np.sqrt(
        np.sum(np.reshape((fit.residual_norm, fit.y_norm), (2, -1, equations)) ** 2, axis=1)
    )
    rows = np.sum(np.reshape(fit.rows, (-1, equations)), axis=0)
    noise = np.zeros(equations)
    for part in parts:
        noise += np.einsum("a,jab,b->j", error, part.noise, error) / len(parts)
    expected = multiple * np.sqrt(np.maximum(noise, 0.0) * rows)
    share = np.divide(residual, y, out=np.zeros_like(y), where=y > 0)
    return np.asarray(np.where(residual > expected, share, 0.0))


def _end_of_range(model: GeneratedModel, parts: Sequence[Excerpt]) -> str:
    """Statement on a motion sensor whose range ended while the axis moved on; empty without one."""
    for name in model.highest_derivatives:
        samples = 0 if name in model.forces else sum(cut_in_motion(part.log[name]) for part in parts)
        if samples:
            share = 100 * samples / sum(part.log.n_samples for part in parts)
            cure = "record with a wider range, or cut those parts out"
            return f"{name} is at the end of its range in {share:.3g} % of the log, while the axis moves on: {cure}"
    return ""


def _clipped(force: str, parts: Sequence[Excerpt], fit: LeastSquares) -> str:
    """Statement on a force that was clipped by the recorder; empty without one.

    The estimate then changes if rows at the end of the range are left out. A limit of the true force, which acts on the
    axis as well, does not change it.
    """
    noise = [part.noise_of(force) for part in parts]
    limits = [_at_limit(part.log[force], level) for part, level in zip(parts, noise, strict=True)]
    share = float(np.mean(np.concatenate(limits)))
    if share < _CLIPPED_SHARE or all(is_switched(p.log[force], n) for p, n in zip(parts, noise, strict=True)):
        return ""
    seen = [part.observation for part in parts]
    free = [o.valid & ~_rows_near(part, flags) for o, part, flags in zip(seen, parts, limits, strict=True)]
    free_fit = _of_rows(parts, free)
    where = f"{force} is at the end of its range in {100 * share:.3g} % of the log"
    cure = "record with a wider range, or cut those parts out"
    is_short = min(free_fit.rows) < _ROWS_A_PARAMETER * fit.solution.size or free_fit.status != "ok"
    # rows of a coasting axis, whose force is noise, fit parameters of zero
    if is_short or np.any(free_fit.residual_norm > CRITERIA.worst_fit * free_fit.y_norm):
        if not any(_at_limit(part.log[force], 0.0).any() for part in parts):
            return ""  # a drive that is mostly at its limits looks like that, too
        return f"{where}, and the rest is too short to decide whether the true force went beyond it: {cure}"
    whole_fit = _of_rows(parts, [o.valid for o in seen])
    moved = np.abs(free_fit.solution - whole_fit.solution)
    # variance of the difference to an efficient estimate of which the rows are a part (Hausman, Econometrica 46, 1978)
    certain = _CERTAIN * np.sqrt(
        np.maximum(np.diag(free_fit.covariance) - np.diag(whole_fit.covariance), 0.0)
    )
    if not np.any((moved > certain) & (moved > _NOTICEABLE * np.abs(free_fit.solution))):
        return ""
    return f"{where}, and without those parts the parameters differ, so that the true force went beyond it: {cure}"


def _of_rows(parts: Sequence[Excerpt], valid: Sequence[BoolArray]) -> LeastSquares:
    """Estimate from some rows of the parts, each part with its own weights."""
    return estimate_of(replace(p.observation, valid=v) for p, v in zip(parts, valid, strict=True))


def _at_limit(force: FloatArray, noise: float) -> BoolArray:
    """Samples in runs of the largest or the smallest value, unless that is 0, or within the noise of a limit."""
    flags = ((force == force.max()) | (force == force.min())) & (force != 0.0)
    width = _NOISE_AT_LIMIT * noise
    for sign in (1.0, -1.0) if width < _NARROW * np.ptp(force) else ():
        below = np.max(sign * force) - sign * force
        near, next_to = below < width, (below >= width) & (below < 2.0 * width)
        if np.count_nonzero(near) > _PILED * np.count_nonzero(next_to):
            flags |= near
    for start, stop in runs_of_true(flags):
        if stop - start < _CLIPPED_SAMPLES:
            flags[start:stop] = False
    return np.asarray(flags)


def _rows_near(part: Excerpt, samples: BoolArray) -> BoolArray:
    """Rows within half a period of the cutoff of these samples, as far as the filters spread them."""
    seen, period = part.observation, part.log.sampling_period
    assert seen.preparation.cutoff_hz is not None
    margin = int(0.5 / (seen.preparation.cutoff_hz * period))
    count = np.concatenate([[0], np.cumsum(samples)])
    places = np.rint((seen.time - part.log.start) / period).astype(int)
    first, stop = (np.clip(places + k, 0, samples.size) for k in (-margin, margin + 1))
    return np.asarray(count[stop] > count[first])


def _stands_out(parts: Sequence[Excerpt], fit: LeastSquares, equation: int) -> str:
    """Statement on a window of an equation whose residual is as large as its output; empty without one."""
    windows = np.concatenate([_windows(part, fit, equation) for part in parts])
    if len(windows) < _LEAST_WINDOWS:
        return ""
    residual, output, predicted, time = windows.T
    worst, usual = int(np.argmax(residual)), float(np.median(residual))
    many, size = (
        len(windows) >= _WINDOWS // 2,
        max(output[worst], predicted[worst], float(np.sqrt(np.mean(output**2)))),
    )
    if many and residual[worst] > _LOCAL_RATIO * usual and residual[worst] > _LOCAL_SHARE * size:
        times = residual[worst] / max(usual, np.finfo(float).tiny)
        return (
            f"near t = {moment(time[worst], 5)} s the residual is {times:.2g} times what it is elsewhere, and as "
            "large as the output: the log is damaged there, or the model lacks an effect"
        )
    large = (predicted > 0.5 * np.median(predicted)) & (residual > _SILENT_RESIDUAL * usual)
    silent = large & (predicted > _SILENT_RATIO * output)
    if not silent.any():
        return ""
    return (
        f"near t = {moment(time[np.argmax(silent)], 5)} s the output is less than {100 / _SILENT_RATIO:.2g} % of what "
        "the parameters found elsewhere predict: the unit changes within the log, or a channel is dead there"
    )


def _windows(part: Excerpt, fit: LeastSquares, equation: int) -> FloatArray:
    """Rms of residual, output and prediction, and start time, one row for each window with enough rows."""
    seen = part.observation
    size = max(_LEAST_ROWS, seen.y.shape[1] // _WINDOWS)
    n = seen.y.shape[1] // size
    y, valid = seen.y[equation, : n * size], seen.valid[equation, : n * size].reshape(n, size)
    predicted = seen.W[equation, : n * size] @ fit.solution
    counts = np.count_nonzero(valid, axis=1)
    rms = [
        np.sqrt(np.sum(np.where(valid, x.reshape(n, size), 0.0) ** 2, axis=1) / np.maximum(counts, 1))
        for x in (y - predicted, y, predicted)
    ]
    windows = np.stack([*rms, seen.time[: n * size : size]], axis=1)
    return np.asarray(windows[counts >= _LEAST_ROWS // 2])
