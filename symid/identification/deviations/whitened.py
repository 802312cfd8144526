"""Rows of an estimate in coordinates in which its columns are orthonormal, and sums over segments of them.

With T of the rank analysis, the weighted rows S W T of all logs have orthonormal columns, and what the estimate leaves,
S (y - W X), is orthogonal to them. In these coordinates tests of parts against the whole need no scales.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from symid.arrays import FloatArray
from symid.estimation import LeastSquares
from symid.identification.rows.excerpts import Excerpt
from symid.identification.rows.observation import Observation
from symid.identification.rows.row_blocks import Run

_SEGMENTS = 15
"""Segments of all logs together: spans from a fifteenth of a log to the half are compared with the rest."""
_LEAST_ROWS = 4  # of a part that is whitened
_BLOCK = 16_384  # rows that stay in the cache


@dataclass(frozen=True, eq=False)
class Segment:
    """Sums over consecutive rows."""

    time: float  # of its first row, s
    of: int  # number of its log
    normal: FloatArray  # shape (n_parameters, n_parameters): Z'Z of the whitened columns
    slope: FloatArray  # shape (n_parameters,): Z'r of the residual
    square: float  # r'r
    rows: int  # how many there are

    @classmethod
    def of_products(cls, time: float, of: int, products: FloatArray, rows: int) -> Segment:
        """Sums of rows from the products of their columns and residual with each other, the residual last."""
        return cls(time, of, products[:-1, :-1], products[-1, :-1], float(products[-1, -1]), rows)


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
    for k, part in enumerate(parts):
        for j, used in enumerate(part.observation.valid):
            place = np.flatnonzero(used) / max(used.size, 1)
            yield WhitenedRows(k, j, *_used_rows(part.observation, j, part.of, fit), place)


def segments_of_rows(
    W: FloatArray, y: FloatArray, fit: LeastSquares, lengths: Sequence[int]
) -> tuple[Segment, ...]:
    """Segments of equal length of one equation, whose rows in time order are those of several logs of given lengths."""
    weight, begins, found = fit.weights[0], 0, []
    for of, length in enumerate(lengths):
        edges = begins + np.linspace(0, length, max(1, round(_SEGMENTS / len(lengths))) + 1).astype(int)
        for start, stop in pairwise(edges):
            Z, rest, _ = _orthonormal(W[start:stop], y[start:stop], weight, fit)
            rows, share = np.column_stack([Z, rest]), (start - begins) / max(length, 1)
            if stop - start >= _LEAST_ROWS:
                found.append(Segment.of_products(share, of, rows.T @ rows, int(stop - start)))
        begins += length
    return tuple(found)


def segments(runs: Sequence[Run], fit: LeastSquares, of: Sequence[int] | None = None) -> tuple[Segment, ...]:
    """Segments of equal length in time order; those with few rows are left out.

    Each run is a log; if several are parts of one log, `of` are the numbers of their logs.
    """
    each = max(1, round(_SEGMENTS / len(runs)))
    numbered = zip(range(len(runs)) if of is None else of, runs, strict=True)
    return tuple(segment for k, run in numbered for segment in _segments_of(run, k, each, fit))


def _segments_of(run: Run, of: int, each: int, fit: LeastSquares) -> Iterator[Segment]:
    """The segments of a run, from sums over its blocks."""
    p, first = fit.solution.size, 0
    bounds = -(-np.arange(each + 1) * run.n_rows // each)  # first row of each segment, and the end
    sums, begins, count = np.zeros((each, p + 1, p + 1)), np.zeros(each), np.zeros(each, dtype=int)
    for seen in run.read():
        stop = first + seen.time.size
        here = (bounds[:-1] >= first) & (bounds[:-1] < stop)
        begins[here] = seen.time[bounds[:-1][here] - first]
        for j, start in product(range(len(seen.valid)), range(0, seen.time.size, _BLOCK)):
            inside = slice(start, start + _BLOCK)
            Z, rest, _ = _used_rows(seen, j, of, fit, inside)
            rows, places = np.column_stack([Z, rest]), np.flatnonzero(seen.valid[j, inside])
            cuts = np.searchsorted(places, bounds - first - start)
            for i in np.flatnonzero(np.diff(cuts)):
                part = rows[cuts[i] : cuts[i + 1]]
                sums[i] += part.T @ part
            count += np.diff(cuts)
        first = stop
    for i in np.flatnonzero(count >= _LEAST_ROWS):
        yield Segment.of_products(float(begins[i]), of, sums[i], int(count[i]))


def _used_rows(
    seen: Observation, equation: int, of: int, fit: LeastSquares, inside: slice = slice(None)
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns Z, residual and prediction of the used rows of an equation of log number `of`."""
    weight, used = fit.weights[of * len(seen.y) + equation], seen.valid[equation, inside]
    W = seen.W[equation, inside].T[:, used].T  # columns are contiguous
    return _orthonormal(W, seen.y[equation, inside][used], weight, fit)


def _orthonormal(
    W: FloatArray, y: FloatArray, weight: float, fit: LeastSquares
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns Z, residual and prediction of rows of one equation."""
    weighted = weight * W
    prediction = weighted @ fit.solution
    return weighted @ fit.rank.inverse_root, weight * y - prediction, prediction
