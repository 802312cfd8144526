"""A signal that was filtered before it was recorded: a lag of first order, or the high-pass of AC coupling.

A signal x after a lag was x + tau x' before it, one after a high-pass of corner w was x + w times its integral. Its
rows are linear in tau or w as they are in x, so that Gauss-Newton steps over that factor and the parameters need no
new rows. On flexible axes a lag imitates a damped mode, and everywhere a high-pass imitates friction: the residual is
small, but the parameters are those of another machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import (
    LeastSquares,
    TriangularFactor,
    corrected_covariance_of_blocks,
    estimate,
    triangle,
    triangular_factors,
)
from symid.identification.criteria import CRITERIA
from symid.identification.delays.lag_scan import shiftable
from symid.identification.faults.redundancy import high_pass_of
from symid.identification.results.identification_result import Identification
from symid.identification.results.reliability import is_beyond_intervals
from symid.identification.rows.excerpts import (
    Excerpt,
    blocks_of,
    estimate_of,
    estimate_of_parts,
    running_integral,
)
from symid.identification.rows.observation import Observation
from symid.identification.rows.signal_rows import Rows

_MOST_ROUNDS = 6
_NOISELESS = 1e-10
"""Noise near the Nyquist frequency, over the rms signal, below that of any sensor: 0.1 nm of a metre."""
_SETTLED = 0.01
"""Relative change of the factor that ends the rounds."""


def lag_of(result: Identification, parts: Sequence[Excerpt], fit: LeastSquares) -> str:
    """Statement on a signal that lags; empty without one, or if a delay explains as much.

    A lag that leaves much of the residual, as noise of the derivative of its signal does, must be certain and move
    parameters out of their intervals.
    """
    timing = result.timing
    by_delay = timing.remaining if timing is not None and timing.is_significant else 1.0
    most = CRITERIA.lag_leaves * by_delay
    filters = [
        (_filtered_before(parts, fit, [part.moved(name).slope for part in parts], most=most), name)
        for name in shiftable(result.model)
    ]
    lags = [(lag.remaining, name, lag) for lag, name in filters if lag is not None]
    if not lags:
        return ""
    remaining, name, best = min(lags, key=lambda one: one[:2])
    lag = best.factor
    if remaining > most or lag < parts[0].log.sampling_period:
        return ""
    explains = remaining <= CRITERIA.lagging * by_delay
    if not explains and not (
        is_beyond_intervals(result, best.parameters) and lag > CRITERIA.ac_coupling * best.deviation()
    ):
        return ""
    return (
        f"{name} lags with a time constant of {1e3 * lag:.3g} ms (without it, {100 * remaining:.3g} % of the residual "
        "remain), which biases all parameters: it was filtered before it was recorded, or the drive is slow; "
        "record it raw"
    )


def ac_coupling_of(
    result: Identification, parts: Sequence[Excerpt], fit: LeastSquares, names: Sequence[str]
) -> str:
    """Statement on one of some signals that has passed a high-pass, which moves parameters out of their intervals."""
    model, passed, most = result.model, [], CRITERIA.ac_coupling_leaves
    for name in names:
        made = [
            part.made_by(
                name,
                running_integral(part.log[name], part.log.sampling_period),
                np.ones(part.log.n_samples),
            )
            for part in parts
        ]
        integrals, starts = ([filter_[k] for filter_ in made] for k in (0, 1))
        filter_ = (
            _by_other_sensors(model, parts, integrals, name)
            or _filtered_before(parts, fit, integrals, starts, most=most)
            or _filtered_before(parts, fit, integrals, most=most)  # the model has its own constant
        )
        passed += [(filter_, name)] if filter_ else []
    for filter_, name in sorted(passed, key=lambda pair: pair[0].remaining):
        explains = filter_.remaining < most
        if (
            explains
            and is_beyond_intervals(result, filter_.parameters)
            and filter_.factor > CRITERIA.ac_coupling * filter_.deviation()
        ):
            return (
                f"{name} seems to have passed a high-pass with a corner of {filter_.factor / (2 * np.pi):.3g} Hz, "
                "which biases all parameters: the sensor is AC coupled, or the model lacks a force; record it DC "
                "coupled, or leave it out of `measured`"
            )
    return ""


def smoothing_by_residual(
    result: Identification, parts: Sequence[Excerpt], fit: LeastSquares, names: Sequence[str]
) -> str:
    """Statement on one of some signals whose fast part was damped without a delay, as a zero-phase filter does.

    A filter of gain 1 / (1 + (T w)^2) is undone by x - T^2 x''. A factor of x'' with the other sign counts if next to
    nothing of the residual remains: the model then imitates the filter. A signal without noise beside one with noise
    was filtered in any case; since x'' undoes other filters in part only, a smaller reduction of the residual, and half
    of the change of the parameters, then count.
    """
    is_late = result.timing is not None and result.timing.is_significant
    is_filtered = not is_late and _holds_a_computed_signal(parts)
    most = 1.0 if is_filtered else max(CRITERIA.smoothing_leaves, CRITERIA.lagging)
    filters = []
    for name in names:
        bent = [
            part.made_by(name, _second_derivative(part.log[name], part.log.sampling_period))[0]
            for part in parts
        ]
        filter_ = _filtered_before(parts, fit, bent, most=most)
        filters += [(filter_, name)] if filter_ else []
    if not filters:
        return ""
    best, name = min(filters, key=lambda pair: pair[0].remaining)
    least = 1.0 if is_filtered else CRITERIA.smoothing_leaves if best.factor < 0.0 else CRITERIA.lagging
    moves = CRITERIA.smoothing_moves if is_filtered else CRITERIA.cutoff_change
    if best.remaining > least or not is_beyond_intervals(result, best.parameters, moves):
        return ""
    if not abs(best.factor) > CRITERIA.ac_coupling * best.deviation():
        return ""
    return (
        f"the fast part of {name} does not agree with the other signals (its second derivative takes away "
        f"{100 * (1 - best.remaining):.2g} % of the residual), which biases all parameters: a signal was smoothed or "
        "filtered before it was recorded; record all signals raw, or lower `cutoff_hz`"
    )


def _holds_a_computed_signal(parts: Sequence[Excerpt]) -> bool:
    """Whether one signal has less noise than any sensor, and another has not: in a computed log, no signal has any."""
    bare = [
        part.noise_of(name) < _NOISELESS * float(np.sqrt(np.mean(part.log[name] ** 2)))
        for part in parts
        for name in part.levels
    ]
    return any(bare) and not all(bare)


def _second_derivative(x: FloatArray, period: float) -> FloatArray:
    """Second derivative of a signal by central differences; 0 at the ends."""
    return np.pad(np.diff(x, 2), 1) / period**2


def _by_other_sensors(
    model: GeneratedModel, parts: Sequence[Excerpt], more: Sequence[Rows], name: str
) -> _Filter | None:
    """High-pass by sensors that repeat a signal, and the parameters without it; None without such sensors."""
    corner = high_pass_of(model, parts, name)
    if corner is None:
        return None
    factor, deviation = corner
    seen = zip((part.observation for part in parts), more, strict=True)
    fit = estimate_of(replace(o, W=o.W + factor * W, y=o.y + factor * y) for o, (W, y) in seen)
    return _Filter(factor, lambda: deviation, 0.0, fit.solution) if fit.status == "ok" else None


@dataclass(frozen=True, eq=False)
class _Filter:
    """Filter that a signal has passed: factor of its derivative or integral, and the estimate without the filter."""

    factor: float
    deviation: Callable[[], float]  # standard deviation of the factor: costs more than the estimate
    remaining: float  # residual without the filter as part of that with it; 0 if others say what it was
    parameters: FloatArray  # shape (n_parameters,): without the filter


def _filtered_before(
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    more: Sequence[Rows],
    constants: Sequence[Rows] = (),
    *,
    most: float,
) -> _Filter | None:
    """Factor of the derivative or the integral of a signal, by its rows in each part; None if it is not determined.

    `constants` are the rows of the constant from which an integral starts in each part. None also if every factor
    leaves more than `most` of the residual.
    """
    # First a lower bound without iteration: no factor leaves less than free coefficients of all columns.
    before = estimate_of_parts(parts)
    step_rows = [
        _StepRows.of(part.observation, [made, *constants[k : k + 1]])
        for k, (part, made) in enumerate(zip(parts, more, strict=True))
    ]
    power = np.maximum(before.residual_norm**2, np.finfo(float).tiny)
    least = np.concatenate([rows.least_squares for rows in step_rows])
    if math.sqrt(float(np.mean(least / power))) > most:
        return None
    factor, X, p = 0.0, fit.solution, fit.solution.size
    for _ in range(_MOST_ROUNDS):
        # The rows are bilinear in the factor and X: each round is linear in the changes around the last values of both.
        steps = [rows.of_step(factor, X, k, len(constants)) for k, rows in enumerate(step_rows)]
        step_fit = estimate(
            [
                TriangularFactor(triangle(part_factor.R @ step), part_factor.rows)
                for rows, step in zip(step_rows, steps, strict=True)
                for part_factor in rows.factors
            ]
        )
        if step_fit.status != "ok":
            return None
        X, size = step_fit.solution[:p], float(step_fit.solution[p])
        factor += size
        if abs(size) < _SETTLED * abs(factor):
            break

    def deviation() -> float:
        last = [rows.combined(step) for rows, step in zip(step_rows, steps, strict=True)]
        correlated = corrected_covariance_of_blocks(lambda: blocks_of(last), step_fit)
        return float(correlated.standard_deviations[p])

    remaining = float(np.sqrt(np.mean(step_fit.residual_norm**2 / power)))
    return _Filter(factor, deviation, remaining, X)


@dataclass(frozen=True, eq=False)
class _StepRows:
    """Rows of a part: in each Gauss-Newton step, their columns are combinations of a few constant ones."""

    observation: Observation
    W: FloatArray  # shape (n_equations, n_rows, n_columns): of the rows, and of what a signal makes, with its y
    used: BoolArray  # shape (n_columns,): those that are not 0 throughout
    factors: tuple[TriangularFactor, ...]  # of the used columns and y, one of each equation

    @classmethod
    def of(cls, seen: Observation, made: Sequence[Rows]) -> _StepRows:
        """Columns of the rows of a part, of those that a signal makes, and of those that a constant makes."""
        W = np.concatenate([seen.W, *(x for W, y in made for x in (W, y[..., None]))], axis=2)
        used = np.any(W != 0.0, axis=(0, 1))
        return cls(seen, W, used, triangular_factors(W[..., used], seen.y, seen.valid))

    @property
    def least_squares(self) -> FloatArray:
        """Smallest sum of squares that any combination of the columns leaves of each equation."""
        return np.array([factor.R[-1, -1] ** 2 for factor in self.factors])

    def of_step(self, factor: float, X: FloatArray, part: int, n_constants: int) -> FloatArray:
        """Matrix that makes W and y of a step of the used columns and y."""
        p, made = X.size, self.W.shape[2] // (X.size + 1)
        step = np.zeros((self.W.shape[2] + 1, p + n_constants + 2))
        step[:p, :p], step[-1, -1] = np.eye(p), 1.0
        step[p : 2 * p, :p], step[2 * p, -1] = factor * np.eye(p), factor
        places = (p, p + 1 + part)  # of the step, and of the part's constant
        for k, place in enumerate(places[:made]):
            begin = p + k * (p + 1)
            step[begin : begin + p, place], step[begin + p, place] = X, -1.0
        return np.asarray(step[np.append(self.used, True)])

    def combined(self, step: FloatArray) -> Observation:
        """The rows of a step."""
        W = self.W[..., self.used] @ step[:-1]
        return replace(self.observation, W=W[..., :-1], y=W[..., -1] + self.observation.y)
