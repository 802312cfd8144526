"""Screening: projection of the error of a fitted model on every effect at every place, for each of its shapes.

A projection is linear and cheap. It ranks the candidates for the nonlinear fits of the confirmation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import ComplexArray, FloatArray, norms_or_one
from symid.diagnosis.effects import Effect, Key, Placed, Shape, with_equivalents
from symid.diagnosis.fitting.fit import AR_ORDER, Fit
from symid.diagnosis.thresholds import THRESHOLDS
from symid.estimation import Autoregression, autoregression, unweighted

_BATCH = 200_000
"""Values in the columns of the shapes that are tried together: as many as fit in a processor's cache."""
_BLIND = 1e-4  # of the norm of a column that the base columns leave


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect at a place with its best shape and amplitudes by projection."""

    placed: Placed  # effect, place and values
    gain: float  # gain of the log-likelihood, errors taken as white
    white_gain: float  # gain after whitening by an autoregressive model of the errors
    # other laws of the effect with as many free values, which a projection hardly distinguishes
    others: tuple[Placed, ...] = ()

    @property
    def penalised_gain(self) -> float:
        """The gain less the penalty of the free values."""
        return self.gain - THRESHOLDS.penalty * self.placed.n_free

    @property
    def white_penalised_gain(self) -> float:
        """Penalised gain after whitening by an autoregressive model."""
        return self.white_gain - THRESHOLDS.penalty * self.placed.n_free


def screened(fit: Fit, library: Sequence[Effect]) -> list[Candidate]:
    """Best law and shape of every effect at every place, the largest gain first."""
    prediction, left = fit.state.prediction, fit.left
    plain = unweighted(left, fit.weighting.kept, AR_ORDER)
    white = autoregression(left, fit.weighting.kept, AR_ORDER)
    base = fit.base
    projections = (_Projection(fit, base, plain), _Projection(fit, base, white))
    del base  # large after many rests
    wanted = fit.weighting.adjoint(left)

    def matched_filter(response: ComplexArray) -> FloatArray:
        return prediction.record.fine(np.sum(response.conj() * wanted, axis=0))

    laws: dict[Key, list[Candidate]] = {}
    present = with_equivalents(item.key for item in fit.state.placed)
    for effect in library:
        for place in effect.places(prediction):
            if (effect.name, place) in present:
                continue
            shapes = list(effect.shapes(prediction, place, matched_filter))
            own = _best_shape(fit, projections, effect, place, shapes)
            if own is not None:
                laws.setdefault(own.placed.key, []).append(own)
    return sorted(map(_best_law, laws.values()), key=lambda c: -c.gain)


def is_in_proportion(change: FloatArray, force: FloatArray) -> bool:
    """Whether the change of a force has the course of the force itself.

    Scaled parameters make the same change, and the record would explain itself.
    """
    likeness = np.vdot(change, force) ** 2 / max(
        np.vdot(change, change) * np.vdot(force, force), np.finfo(float).tiny
    )
    return bool(1 - likeness < THRESHOLDS.own_course)


def _larger_gain(own: Candidate) -> float:
    return max(own.gain, own.white_gain)


def _best_law(laws: Sequence[Candidate]) -> Candidate:
    """The law of an effect with the largest gain, and others of the same size."""
    best = max(laws, key=_larger_gain)
    least = THRESHOLDS.promising * _larger_gain(best)
    alike = (c for c in laws if c is not best and c.placed.n_free == best.placed.n_free)
    return replace(best, others=tuple(c.placed for c in alike if _larger_gain(c) > least))


class _Projection:
    """Projection of the error that the base columns leave on further columns, under a noise model.

    Products of whitened columns with the whitened base and error equal products of the columns themselves with the
    adjoint of the whitening applied to these, which is computed once.
    """

    def __init__(self, fit: Fit, base: FloatArray, noise: Autoregression) -> None:
        self.noise = noise
        base = noise.apply(base)
        base /= norms_or_one(base, axis=1)[:, None]
        unit = np.linalg.qr(base.T)[0].T
        error = noise.apply(fit.state.rows)
        left = error - (unit @ error) @ unit
        self.n_rows, self.square = left.size, float(left @ left)
        self._base_and_left = np.empty((len(unit) + 1, fit.state.rows.size)).T
        for column, row in zip(self._base_and_left.T, (*unit, left), strict=True):
            column[:] = noise.adjoint(row).ravel()

    def gains(self, rows: FloatArray, *, fixed: bool) -> list[tuple[float, FloatArray]]:
        """Gain and amplitudes for groups of columns of shape (n_groups, n_amplitudes, n_outputs, n_rows)."""
        white = self.noise.apply(rows)
        products = rows.reshape(rows.shape[0] * rows.shape[1], -1) @ self._base_and_left
        products = products.reshape(*rows.shape[:2], -1)
        explained, targets = products[..., :-1], products[..., -1]
        whole = white @ white.swapaxes(1, 2)
        # Gram matrix of the columns after projection on the base (partial regression)
        left = whole - explained @ explained.swapaxes(1, 2)
        sizes, norms = (np.sqrt(np.maximum(np.diagonal(g, axis1=1, axis2=2), 0.0)) for g in (whole, left))
        seen = np.all(norms > _BLIND * np.maximum(sizes, np.finfo(float).tiny), axis=1)
        seen &= np.isfinite(norms).all(axis=1)
        return [
            self._gain(left[i], norms[i], targets[i], fixed=fixed)
            if seen[i]
            else (0.0, np.zeros(rows.shape[1]))
            for i in range(len(rows))
        ]

    def _gain(
        self, left: FloatArray, norms: FloatArray, target: FloatArray, *, fixed: bool
    ) -> tuple[float, FloatArray]:
        """Gain and amplitudes of one group."""
        if fixed:  # a negative gain shows how far a shape is from one that helps
            closed = float(2 * target.sum() - left.sum()) / self.square
            return self._of(closed), np.ones(1)
        share = np.asarray(target / norms)
        if len(norms) > 1:
            share = np.asarray(np.linalg.lstsq(left / np.outer(norms, norms), share, rcond=1e-8)[0])
        return self._of(float(target @ (share / norms)) / self.square), share / norms

    def _of(self, closed: float) -> float:
        """Gain of columns that remove a share `closed` of the sum of squares."""
        return float(-0.5 * self.n_rows * np.log1p(-min(closed, 1 - 1e-12)))


def _best_shape(
    fit: Fit,
    projections: tuple[_Projection, _Projection],
    effect: Effect,
    place: str,
    shapes: Sequence[Shape],
) -> Candidate | None:
    """Candidate with the best shape under either noise model; None if no shape has a possible amplitude."""
    found: list[Candidate] = []
    prediction, n_drives = fit.state.prediction, fit.state.prediction.record.n_drives
    of_drives = slice(n_drives), fit.weighting.kept
    force = fit.weighting.rows(prediction.record.measured)[of_drives] if effect.is_of_command else None
    many = max(1, _BATCH // (max(len(effect.amplitudes), 1) * fit.state.rows.size))
    for first in range(0, len(shapes), many):
        some = shapes[first : first + many]
        columns = np.stack([effect.columns(prediction, place, shape) for shape in some])
        if not effect.is_of_command:
            columns = prediction.passed_on(columns)
        rows = fit.weighting.rows(columns)
        plain, white = (p.gains(rows, fixed=effect.fixed) for p in projections)
        for shape, own, (gain, amplitudes), (white_gain, _) in zip(some, rows, plain, white, strict=True):
            if effect.positive and amplitudes[0] < 0:
                continue
            if force is not None and is_in_proportion(own[0][of_drives], force):
                continue
            values = (1.0,) if effect.fixed else tuple(map(float, amplitudes))
            found.append(Candidate(Placed(effect, place, shape, values), gain, white_gain))
    return max(found, key=_larger_gain, default=None)
