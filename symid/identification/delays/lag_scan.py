"""Residual at every lag of a signal up to a second early or late, by correlation.

Columns of W and y are sums of a part that one signal makes and a part that the others make. With that part moved by a
number of rows, the sums W'W, W'y and y'y of all lags at once are correlations, which the fast Fourier transform takes.
The estimate's residual follows for each lag from its own normal equations: no start, no linearisation.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from symid.arrays import BoolArray, ComplexArray, FloatArray, fast_length
from symid.codegen import GeneratedModel
from symid.estimation import LeastSquares
from symid.identification.rows.excerpts import Excerpt

FARTHEST = 1.0
"""Largest lag, s, on either side: typical of network, video and PLC clocks."""
_MOST_OF_LOG = 0.25
"""Largest lag as a share of the log's length."""
_AS_GOOD = 1.3
"""Ratio to the least residual that counts as equally good: a lag between two rows makes about that much."""
_LEAST_SHARE, _LEAST_ROWS = 0.5, 10
"""Rows that must be left of those at lag 0, and for each parameter, for a lag to count."""
_LEAST_EIGENVALUE = 1e-12  # relative to the largest
_LARGEST_INVERSE = 1e6
"""Largest element of the inverse of a matrix with ones in the diagonal up to which its digits suffice."""


class Lag(NamedTuple):
    """Seconds by which a signal would be recorded late, residual as part of that without, and parameters with it."""

    late: float
    left: float
    parameters: FloatArray


