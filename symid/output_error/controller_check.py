"""Whether the controller of a simulated closed loop is that of the log.

Small terms are added to the given controller, and their sizes estimated together with the parameters, by one step from
the estimate (a score test: C. R. Rao, Proc. Cambridge Phil. Soc. 44, 1948). They are 0 within their deviations for the
controller that made the log. Force and motion are both measured, which separates these terms from the axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.data import Log
from symid.estimation import LeastSquares, corrected_covariance, estimate, triangular_factors
from symid.identification.deviations import scatter, segments_of_rows
from symid.output_error.closed_loop_error import WHITENING_ORDER, ClosedLoopError, whitening_of
from symid.output_error.likelihood_fit import LikelihoodFit
from symid.output_error.search import Search
from symid.simulation import ClosedLoop, Command, Controller, LinearLaw
from symid.simulation.controllers import linear_law

TERMS = (
    "proportional gain",
    "integral gain",
    "derivative gain",
    "velocity feed-forward",
    "acceleration feed-forward",
    "delay",
)


@dataclass(frozen=True, eq=False)
class AlteredController(Controller):
    """The given controller plus `TERMS`, each times its change.

    Gains are those of the error: reference less the first signal that the controller reads. The delay is in samples of
    the controller, of which it takes the first order: sent + delay (last sent - sent).
    """

    given: Controller
    changes: FloatArray  # shape (n_terms,)
    order: int | None = 0  # derivative of the position that the first signal reads; None without an error

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals of the given controller."""
        return self.given.signals

    @property
    def start(self) -> FloatArray:
        """Integral of the error, last error, last force of the given controller, then its own state."""
        return np.concatenate([np.zeros(3), self.given.start])

    def holding(self, force: float) -> AlteredController:
        """With the given controller in the state in which it holds a force."""
        return replace(self, given=self.given.holding(force))

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Force of the given controller and the terms."""
        sent, inner = self.given.force(command, measured, state[3:], period)
        integral, last_error, last_sent = state[:3].tolist()
        error = 0.0
        if self.order is not None:
            wanted = (command.position, command.velocity, command.acceleration)[self.order]
            error = wanted - measured[self.signals[0]]
        integral += period * error
        slope = (error - last_error) / period
        terms = (error, integral, slope, command.velocity, command.acceleration, last_sent - sent)
        state = np.concatenate([[integral, error, sent], inner])
        return sent + float(self.changes @ terms), state

    def linear(self, period: float) -> LinearLaw | None:
        """The matrices of the given controller with three more states; None if it has none."""
        law = linear_law(self.given, period)
        if law is None or law.given.size or law.nonlinearities or law.E is not None:
            return None
        n, p, i, d, v, a, late = len(law.C), *self.changes
        error = np.zeros(law.D.size)
        if self.order is not None:
            error[self.order], error[3] = 1.0, -1.0
        A, B = np.zeros((n + 3, n + 3)), np.zeros((n + 3, law.D.size))
        A[0, 0], B[0] = 1.0, period * error
        B[1] = error
        A[2, 3:], B[2] = law.C, law.D
        A[3:, 3:], B[3:] = law.A, law.B
        D = (p + i * period + d / period) * error + (1.0 - late) * law.D
        D[1] += v
        D[2] += a
        C = np.concatenate([[i, -d / period, late], (1.0 - late) * law.C])
        return replace(law, A=A, B=B, C=C, D=D)


_STEP = 1e-4
"""Difference step of a term, as a share of the rms force."""
_CHANCE = 1e-5
"""Probability that the controller of a log is taken for another."""
_CERTAIN = 4.0
"""Deviations from 0 above which a combination of terms counts."""
_PASSES = 3
"""Fits of the whitening to what parameters and terms leave."""
_NOTICEABLE = 0.02
"""Relative change of a parameter below which it is not reported: noise is not steady where friction holds the axis."""
_VISIBLE = 1e-9
"""Least size of a combination of terms that the parameters do not imitate, relative to the greatest one."""


@dataclass(frozen=True, eq=False)
class ControllerMismatch:
    """Terms by which the controller of a log certainly differs from the given one."""

    share: float  # rms force of the terms along the first log, as a share of its rms force
    # seen parameters, their printed deviations, and the change of them that the terms bring, SI
    values: FloatArray
    deviations: FloatArray
    moved: FloatArray

    def statement(self, names: Sequence[str]) -> str:
        """Contradiction between controller and log, with the cure; empty if no parameter moves beyond its deviation."""
        excess = self.moved / np.maximum(self.deviations, _NOTICEABLE * np.abs(self.values))
        i = int(np.argmax(excess))
        if not excess[i] > 1.0:
            return ""
        return (
            "the controller given does not produce the logged force from reference and readings: "
            f"{100 * self.share:.2g} % of the force differ, which moves {names[i]} of {self.values[i]:.4g} "
            f"+- {self.deviations[i]:.2g} by {self.moved[i]:.2g}: check gains, rate, delay and feed-forward of the "
            "controller, or identify without it"
        )


def controller_mismatch(fit: LikelihoodFit) -> ControllerMismatch | None:
    """Difference between the controllers of the logs and those of the simulated loop; None if none is certain."""
    if not (runs := _runs(fit.search)):
        return None
    first = runs[0]
    loop = first.loop if first.loop.controller is not None else first.loop.tuned(fit.search.parameters)
    terms = _terms(loop, first.log)
    force = float(np.sqrt(np.mean(np.stack([first.log[drive.signal] for drive in loop.axis.drives]) ** 2)))
    sizes = np.sqrt(np.mean(terms**2, axis=1))
    units = np.divide(force, sizes, out=np.zeros_like(sizes), where=sizes > 0)
    search = replace(
        fit.search, errors=tuple(replace(run, whitening=None) for run in runs)
    )  # scaled by noise
    W, _ = search.linearised()
    lengths = np.maximum(np.linalg.norm(W, axis=0), np.finfo(float).tiny)
    V = _slopes(search, loop, units)
    if not (np.isfinite(W).all() and V.any() and np.isfinite(V).all()):
        return None
    W, V, y, rows = _whitened(search, W / lengths, V, search.residual(search.x))
    # Part of the terms that the parameters cannot imitate
    imitated = np.linalg.lstsq(W, V, rcond=_VISIBLE)[0]
    fitted = sum(WHITENING_ORDER * run.n_signals**2 for run in runs)
    changes = _certain_changes(V - W @ imitated, y, rows, fitted + len(lengths))
    if not changes.any():
        return None
    n, n_drives = len(search.seen), len(loop.axis.drives)
    added = ((changes * units)[:, None] * terms).reshape(n_drives, len(TERMS), -1).sum(axis=1)
    return ControllerMismatch(
        share=float(np.sqrt(np.mean(added**2))) / force,
        values=np.array([search.parameters[name] for name in search.seen]),
        deviations=np.sqrt(np.diag(fit.covariance))[:n],
        moved=(np.abs(imitated @ changes) / lengths)[:n],
    )


def _certain_changes(V: FloatArray, y: FloatArray, rows: Sequence[int], fitted: int) -> FloatArray:
    """Sizes of the columns of V in y, of their certain combinations only; zeros if chance explains all.

    `rows` are those of each run; `fitted` coefficients of the whitening were fitted to them.
    """
    U, sizes, rotation = np.linalg.svd(V, full_matrices=False)
    seen = sizes > _VISIBLE * sizes[0]
    U = U[:, seen]
    fit = estimate(triangular_factors(U[None], y[None]))
    size, covariance = fit.solution, _covariance(U, y, fit, rows)
    freedom = y.size - fitted - size.size
    if freedom < size.size or not np.isfinite(covariance).all():
        return np.zeros(len(rotation))
    covariance = covariance * (y.size / freedom)
    statistic = float(size @ np.linalg.pinv(covariance, hermitian=True) @ size) / size.size
    if statistic < scipy.stats.f.isf(_CHANCE, size.size, freedom):
        return np.zeros(len(rotation))
    certain = np.abs(size) > _CERTAIN * np.sqrt(np.diag(covariance))
    return np.asarray(rotation[seen].T @ (np.where(certain, size, 0.0) / sizes[seen]))


def _covariance(U: FloatArray, y: FloatArray, fit: LeastSquares, rows: Sequence[int]) -> FloatArray:
    """Covariance of sizes, at least as large as their scatter between segments, as that of the parameters."""
    covariance = corrected_covariance(U[None], y[None], fit).covariance
    by_segments = np.diag(scatter(segments_of_rows(U, y, fit, rows), fit))
    wider = np.fmax(np.sqrt(by_segments / np.diag(covariance)), 1.0)
    return np.asarray(covariance * np.outer(wider, wider))


def _runs(search: Search) -> list[ClosedLoopError]:
    """Errors of the simulated runs; empty for a search without a loop."""
    return [error for error in search.errors if isinstance(error, ClosedLoopError)]


def _whitened(
    search: Search, W: FloatArray, V: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, list[int]]:
    """Slopes and errors, whitened by the errors that parameters and terms together leave, and the rows of each run.

    Those that the parameters alone leave hold the effect of the terms, which a model of them would take for noise.
    """
    joint, residual, ends = np.hstack([W, V]), y, np.cumsum(search.rows)[:-1]
    runs = np.split(np.column_stack([joint, y]).T, ends, axis=1)
    for _ in range(_PASSES):
        models = [
            whitening_of(part.reshape(-1, run.n_signals))
            for part, run in zip(np.split(residual, ends), _runs(search), strict=True)
        ]
        white = [model.by_sample(run) for model, run in zip(models, runs, strict=True)]
        *slopes, errors = np.concatenate(white, axis=1)
        residual = y - joint @ np.linalg.lstsq(np.transpose(slopes), errors, rcond=_VISIBLE)[0]
    whole, n = np.transpose(slopes), W.shape[1]
    return whole[:, :n], whole[:, n:], errors, [run.shape[1] for run in white]


def _controllers(loop: ClosedLoop) -> tuple[Controller, ...]:
    assert loop.controller is not None
    return (loop.controller,) if isinstance(loop.controller, Controller) else tuple(loop.controller)


def _terms(loop: ClosedLoop, log: Log) -> FloatArray:
    """Unit terms of the controllers along a log, those of one drive after the other, of shape (n, n_samples)."""
    period, rows = log.sampling_period, []
    for drive, column, controller in zip(
        loop.axis.drives, loop.reference_columns(log), _controllers(loop), strict=True
    ):
        path = log[column] - log[column][0] if column in log.signals else np.zeros(log.n_samples)
        velocity = np.gradient(path, period)
        acceleration = np.gradient(velocity, period)
        error = np.zeros(log.n_samples)
        order = _order(loop, controller)
        if order is not None and controller.signals[0] in log.signals:
            reading = log[controller.signals[0]]
            error = (path, velocity, acceleration)[order] - (reading - reading[0] if order == 0 else reading)
        delayed = -np.gradient(log[drive.signal], period) * loop.held_for(log)
        rows += [
            error,
            period * np.cumsum(error),
            np.gradient(error, period),
            velocity,
            acceleration,
            delayed,
        ]
    return np.stack(rows)


def _order(loop: ClosedLoop, controller: Controller) -> int | None:
    """Derivative of the position that the first signal of a controller reads; None without such a signal."""
    orders = {sensor.signal: sensor.derivative for sensor in loop.axis.sensors}
    return orders[controller.signals[0]] if controller.signals else None


def _slopes(search: Search, loop: ClosedLoop, units: FloatArray) -> FloatArray:
    """Decrease of the errors of all runs with each term, as central differences; a column for each term."""
    controllers = _controllers(loop)

    def residual(changes: FloatArray) -> FloatArray:
        parts = zip(controllers, changes.reshape(len(controllers), len(TERMS)), strict=True)
        altered = tuple(
            AlteredController(controller, part, _order(loop, controller)) for controller, part in parts
        )
        errors = tuple(replace(run, loop=replace(run.loop, controller=altered)) for run in _runs(search))
        return replace(search, errors=errors).residual(search.x)

    columns = [(residual(-step) - residual(step)) / (2 * _STEP) for step in _STEP * np.diag(units)]
    return np.stack(columns, axis=1)
