"""Rows of an estimate in coordinates in which its columns are orthonormal, and sums over segments of them.

With T of the rank analysis, the weighted rows S W T of all logs have orthonormal columns, and what the estimate leaves,
S (y - W X), is orthogonal to them. In these coordinates tests of parts against the whole need no scales.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symid.arrays import FloatArray
from symid.estimation import LeastSquares
from symid.identification.rows.excerpts import Excerpt

_SEGMENTS = 15
"""Segments of all logs together: spans from a fifteenth of a log to the half are compared with the rest."""
_LEAST_ROWS = 4  # of a part that is whitened


@dataclass(frozen=True, eq=False)
class Segment:
    """Sums over consecutive rows."""

    time: float  # of its first row, s
    of: int  # number of its log
    normal: FloatArray  # shape (n_parameters, n_parameters): Z'Z of the whitened columns
    slope: FloatArray  # shape (n_parameters,): Z'r of the residual
    square: float  # r'r
    rows: int  # how many there are


@dataclass(frozen=True, eq=False)
class WhitenedRows:
    """Used rows of one equation of a part of a log: columns Z, residual r, prediction S W X, and place in the part."""

    part: int
    equation: int
    Z: FloatArray
    residual: FloatArray
    prediction: FloatArray
    place: FloatArray


def whitened(parts: Sequence[Excerpt], fit: LeastSquares) -> Iterator[WhitenedRows]:
    """Rows of each part of the logs and each equation; all parameters of the fit are determined."""
    root = fit.rank.inverse_root
    for k, part in enumerate(parts):
        seen = part.observation
        n_equations = seen.y.shape[0]
        for j in range(n_equations):
            weight, used = fit.weights[part.of * n_equations + j], seen.valid[j]
            W = weight * seen.W[j][used]
            prediction = W @ fit.solution
            rest = weight * seen.y[j][used] - prediction
            yield WhitenedRows(k, j, W @ root, rest, prediction, np.flatnonzero(used) / max(used.size, 1))


def segments_of_rows(
    W: FloatArray, y: FloatArray, fit: LeastSquares, lengths: Sequence[int]
) -> tuple[Segment, ...]:
    """Segments of equal length of one equation, whose rows in time order are those of several logs of given lengths."""
    weight, begins, found = fit.weights[0], 0, []
    for of, length in enumerate(lengths):
        edges = begins + np.linspace(0, length, max(1, round(_SEGMENTS / len(lengths))) + 1).astype(int)
        for start, stop in pairwise(edges):
            Z, r = weight * W[start:stop], weight * (y[start:stop] - W[start:stop] @ fit.solution)
            Z = Z @ fit.rank.inverse_root
            share = (start - begins) / max(length, 1)
            if stop - start >= _LEAST_ROWS:
                found.append(Segment(share, of, Z.T @ Z, Z.T @ r, float(r @ r), int(stop - start)))
        begins += length
    return tuple(found)


def segments(parts: Sequence[Excerpt], fit: LeastSquares) -> tuple[Segment, ...]:
    """Segments of equal length in time order; those with few rows are left out."""
    each, p = max(1, round(_SEGMENTS / len(parts))), fit.solution.size
    normal, slope = np.zeros((len(parts), each, p, p)), np.zeros((len(parts), each, p))
    square, count = np.zeros((len(parts), each)), np.zeros((len(parts), each), dtype=int)
    for rows in whitened(parts, fit):
        edges = np.searchsorted(rows.place, np.linspace(0, 1, each + 1))
        some = np.flatnonzero(np.diff(edges))
        whole = np.concatenate([rows.Z, rows.residual[:, None]], axis=1)
        products = np.add.reduceat(whole[:, :, None] * whole[:, None, :], edges[some]) if some.size else 0.0
        sums = np.zeros((each, p + 1, p + 1))
        sums[some] = products
        normal[rows.part] += sums[:, :p, :p]
        slope[rows.part] += sums[:, p, :p]
        square[rows.part] += sums[:, p, p]
        count[rows.part] += np.diff(edges)
    found = []
    for k, part in enumerate(parts):
        time = part.observation.time
        for i in np.flatnonzero(count[k] >= _LEAST_ROWS).tolist():
            begins = float(time[i * time.size // each])
            found.append(
                Segment(begins, part.of, normal[k, i], slope[k, i], float(square[k, i]), int(count[k, i]))
            )
    return tuple(found)