@dataclass(frozen=True, eq=False)
class LagScan:
    """Residual of an estimate, as part of the output's power, and parameters, at seconds by which a signal is late."""

    late: FloatArray
    residual: FloatArray
    parameters: FloatArray

    @property
    def at_zero(self) -> float:
        """Residual of the signals as recorded."""
        return float(self.residual[self.late.size // 2])

    @property
    def best(self) -> Lag:
        """Smallest lag among those of about the least residual.

        Motion that repeats itself has a residual nearly as small at every period.
        """
        least = float(self.residual.min())
        good = np.flatnonzero(self.residual <= max(_AS_GOOD * least, np.finfo(float).eps))
        i = int(good[np.argmin(np.abs(self.late[good]))])
        left = float(self.residual[i]) / max(self.at_zero, np.finfo(float).tiny)
        return Lag(float(self.late[i]), left, self.parameters[i])


@lru_cache(maxsize=16)
def shiftable(model: GeneratedModel) -> tuple[str, ...]:
    """Force and sensors that can be moved against the others: those whose laws have no jump, but one at least rests."""
    names = list(model.highest_derivatives)
    free = [name for name in names if not _has_law(model, name)]
    return tuple(free) if len(free) < len(names) else tuple(free[:-1])


def shown_late(model: GeneratedModel, *, noise_alone: bool) -> list[str]:
    """Signals that a residual may show to be late or filtered.

    If the residual is noise alone, forces are left out: the force that a controller makes of the encoder's noise looks
    late.
    """
    return [name for name in shiftable(model) if not (noise_alone and name in model.forces)]


def delayed_together(model: GeneratedModel) -> list[tuple[str, ...]]:
    """Signals that can be moved alone; and all of them together, which is the one that laws depend on the other way."""
    free = shiftable(model)
    resting = [name for name in model.measured if name not in free]
    return [*((name,) for name in free), *([free] if len(free) > 1 and len(resting) == 1 else [])]


def _has_law(model: GeneratedModel, name: str) -> bool:
    """Whether a nonlinear law depends on a signal: W of twice the signal is then not twice W."""
    generator = np.random.default_rng(0)
    own = {flat: np.zeros(3) for flat in model.signals}
    for flat in own:
        if flat == name or flat.startswith(f"{name}_d"):
            own[flat] = generator.standard_normal(3)
    still = model.sample({flat: np.zeros(3) for flat in own})[0]
    once, twice = (model.sample({flat: k * x for flat, x in own.items()})[0] - still for k in (1.0, 2.0))
    return not np.allclose(2 * once, twice, rtol=1e-9, atol=0.0)


def scan(
    parts: Sequence[Excerpt], fit: LeastSquares, names: tuple[str, ...], thirds: Sequence[int] = range(3)
) -> LagScan:
    """Residual at every lag of some signals together, in steps of a row, over the given thirds of each part.

    The fit gives the weights of the equations.
    """
    period = parts[0].log.sampling_period * (parts[0].observation.preparation.decimation or 1)
    shortest = min(part.observation.y.shape[1] for part in parts)
    most = max(1, min(round(FARTHEST / period), int(_MOST_OF_LOG * shortest)))
    p = fit.solution.size
    total, rows = np.zeros((2 * most + 1, p + 1, p + 1)), np.zeros(2 * most + 1)
    for part in parts:
        n_equations = len(part.observation.y)
        sums = part.kept((names, most), partial(_sums_of, part, names, most))
        for j, (grams, counts) in enumerate(sums):
            total += fit.weights[part.of * n_equations + j] ** 2 * grams[list(thirds)].sum(axis=0)
            rows += counts[list(thirds)].sum(axis=0)
    late = period * np.arange(-most, most + 1)
    few = (rows < _LEAST_SHARE * rows[most]) | (rows < _LEAST_ROWS * p)
    residual, parameters = _solved(total)
    return LagScan(np.asarray(late, dtype=float), np.where(few, 1.0, residual), parameters)


def _sums_of(part: Excerpt, names: tuple[str, ...], most: int) -> list[tuple[FloatArray, FloatArray]]:
    """Products of the columns of each equation, and numbers of rows, for each third of a part and each lag."""
    seen, (W, y) = part.observation, part.moved(*names).rows
    n = seen.y.shape[1]
    inside = np.arange(n) * 3 // n == np.arange(3)[:, None]
    found = []
    for j in range(len(y)):
        moving = np.column_stack([W[j], y[j]])
        used = seen.valid[j] & inside
        grams = _grams(np.column_stack([seen.W[j], seen.y[j]]) - moving, moving, used, most)
        found.append((grams, _between_ends(used, np.arange(-most, most + 1))))
    return found


def _grams(resting: FloatArray, moving: FloatArray, used: BoolArray, most: int) -> FloatArray:
    """Sums over used rows t of the products of columns resting(t) + moving(t + lag), for lags from -most to most.

    `used` of shape (n_choices, n) gives one result for each choice of rows.
    """
    n, columns = resting.shape
    length = fast_length(n + most)
    lags = np.arange(-most, most + 1)
    grams = np.zeros((len(used), lags.size, columns, columns))
    alive = np.flatnonzero(np.any(moving, axis=0))
    masked, moving = np.where(used[:, None], resting.T, 0.0), moving.T[alive]
    of_masked = np.conj(np.fft.rfft(masked, length))
    of_used = np.conj(np.fft.rfft(used[:, None], length))

    def at_lags(spectra: ComplexArray, moved: FloatArray) -> FloatArray:
        """Cross-correlations with `moved` at each lag, from the conjugate spectra of the other signals."""
        return np.fft.irfft(spectra * np.fft.rfft(moved, length), length)[..., lags].swapaxes(1, 2)

    # Products of a resting and a moving column correlate. Two moving columns shift together: their product is one
    # series, correlated with the choice of rows. Of two resting columns, the lag changes only which rows count.
    for a, i in enumerate(alive):
        crossed = at_lags(of_masked, moving[a])
        grams[..., i] += crossed
        grams[:, :, i, :] += crossed
        grams[:, :, i, alive] += at_lags(of_used, moving[a] * moving)
    # rows whose partner t + lag lies outside do not count
    for column in range(columns):
        grams[:, :, column] += _between_ends(masked[:, column : column + 1] * masked, lags).swapaxes(1, 2)
    return grams


def _between_ends(values: FloatArray | BoolArray, lags: npt.NDArray[np.int_]) -> FloatArray:
    """Sums along the last axis over the rows t for which t + lag is a row too, for each lag."""
    sums = np.zeros((*values.shape[:-1], values.shape[-1] + 1))
    np.cumsum(values, axis=-1, out=sums[..., 1:])
    n = values.shape[-1]
    return np.asarray(sums[..., np.minimum(n - lags, n)] - sums[..., np.maximum(-lags, 0)])


def _solved(grams: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Share of the last column's power that the others do not explain, and their factors, for each matrix of sums."""
    powers = np.diagonal(grams, axis1=1, axis2=2)
    # a lower power is rounding alone
    least = _LEAST_EIGENVALUE * np.max(powers, axis=0) + np.finfo(float).tiny
    scale = np.sqrt(np.maximum(powers, least))
    scaled = grams / (scale[:, :, None] * scale[:, None, :])
    normal, slope = scaled[:, :-1, :-1], scaled[:, :-1, -1]
    factors = _factors(normal, slope)
    left = np.clip(1.0 - np.sum(slope * factors, axis=1), 0.0, 1.0)
    return left, factors * scale[:, -1:] / scale[:, :-1]


def _factors(normal: FloatArray, slope: FloatArray) -> FloatArray:
    """Solutions of normal equations, 0 in the directions that they do not determine; an inverse takes a third."""
    try:
        inverse = np.linalg.inv(normal)
    except np.linalg.LinAlgError:
        return _determined(normal, slope)
    factors = np.einsum("lab,lb->la", inverse, slope)
    doubtful = ~(np.max(np.abs(inverse), axis=(1, 2)) < _LARGEST_INVERSE)
    factors[doubtful] = _determined(normal[doubtful], slope[doubtful])
    return np.asarray(factors)


def _determined(normal: FloatArray, slope: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(normal)
    along = np.einsum("lai,la->li", vectors, slope)
    seen = values > _LEAST_EIGENVALUE * values[:, -1:]
    factors = np.where(seen, along / np.where(seen, values, 1.0), 0.0)
    return np.asarray(np.einsum("lai,li->la", vectors, factors))
