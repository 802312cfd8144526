"""Tests of the force for nonlinearity, by added columns such as the cube of the prediction.

A clipped, softly limited or wrapped force falls short where the prediction is large. The residual then contains a cubic
of the prediction (J. B. Ramsey, J. Royal Statistical Society B 31, 1969), less the part that the model itself explains.
A force that is faster than the cutoff is larger than its prediction: there the cube of the recorded force, prepared as
the force is, models the missing part. In the same way, a smoothed force does not contain a part of its second
derivative.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symid.arrays import FloatArray, unexplained_by
from symid.codegen import GeneratedModel
from symid.data.quality import is_switched
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.delays.lag_scan import shiftable
from symid.identification.deviations.whitened import WhitenedRows
from symid.identification.faults.added_column import AddedColumn
from symid.identification.faults.constant_force import law_sign, used_samples
from symid.identification.faults.poor_fit import unexplained
from symid.identification.rows.excerpts import Excerpt, course_of
from symid.identification.rows.noise import noise_of_rows

_NOISE_EXPLAINS = 1.5
"""Ratio of the residual to the noise of columns and output below which smoothing of the force is not tested."""
_OTHER_CAUSE = 1.0
"""Relative change of a gain along a log, or by direction, above which it has another cause."""
_ONE_WAY = 0.01
"""Share of a force's power in one direction below which the log says nothing about that direction."""
_AT_LIMIT = 0.95
"""Share of its largest value above which a force may be at a limit, noise included."""
_FREE = 1e-6
"""Distance from 1 at which a factor means that all terms of a reading have free parameters."""


