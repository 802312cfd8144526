"""How far effects that the model lacks may have moved the parameters, as far as the residual shows them.

A real machine always has small effects that its model lacks: friction with another curve, cogging, a cable, a lag, a
mode above the band. The noise of the residual then says too little about the error of the parameters (M. Kennedy and A.
O'Hagan, J. Royal Statistical Society B 63, 2001). Two tests show such a discrepancy, and each says how far it may have
moved every parameter:

- Columns of typical small effects are added to those of the model, the one first that explains most of the residual,
  as long as one is certain (matching pursuit). Of columns that explain about as much, the largest change counts, since
  the log does not distinguish them.
- Estimates from the lower half and the lower quarter of the band agree with that from all of it if the model is right
  (J. A. Hausman, Econometrica 46, 1978).

The changes do not correct the parameters, because only a diagnosis finds which effect it is. They widen the deviations.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares, independent_rows
from symid.identification.criteria import CRITERIA
from symid.identification.delays.lag_scan import shown_late
from symid.identification.deviations.motion_shapes import (
    FRICTION,
    OF_ACCELERATION,
    QUARTER,
    Motion,
    has_speeds,
    least_resolved,
    shapes_of,
    speeds_of,
    waves,
)
from symid.identification.deviations.whitened import WhitenedRows, segments, whitened
from symid.identification.rows.coulomb import direction
from symid.identification.rows.excerpts import Excerpt
from symid.identification.rows.noise import coefficients
from symid.identification.rows.observation import Observation
from symid.identification.rows.row_blocks import Run
from symid.signal_names import split_derivative

_LATE = "a delay of"
_PASSES = {"half": 4, "a quarter": 16}
"""Passes of a binomial filter over rows, whose Nyquist frequency is mostly twice the cutoff, for a part of the band."""


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """An effect that the model lacks, and how far it may have moved the minimal parameters."""

    effect: str
    changes: FloatArray  # shape (n_alternatives, n_parameters): by all that the log does not distinguish
    covariance: FloatArray  # shape (n_parameters, n_parameters): of a change between bands

    @property
    def is_delay(self) -> bool:
        """Whether it is a delay of a signal."""
        return self.effect.startswith(_LATE)

    def moves(self, sensitivity: FloatArray | None = None) -> bool:
        """Whether it moves any of the minimal parameters, or of functions of them by their derivatives."""
        of = np.eye(len(self.covariance)) if sensitivity is None else sensitivity
        return bool(np.any(self.variance(of)))

    def variance(self, sensitivity: FloatArray) -> FloatArray:
        """Square of the change of functions of the parameters whose derivatives have the shape (n, n_parameters)."""
        squares = np.square(self.changes @ sensitivity.T)
        noise = np.einsum("ia,ab,ib->i", sensitivity, self.covariance, sensitivity)
        certain = squares > CRITERIA.effect_certain**2 * noise
        beyond = np.where(
            certain.any(axis=1, keepdims=True), squares - CRITERIA.effect_likely**2 * noise, 0.0
        )
        return np.asarray(np.max(np.where(certain, squares, beyond), axis=0, initial=0.0))


def discrepancies_of(
    model: GeneratedModel,
    parts: Sequence[Excerpt],
    fit: LeastSquares,
    corrected: LeastSquares,
    *,
    noise_alone: bool = False,
) -> tuple[Discrepancy, ...]:
    """Effects that the residual shows, in the order in which they explain it.

    `corrected` are the parameters without their bias by noise in W, which is less in the slow part of the band. With
    `noise_alone` the residual is no larger than the noise of the signals makes it: a delay of the force then says
    nothing, as the force that a controller makes of the encoder's noise looks late.
    """
    found = _between_bands(parts, corrected)
    bias = np.abs(corrected.solution - fit.solution)
    is_noisy = bool(
        np.any(bias > np.maximum(CRITERIA.noisy * np.abs(corrected.solution), fit.standard_deviations))
    )
    rows = list(whitened(parts, fit))
    late = shown_late(model, noise_alone=noise_alone)
    return (*_pursued(_Columns(model, parts, fit, rows, late), is_noisy=is_noisy), *found)


@dataclass(frozen=True, eq=False)
class _Columns:
    """Columns that forces of some course in time, and delays, make of the rows of an estimate."""

    model: GeneratedModel
    parts: Sequence[Excerpt]
    fit: LeastSquares
    rows: Sequence[WhitenedRows]
    late: Sequence[str]  # signals that may be late

    def all(self) -> dict[str, FloatArray]:
        """Columns of all effects that are tried, by their names."""
        found = {f"{_LATE} {name}": self._late(name) for name in self.late}
        if not has_speeds(self.model):
            return found
        if any(self.model.sliding):
            found["friction that turns at another moment"] = self._turned()
        motions = [Motion.of(part) for part in self.parts]
        middle = float(np.mean(np.concatenate([motion.time for motion in motions])))
        shapes = [shapes_of(*pair, middle) for pair in zip(motions, self._drive(), strict=True)]
        shapes = [one | wave for one, wave in zip(shapes, waves(motions, self._rests()), strict=True)]
        found |= self._by_force(shapes)
        # A force on one body is in some of the equations. Where nothing rubs, only the body of the drive is tried.
        if any(self.model.sliding) and len(self.model.output_names) > 1:
            equations = np.concatenate([np.full(r.residual.size, r.equation) for r in self.rows])
            shapes = [shapes_of(motion) for motion in motions]
            for name, column in self._by_force(shapes).items():
                for j in range(len(self.model.output_names)):
                    found[f"{name}, in equation {j + 1}"] = np.where(equations == j, column, 0.0)
        return found

    def _drive(self) -> list[FloatArray]:
        """Predicted force of the drive at the rows of each part: that of the record holds its noise."""
        names = list(self.model.output_names)
        j = names.index(self.model.force) if self.model.force in names else 0
        return [part.observation.W[j] @ self.fit.solution for part in self.parts]

    def _by_force(self, shapes: Sequence[Mapping[str, FloatArray]]) -> dict[str, FloatArray]:
        """The columns that forces make, by name and by their courses at the rows of each part."""
        # The residual y - W X is linear in the force and its derivatives.
        signals = [split_derivative(name) for name in self.model.signals]
        mine = [i for i, (name, _) in enumerate(signals) if name == self.model.force]
        factors = coefficients(self.model)[..., mine]
        factors = factors[:, -1] - np.einsum("jak,a->jk", factors[:, :-1], self.fit.solution)
        made = []
        for part, shape in zip(self.parts, shapes, strict=True):
            derivatives = [np.stack(list(shape.values()))]
            for _ in range(max(signals[i][1] for i in mine)):
                derivatives.append(np.gradient(derivatives[-1], part.observation.time, axis=1))
            made.append(np.tensordot(factors, [derivatives[signals[i][1]] for i in mine], axes=1))
        return dict(zip(shapes[0], self._used(made), strict=True))

    def _turned(self) -> FloatArray:
        """The column of friction that reverses before or after the velocity, as where an axis sticks for a while.

        Rows beside a reversal are left out, but filters carry its impulse further.
        """
        signs = [direction(speeds_of(part)) for part in self.parts]
        courses = [np.diff(sign, prepend=sign[:1]) for sign in signs]
        pairs = zip(self.parts, courses, strict=True)
        return self._left([part.made_by(self.model.force, course)[0] for part, course in pairs])

    def _late(self, name: str) -> FloatArray:
        """The column of a delay of a signal."""
        return self._left([part.moved(name).slope for part in self.parts])

    def _left(self, made: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
        """The column of W and y that an effect makes of each part."""
        return self._used([y - W @ self.fit.solution for W, y in made])

    def _used(self, made: Sequence[FloatArray]) -> FloatArray:
        """Weighted values of the used rows along the last axis, of those of each part and equation."""
        equations = len(self.model.output_names)
        return np.concatenate(
            [
                self.fit.weights[self.parts[r.part].of * equations + r.equation]
                * made[r.part][r.equation][..., self.parts[r.part].observation.valid[r.equation]]
                for r in self.rows
            ],
            axis=-1,
        )

    def noise(self) -> tuple[FloatArray, FloatArray]:
        """Share of noise in the products of the orthonormal columns with themselves, and with the residual."""
        p, total = self.fit.solution.size, np.zeros((self.fit.solution.size + 1,) * 2)
        for part in self.parts:
            valid = part.observation.valid
            weights = self.fit.weights[part.of * len(valid) : (part.of + 1) * len(valid)]
            total += np.einsum("j,jab->ab", weights**2 * valid.sum(axis=1), part.noise)
        root, error = self.fit.rank.inverse_root, np.append(self.fit.solution, -1.0)
        return root.T @ total[:p, :p] @ root, -(root.T @ total[:p] @ error)

    def independent(self, rest: FloatArray) -> float:
        """Number of independent rows of a residual."""
        whole = [np.zeros(part.observation.y.shape) for part in self.parts]
        ends = np.cumsum([r.residual.size for r in self.rows])[:-1]
        for r, values in zip(self.rows, np.split(rest, ends), strict=True):
            whole[r.part][r.equation][self.parts[r.part].observation.valid[r.equation]] = values
        pairs = zip(whole, self.parts, strict=True)
        return independent_rows((values, part.observation.valid) for values, part in pairs)

    def _rests(self) -> list[FloatArray]:
        """Sum of the residuals of all equations at the rows of each part."""
        found = [np.zeros(part.observation.time.size) for part in self.parts]
        for r in self.rows:
            found[r.part][self.parts[r.part].observation.valid[r.equation]] += r.residual
        return found


def _pursued(columns: _Columns, *, is_noisy: bool) -> Iterator[Discrepancy]:
    """Effects that explain the residual, one by one; if W is noisy, those whose columns hold none of its noise."""
    named = columns.all()
    if not named:
        return
    Z, rest, predicted = (
        np.concatenate([getattr(r, name) for r in columns.rows]) for name in ("Z", "residual", "prediction")
    )
    root, names = columns.fit.rank.inverse_root, list(named)
    C = np.stack([column / (float(np.max(np.abs(column))) or 1.0) for column in named.values()], axis=1)
    along = np.linalg.lstsq(Z, C, rcond=None)[0]
    own = C - Z @ along
    resolved = least_resolved(names)
    whole = np.maximum(np.sum(C**2, axis=0), np.finfo(float).tiny / resolved)
    # A friction law that the model has is none that it may lack, whatever filters leave of its column.
    own[:, np.isin(names, FRICTION) & (np.sum(own**2, axis=0) <= CRITERIA.independent * whole)] = 0.0
    # Noise of W is in what the model leaves of a column that holds none itself, and in the residual.
    quiet = np.array([not name.startswith((*OF_ACCELERATION, _LATE)) for name in names], dtype=float)
    (noise, both), largest = columns.noise(), CRITERIA.imitated_largest**2 * float(predicted @ predicted)
    for k in range(CRITERIA.most_effects):
        taken, power = own.T @ rest + quiet * (along.T @ both), np.sum(own**2, axis=0)
        factor = np.divide(taken, power, out=np.zeros_like(power), where=power > resolved * whole)
        explained = np.minimum(factor * taken / max(float(rest @ rest), np.finfo(float).tiny), 1.0)
        explained[power < 2 * np.einsum("aj,ab,bj->j", along, noise, along)] = 0.0  # half of them is noise
        if is_noisy:
            explained[quiet == 0.0] = 0.0
        imitated = power <= CRITERIA.independent * whole
        explained[imitated & (factor**2 * whole > largest) & (explained < CRITERIA.imitated_explains)] = 0.0
        best = int(np.argmax(explained))
        left = rest - factor[best] * own[:, best]
        # squared deviations of each factor, for noise that is what the best effect leaves
        independent = max(columns.independent(left) - len(root) - k - 1, 0.0)
        deviations = np.where(imitated, CRITERIA.effect_likely, CRITERIA.effect_certain)
        explained[explained * independent <= deviations**2 * (1.0 - explained)] = 0.0
        best = int(np.argmax(explained))
        if not explained[best]:
            return
        explained[imitated & (explained < explained[best])] = 0.0
        rest = rest - factor[best] * own[:, best]
        both = both + factor[best] * noise @ along[:, best]
        alike = explained >= CRITERIA.effect_as_much * explained[best]
        changes = -(root @ (along * factor)[:, alike]).T
        name = "cogging" if names[best] == QUARTER else names[best]
        yield Discrepancy(name, changes, np.zeros((len(root), len(root))))
        # what is left of the other columns beside this one
        share = own[:, best] @ own / power[best]
        own = own - np.outer(own[:, best], share)
        along = along - np.outer(along[:, best], share)


def _between_bands(parts: Sequence[Excerpt], fit: LeastSquares) -> Iterator[Discrepancy]:
    """Changes of the parameters if only slow parts of the rows are used."""
    root = fit.rank.inverse_root
    for band, passes in _PASSES.items():
        slower = [Run.again(part.model, part.log, _slower(part.observation, passes)) for part in parts]
        sums = segments(slower, fit, [part.of for part in parts])
        if len(sums) < CRITERIA.fewest_segments:
            return
        normals, slopes = np.stack([s.normal for s in sums]), np.stack([s.slope for s in sums])
        inverse = np.linalg.pinv(np.sum(normals, axis=0), rcond=1e-6, hermitian=True)
        change = inverse @ np.sum(slopes, axis=0)
        rests = (slopes - normals @ change) @ inverse @ root.T
        noise = rests.T @ rests * len(sums) / (len(sums) - 1)  # by clusters, as `scatter`
        yield Discrepancy(f"other values below {band} of the cutoff", (root @ change)[None], noise)


def _slower(seen: Observation, passes: int) -> Observation:
    """Rows that have passed a binomial low-pass; those that others than used rows reach are left out."""
    ends, size = ((0, 0), (passes, passes)), 2 * passes + 1
    windows = np.lib.stride_tricks.sliding_window_view
    valid = np.asarray(windows(np.pad(seen.valid, ends), size, 1).all(axis=2))
    rows = np.pad(np.concatenate([seen.W, seen.y[..., None]], axis=2), (*ends, (0, 0)))
    smooth = windows(rows, size, 1) @ _binomial(2 * passes)
    return replace(seen, W=smooth[..., :-1], y=smooth[..., -1], valid=valid)


@cache
def _binomial(n: int) -> FloatArray:
    """Weights of n passes of the mean of two neighbours."""
    return np.asarray(np.array([math.comb(n, k) for k in range(n + 1)]) / 2**n)
