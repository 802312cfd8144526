"""Constancy of the parameters: scatter between segments of the logs, and spans with different parameters.

The scatter is the covariance of clusters (K.-Y. Liang and S. Zeger, Biometrika 73, 1986): with the sums s_b = Z'r over
segment b the estimate has the covariance T (sum s_b s_b') T', whatever the residual's correlation and size within a
segment. Spans are compared with the rest as in the test of Chow (Econometrica 28, 1960), over all spans of segments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.deviations.whitened import Segment
from symid.text import moment

_SEEN = 0.03
"""Part of the information on a direction that a span must hold to be compared in it."""
_FEWEST = 4  # segments
_EQUAL = 1e-9
"""Relative difference of two gains that is rounding."""
_INERTIAS = ("kg", "kg*m^2")
"""Units of what does not change with temperature, unlike friction."""


@dataclass(frozen=True, eq=False)
class Change:
    """A span whose parameters differ from those of the rest."""

    begins: float  # start time, s
    # inside, outside: shape (n_parameters,): parameters in the span and in the rest
    inside: FloatArray
    outside: FloatArray
    deviations: FloatArray  # shape (n_parameters,): standard deviations of their difference
    explained: float  # share of the residual's power that separate parameters remove

    def most_certain(self, among: BoolArray) -> int:
        """Place of the parameter that differs by the most deviations, of some."""
        moved = np.abs(self.inside - self.outside)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return int(np.argmax(np.where(among, moved / self.deviations, -1.0)))

    def statement(self, model: GeneratedModel, signed: BoolArray, *, distorts: bool = False) -> str:
        """Statement on changes within the logs; empty without one.

        A change counts that explains much of the residual, or that distorts the parameters of all rows beyond their
        printed deviations: a small part of the log does so where it holds most of the information on a parameter.
        `signed` parameters may have either sign: they change in relation to the largest one of their unit.
        """
        moved = np.abs(self.inside - self.outside)
        size = np.maximum(np.abs(self.inside), np.abs(self.outside))
        units = np.array(list(model.minimal_units.values()))
        size = np.where(signed, [np.max(size[units == unit]) for unit in units], size)
        least_change = np.where(np.isin(units, _INERTIAS), CRITERIA.inertia_change, CRITERIA.change)
        certain = (moved > CRITERIA.change_certain * self.deviations) & (moved > least_change * size)
        least = CRITERIA.change_distorts if distorts else CRITERIA.change_explains
        if self.explained < least or not certain.any():
            return ""
        i = self.most_certain(certain)
        name, unit = list(model.minimal_units.items())[i]
        return (
            f"parameters change within the logs: from t = {moment(self.begins, 4)} s on {name} is {self.inside[i]:.4g} "
            f"{unit}, elsewhere {self.outside[i]:.4g}: gain, payload or machine change, or a part is damaged; identify "
            "the parts apart (`trim`)"
        )


def scatter(parts: Sequence[Segment], fit: LeastSquares) -> FloatArray:
    """Covariance of the minimal parameters from the scatter between segments of a fit; zeros if there are too few.

    The segments may hold a part of the rows of the fit.
    """
    p, n = fit.solution.size, len(parts)
    if n < _FEWEST:
        return np.zeros((p, p))
    slopes = np.stack([segment.slope for segment in parts])
    root = fit.rank.inverse_root
    share = sum(segment.rows for segment in parts) / sum(fit.rows)
    return np.asarray(root @ (slopes.T @ slopes) @ root.T * n / (n - 1) * share)


def greatest_change(parts: Sequence[Segment], values: FloatArray, root: FloatArray) -> Change | None:
    """The span of segments, in time order, whose own parameters take most from the residual; None if there are too few.

    `root` takes coordinates in which the columns of all segments are orthonormal to the parameters, whose estimates
    are `values`; combinations that no segment sees have no coordinate. The number of rows for each independent one
    follows from the scatter of the segments about both parameters, as the change itself correlates the whole residual.
    """
    n, p = len(parts), root.shape[1]
    if n < _FEWEST:
        return None
    normals, slopes = np.stack([s.normal for s in parts]), np.stack([s.slope for s in parts])
    # Sums over any span are differences of cumulative sums, so all spans are compared without a pass over the rows.
    normal = np.concatenate([np.zeros((1, p, p)), np.cumsum(normals, axis=0)])
    slope = np.concatenate([np.zeros((1, p)), np.cumsum(slopes, axis=0)])
    whole = sum(s.square for s in parts)
    spans = [(i, j) for i in range(n) for j in range(i + 1, n + 1) if j - i <= n // 2 + 1 and j - i < n]
    begins, ends = np.transpose(spans)
    compared = _Comparison.of(
        normal[ends] - normal[begins], slope[ends] - slope[begins], normal[-1], slope[-1]
    )
    # A span and the rest gain the same: of both, the one that begins later, from when on the parameters are others.
    best = int(np.flatnonzero(~(compared.gain < (1.0 - _EQUAL) * np.max(compared.gain)))[-1])
    gain, i, j = float(compared.gain[best]), int(begins[best]), int(ends[best])
    if not whole > 0.0 or gain <= 0.0:
        return None
    inside, outside, spread = compared.inside[best], compared.outside[best], compared.spread(best)
    rows = sum(s.rows for s in parts)
    sigma2 = max(whole - gain, np.finfo(float).eps * whole) / max(rows - 2 * p, 1)
    is_inside = (np.arange(n) >= i) & (np.arange(n) < j)
    rest = slopes - np.einsum("bij,bj->bi", normals, np.where(is_inside[:, None], inside, outside))
    inflation = np.sum(rest**2) / (sigma2 * np.trace(normal[-1])) * n / (n - 2)
    deviations = np.sqrt(np.diag(root @ spread @ root.T) * sigma2 * max(float(inflation), 1.0))
    return Change(parts[i].time, values + root @ inside, values + root @ outside, deviations, gain / whole)


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Spans of rows compared with the rest, in the directions that both see."""

    gain: FloatArray  # shape (n_spans,): fall of the residual's square by separate parameters
    # inside, outside: shape (n_spans, n_parameters): estimates from a span and from the rest
    inside: FloatArray
    outside: FloatArray
    directions: FloatArray  # shape (n_spans, n_parameters, n_parameters): columns are directions
    # shape (n_spans, n_parameters): of the difference of both estimates along each direction; 0 where they are
    # not compared
    variances: FloatArray

    @classmethod
    def of(cls, inside: FloatArray, slope: FloatArray, normal: FloatArray, total: FloatArray) -> _Comparison:
        """Comparison from sums over each span, one per row, and over all rows."""
        # A short span determines few directions. In the eigenvectors of its normal matrix both estimates are compared
        # one by one, and only where the span and the rest each hold part of the information.
        values, V = np.linalg.eigh(inside)
        every = np.maximum(np.sum(V * (normal @ V), axis=1), np.finfo(float).tiny)
        share = values / every
        seen = (share > _SEEN) & (share < 1.0 - _SEEN)
        a, b = np.where(seen, values, 1.0), np.where(seen, every - values, 1.0)
        inner, outer = (
            np.where(seen, (V.swapaxes(1, 2) @ x[..., None])[..., 0], 0.0) / n
            for x, n in ((slope, a), (total - slope, b))
        )
        return cls(
            np.sum(a * inner**2 + b * outer**2, axis=1),
            (V @ inner[..., None])[..., 0],
            (V @ outer[..., None])[..., 0],
            V,
            np.where(seen, 1 / a + 1 / b, 0.0),
        )

    def spread(self, span: int) -> FloatArray:
        """Covariance of the difference of both estimates, for residuals of variance 1."""
        V = self.directions[span]
        return np.asarray((V * self.variances[span]) @ V.T)