@dataclass(frozen=True, eq=False)
class ColumnTests:
    """Tests whether an added column reduces the residual; each returns a statement of the fault, or an empty one."""

    model: GeneratedModel
    parts: Sequence[Excerpt]
    fit: LeastSquares
    rows: Sequence[WhitenedRows]  # all rows of the estimate, with white residuals
    inflation: float  # rows for each one that is independent of the others

    @cached_property
    def all_rows(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Columns, residual and prediction of all equations and parts."""
        return _joined(self.rows)

    def force_nonlinearity(self) -> str:
        """Statement on a force that is compressed where it is large; empty for a linear one."""
        beyond_noise = unexplained(self.model, self.parts, self.fit, _NOISE_EXPLAINS)
        for j, force in enumerate(self.model.output_names):
            if force not in self.model.forces:
                continue
            if all(is_switched(part.log[force], part.noise_of(force)) for part in self.parts):
                continue
            rows, Z, residual, y = _of_equation(self.rows, j)
            scale = max(float(np.max(np.abs(y), initial=0.0)), np.finfo(float).tiny)
            cubic = AddedColumn.of(Z, residual, (y / scale) ** 3, y)
            certain = self.certain(residual, CRITERIA.gain_certain)
            is_curved = cubic.share > min(CRITERIA.nonlinear, certain)
            if is_curved and abs(cubic.size) > CRITERIA.nonlinear_output:
                less = "less" if cubic.factor < 0 else "more"
                return (
                    f"where {force} is large it is {less} than proportional to the motion (a cubic explains "
                    f"{100 * cubic.share:.2g} % of the residual's power): it is clipped, limited, or its gain "
                    "changes with it; record with a wider range"
                )
            if any(name.startswith(f"{force}_d") for name in self.model.signals):
                continue  # flexible bodies make the same difference
            if not beyond_noise[j]:
                continue  # noise in W does too
            curvature = np.concatenate([self._second_difference(r.part, j) for r in rows])
            missing = AddedColumn.of(Z, residual, curvature, y)
            if missing.share > CRITERIA.nonlinear and missing.size > CRITERIA.smoothed_output:
                return (
                    f"{force} does not contain the fast part of the motion (its second derivative explains "
                    f"{100 * missing.share:.2g} % of the residual's power): it was smoothed; record it raw, or lower "
                    "`cutoff_hz`"
                )
        return ""

    def uneven_gain(self) -> str:
        """Statement on a force whose gain differs where it, or the motion, is positive; empty without one.

        The columns are the size of the recorded force, and that force with the sign of a friction law; beside a
        constant force, which is an offset and no gain.
        """
        Z, residual, y = self.all_rows
        ones = np.eye(len(self.model.output_names))
        Z = np.concatenate(
            [Z, np.concatenate([np.tile(ones[r.equation], (r.residual.size, 1)) for r in self.rows])], axis=1
        )
        residual = unexplained_by(Z, residual)
        least = max(CRITERIA.nonlinear, self.certain(residual, CRITERIA.gain_beyond_noise))
        for force in self.model.forces:
            signs = [[np.sign(part.log[force]) for part in self.parts]]
            signs += [[law_sign(part, *law) for part in self.parts] for law in self.model.law_columns[:1]]
            both_ways = [
                sign_by_part for sign_by_part in signs if not self._acts_one_way(force, sign_by_part)
            ]
            # without their mean: the force itself holds the residual
            means = [float(np.mean(np.concatenate(sign_by_part))) for sign_by_part in both_ways]
            courses = [
                [part.log[force] * (sign - mean) for part, sign in zip(self.parts, sign_by_part, strict=True)]
                for sign_by_part, mean in zip(both_ways, means, strict=True)
            ]
            for column in AddedColumn.of_each(Z, residual, self.made_by(force, *courses), y):
                if column.share > least and CRITERIA.uneven_gain < abs(column.factor) < _OTHER_CAUSE:
                    return (
                        f"{force} differs by direction from the force that the motion needs: its gain or the friction "
                        "is not the same in both; correct the gain, or declare AsymmetricFriction"
                    )
        return ""

    def _acts_one_way(self, force: str, signs: Sequence[FloatArray]) -> bool:
        """Whether a force hardly acts where one of the signs holds, in the rows that are used."""
        equations = range(len(self.model.output_names))
        used = [np.any([used_samples(part, j) for j in equations], axis=0) for part in self.parts]
        squares = [np.square(part.log[force]) * mask for part, mask in zip(self.parts, used, strict=True)]
        pairs = list(zip(squares, signs, strict=True))
        both = sum(float(square @ np.abs(sign)) for square, sign in pairs)
        apart = abs(sum(float(square @ sign) for square, sign in pairs))
        return both - apart < 2 * _ONE_WAY * both

    def force_limit(self) -> str:
        """Statement on a force that is limited at frequencies above the cutoff; empty for a linear one.

        The cube of the recorded force models the loss by a soft limit. Its sign in the uppermost part of its range
        models the loss by clipping.
        """
        Z, residual, y = self.all_rows
        for force in self.model.forces:
            largest = max(float(np.max(np.abs(part.log[force]))) for part in self.parts) or 1.0
            relative = [part.log[force] / largest for part in self.parts]
            cube = [x * x * x for x in relative]  # a power takes thirty times as long
            limit = [np.sign(x) * (np.abs(x) > _AT_LIMIT) for x in relative]
            by_cube, by_limit = AddedColumn.of_each(Z, residual, self.made_by(force, cube, limit), y)
            for words, column, share, size in (
                ("its cube explains", by_cube, CRITERIA.nonlinear, 0.0),
                ("its largest values explain", by_limit, CRITERIA.cut, CRITERIA.nonlinear_output),
            ):
                is_short = column.factor < -CRITERIA.bent_force * largest
                if is_short and column.share > share and -column.size > size:
                    return (
                        f"where {force} is large it is less than proportional to the motion ({words} "
                        f"{100 * column.share:.2g} % of the residual's power): it is limited; record with a wider range"
                    )
        return ""

    def made_by(self, force: str, *courses: Sequence[FloatArray]) -> list[FloatArray]:
        """The column of a force with each of these courses, given by part, prepared as the recorded force is."""
        if not courses:
            return []
        by_part = [
            part.made_by(force, *course)
            for part, course in zip(self.parts, zip(*courses, strict=True), strict=True)
        ]
        return [
            np.concatenate([self._residual_of(r, made[r.part]) for r in self.rows])
            for made in zip(*by_part, strict=True)
        ]

    def gain_drift(self) -> str:
        """Statement on a force whose gain drifts along the logs; empty without drift."""
        for j, force in enumerate(self.model.output_names):
            if force not in self.model.forces:
                continue
            rows, Z, residual, y = _of_equation(self.rows, j)
            grown = [self._growing(r, self.parts[r.part].moved(force).rows) for r in rows]
            drift = AddedColumn.of(Z, residual, np.concatenate(grown), y)
            certain = self.certain(residual, CRITERIA.gain_certain)
            if drift.share > certain and CRITERIA.gain_drift < abs(drift.factor) < _OTHER_CAUSE:
                return (
                    f"{force} changes by {100 * drift.factor:+.2g} % from the start to the end of the log for "
                    "the same motion: its gain drifts, or the machine changes; identify the parts "
                    "apart (`trim`)"
                )
        return ""

    def sensor_gain(self) -> str:
        """Statement on a sensor whose gain contradicts the other signals; empty without one.

        Equations tie signals together: a mass multiplies the second derivative of a scale as it does an acceleration.
        """
        Z, residual, y = self.all_rows
        for name in shiftable(self.model):
            if name in self.model.forces:
                continue
            columns = [self._residual_of(r, self.parts[r.part].moved(name).rows) for r in self.rows]
            gain = AddedColumn.of(Z, residual, np.concatenate(columns), y)
            certain = self.certain(residual, CRITERIA.gain_certain)
            if abs(gain.factor - 1.0) < _FREE:
                continue  # free parameters multiply all of its terms, and absorb its gain
            is_wrong = gain.share > certain and abs(gain.factor) > CRITERIA.sensor_gain
            if is_wrong and not self._is_noise(name, np.concatenate(columns), Z, residual):
                return (
                    f"{name} would have to be {1.0 - gain.factor:.2g} times as large to agree with the other signals: "
                    "correct its unit, sign or gain (`units`, `gains`)"
                )
        return ""

    def _is_noise(self, name: str, column: FloatArray, Z: FloatArray, residual: FloatArray) -> bool:
        """Whether the column of a sensor's gain explains no more of the residual than noise of the signals does.

        The noise e of the sensor is in its column and in the residual. Their product has the expectation E[e^2], so
        that the sensor seems too large where its column holds little else (errors in variables).
        """
        along = np.linalg.lstsq(Z, column, rcond=None)[0]
        outside = column - Z @ along
        error = np.append(self.fit.solution, -1.0)  # the residual is -[W, y] error
        of_model = np.append(self.fit.rank.inverse_root @ along, 0.0)
        in_column, in_both = 0.0, 0.0
        for part in self.parts:
            n_equations = len(part.observation.valid)
            weights = self.fit.weights[part.of * n_equations : (part.of + 1) * n_equations]
            rows = weights**2 * part.observation.valid.sum(axis=1)
            for signal, level in part.levels.items():
                noise = noise_of_rows(self.model, part.log, part.observation.preparation, {signal: level})
                kept = of_model + (error if signal == name else 0.0)  # own is -[W, y] kept
                in_column += float(np.einsum("j,a,jab,b->", rows, kept, noise, kept))
                in_both += float(np.einsum("j,a,jab,b->", rows, kept, noise, error))
        power, explained = float(outside @ outside), float(outside @ residual) - in_both
        certain = self.certain(residual, CRITERIA.gain_beyond_noise)
        is_small = abs(explained) <= CRITERIA.sensor_gain * (power - in_column)
        is_little = power < in_column  # beyond the model the sensor holds nothing but noise
        return is_small or is_little or explained**2 <= certain * power * float(residual @ residual)

    def certain(self, residual: FloatArray, deviations: float) -> float:
        """Share of the residual's power that a column explains if its parameter is this number of deviations from 0."""
        ratio = deviations**2 * self.inflation / residual.size
        return ratio / (1.0 + ratio)

    def _second_difference(self, part: int, equation: int) -> FloatArray:
        """Second difference of the predicted output at the used rows of a part."""
        seen = self.parts[part].observation
        predicted = seen.W[equation] @ self.fit.solution
        curvature = np.zeros_like(predicted)
        curvature[1:-1] = predicted[2:] - 2 * predicted[1:-1] + predicted[:-2]
        return np.asarray(curvature[seen.valid[equation]])

    def _growing(self, rows: WhitenedRows, made: tuple[FloatArray, FloatArray]) -> FloatArray:
        """The part of the residual that W and y make, times the time within its log from -0.5 to 0.5."""
        part = self.parts[rows.part]
        course = course_of(self.parts, part)
        return np.asarray(self._residual_of(rows, made) * course[part.observation.valid[rows.equation]])

    def _residual_of(self, rows: WhitenedRows, made: tuple[FloatArray, FloatArray]) -> FloatArray:
        """The part of the residual that W and y of some signals make, in the rows used."""
        part, j, (W, y) = self.parts[rows.part], rows.equation, made
        weight = self.fit.weights[part.of * len(part.observation.valid) + j]
        return np.asarray(weight * (y[j] - W[j] @ self.fit.solution)[part.observation.valid[j]])


def _joined(rows: Sequence[WhitenedRows]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns, residual and prediction of rows of several equations and parts."""
    Z, residual, y = (
        np.concatenate([getattr(r, name) for r in rows]) for name in ("Z", "residual", "prediction")
    )
    return Z, residual, y


def _of_equation(
    all_rows: Sequence[WhitenedRows], equation: int
) -> tuple[list[WhitenedRows], FloatArray, FloatArray, FloatArray]:
    """Rows of an equation by part, and of all parts together columns, residual and prediction."""
    rows = [r for r in all_rows if r.equation == equation]
    return rows, *_joined(rows)
