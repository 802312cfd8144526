"""Weights that make errors of force and readings comparable, from the noise of the signals.

The error of an output contains its own noise and the noise of the driven position, passed through the frequency
response G of the axis: S = sigma^2 + |G|^2 sigma_q^2. Division by sqrt(S) whitens the errors: noise alone leaves rows
of unit variance. A smooth window first removes rests and the ends of the log, because no model predicts friction at
rest; reversals stay. Unknown states of hidden motion, at the beginning and after each rest, are projected out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy

from symid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from symid.diagnosis.prediction.record import Record

_RESOLUTIONS = 0.5
"""Margin around a rest, and shortest rest, in periods of the highest frequency used."""
_LONGEST_MARGIN = 0.010
_SHORTEST_REST = 0.004
_LONGER = 1.5
"""Duration of low speed, relative to that of a reversal, from which on the axis sticks."""
_TAPER = 0.004
_END, _END_OF_BAND = 0.02, 0.5
"""Time at the ends of a log that is left out, s, and in periods of the highest frequency used: there the band-limited
continuation of the log rings."""
_MOST_OF_LOG = 0.05
"""Largest share of a log that is left out at either end for that."""
_UNSEEN = 1e-9
_ORTHONORMAL = 1e-12
_MOST_STARTS = 40
_TOGETHER = 16
"""Columns that are projected together, which need as much memory again."""
_TRANSFORMED, _AT_ONCE = 40_000, 4
"""Values of the columns that are transformed together; least number of transforms, which share instructions."""


@dataclass(frozen=True, eq=False)
class Weighting:
    """Errors as rows of unit variance."""

    record: Record  # the log
    # shape (n_rows,): 1 where the axis moves, falling smoothly to 0 where it rests and outside the log
    window: FloatArray
    kept: BoolArray  # shape (n_rows,): rows where the window is 1
    density: FloatArray  # shape (n_outputs, n_bins): 1 / sqrt(S), scaled for the band
    allowed: BoolArray | None = None  # shape (n_fine,): parts of the log that may be used
    # outputs, of shape (n_outputs, n_bins), for forces on hidden motion, whose state is unknown whenever the axis
    # begins to move
    unknown: Sequence[ComplexArray] = ()
    _begun: dict[str, FloatArray] = field(default_factory=dict, init=False, repr=False)

    def rows(self, errors: ComplexArray) -> FloatArray:
        """Weighted errors of shape (..., n_outputs, n_rows) from spectra of shape (..., n_outputs, n_bins)."""
        n, (*several, n_outputs, n_bins) = self.record.n_rows, errors.shape
        count = math.prod(several)
        columns, results = errors.reshape(count, n_outputs, n_bins), np.empty((count, n_outputs, n))
        # Several at a time share the instructions of a transform; a few more leave the processor's cache.
        many = max(min(max(_TRANSFORMED // n, _AT_ONCE) // n_outputs, count), 1)
        spectra = np.empty((many, n_outputs, n // 2 + 1), dtype=complex)
        courses = np.empty((many, n_outputs, n))
        for first in range(0, count, many):
            some = columns[first : first + many]
            at = slice(len(some))
            np.multiply(some, self.record.taper, out=spectra[at, :, :n_bins])
            spectra[at, :, n_bins:] = 0.0
            np.fft.irfft(spectra[at], n, norm="forward", out=courses[at])
            courses[at] *= self.window
            np.fft.rfft(courses[at], out=spectra[at])
            spectra[at] *= self._scaled_density
            np.fft.irfft(spectra[at], n, norm="forward", out=results[first : first + many])
        return results.reshape(*several, n_outputs, n)

    @cached_property
    def _scaled_density(self) -> FloatArray:
        """The density up to half the rate of the rows, times the factors of the transforms."""
        scaled = np.zeros((len(self.density), self.record.n_rows // 2 + 1))
        scaled[:, : self.record.n_bins] = self.density / (self.record.n_rows * self.record.n_extended)
        return scaled

    def adjoint(self, rows: FloatArray) -> ComplexArray:
        """The adjoint of `rows`, up to a factor, applied to weighted rows of shape (n_outputs, n_rows)."""
        weighted = self.record.rows(self.record.from_grid(rows) * self.density)
        return self.record.from_grid(weighted * self.window) * self.record.taper

    def projected(self, rows: FloatArray, beginning: FloatArray) -> FloatArray:
        """Kept weighted rows orthogonal to unknown initial states; from (..., n_outputs, n_rows) to (..., n).

        `beginning`, of shape (n_starts, n_outputs, n_rows), holds the contributions of a state at the start of the log.
        """
        found = self.flat(rows)
        several, begins = np.atleast_2d(found), len(beginning)
        if self._begun.get("rows") is beginning:  # one step of a fit asks several times
            _take_away(several, self._basis)
        else:  # one pass over the basis, which is large after many rests
            both = _take_away(np.concatenate([self.flat(beginning), several]), self._basis)
            self._begun.update(rows=beginning, basis=_orthonormal(both[:begins]))
            several[:] = both[begins:]
        _take_away(several, self._begun["basis"])
        return found

    def flat(self, rows: FloatArray) -> FloatArray:
        """Kept rows, concatenated over the outputs, of shape (..., n_outputs * n_kept)."""
        kept = rows.take(self._places, axis=-1)
        return kept.reshape(*rows.shape[:-2], kept.shape[-2] * kept.shape[-1])

    def released(self) -> Weighting:
        """The weighting without cached arrays, which are recomputed on demand."""
        return replace(self)

    @property
    def restarts(self) -> FloatArray:
        """Contributions of unknown states after rests to the rows, of shape (n_restarts, n_outputs, n_rows)."""
        # After each rest the hidden motion starts from an unknown state, as friction held it in an unknown place.
        # Pulses at the start of each run of kept rows span these states; errors are projected orthogonal to them.
        begins = np.flatnonzero(np.diff(self.kept.astype(np.int8)) == 1)[:_MOST_STARTS] + 1
        return self.rows(starting_pulses(self.record, self.unknown, self.record.row_time[begins]))

    @cached_property
    def _places(self) -> IntArray:
        return np.flatnonzero(self.kept)

    @cached_property
    def _basis(self) -> FloatArray:
        """Orthonormal basis of the restarts in the kept rows."""
        return _orthonormal(self.flat(self.restarts))


def weighting_of(
    record: Record, density: FloatArray, speeds: Iterable[FloatArray], allowed: BoolArray | None = None
) -> Weighting:
    """Weighting of a record where the joints with the given `speeds`, each of shape (n_fine,), move.

    `density` is 1 / sqrt(S) of shape (n_outputs, n_bins), as in `noise_weights`; `allowed` are the parts that may be
    used.
    """
    moving = record.in_log & (True if allowed is None else allowed)
    step = record.fine_time[1]
    resolution = min(_RESOLUTIONS / record.band_hz, _LONGEST_MARGIN)
    for speed in speeds:
        long = round(max(_SHORTEST_REST, resolution) / step)
        moving &= ~_rests(np.abs(speed), record.moves(np.abs(speed)), long, round(resolution / step))
    ringing = min(_END_OF_BAND / record.band_hz, _MOST_OF_LOG * record.duration)
    ends = max(1, round(max(_END, ringing) / step))
    moving[:ends] = False
    last = int(np.flatnonzero(record.in_log)[-1])
    moving[last - ends :] = False
    window = _window(moving, round(resolution / step), max(2, round(_TAPER / step)))[:: record.fine_per_row]
    kept = np.asarray(window > 1 - 1e-9)
    return Weighting(record, window, kept, density, allowed)


def with_restarts(weighting: Weighting, hidden: Sequence[ComplexArray]) -> Weighting:
    """The weighting with unknown states of hidden motion after each rest, where friction may have held it anywhere.

    `hidden` are outputs, of shape (n_outputs, n_bins), for forces on hidden motion.
    """
    return replace(weighting, unknown=tuple(hidden))


def starting_pulses(
    record: Record, hidden: Sequence[ComplexArray], times: FloatArray | tuple[float, ...] = (0.0,)
) -> ComplexArray:
    """Outputs for short pulses of force and their rates, which produce any state; shape (n, n_outputs, n_bins)."""
    pulses = pulse_spectra(record, times)
    found = np.zeros((len(hidden), len(pulses), *record.measured.shape), dtype=complex)
    for i, outputs in enumerate(hidden):
        np.multiply(pulses[:, None, :], outputs, out=found[i])
    return found.reshape(-1, *record.measured.shape)


def pulse_spectra(record: Record, times: FloatArray | tuple[float, ...] = (0.0,)) -> ComplexArray:
    """Spectra of short pulses of force and of their rates, alternating, of shape (2 n_times, n_bins)."""
    moments = np.asarray(times, dtype=np.float64)

    def pulses() -> ComplexArray:
        s = 1j * record.omega
        short = np.exp(-2 * (record.omega / record.omega[-1]) ** 2)
        forces = short * np.exp(np.multiply.outer(-moments, s))
        return np.stack([forces, s * forces], axis=1).reshape(-1, s.size)

    return record.memory.of(("pulses", moments.size), moments.tobytes(), pulses)


def _take_away(rows: FloatArray, basis: FloatArray) -> FloatArray:
    """The rows, in place, less their parts in an orthonormal basis."""
    for first in range(0, len(rows), _TOGETHER):
        some = rows[first : first + _TOGETHER]
        some -= (some @ basis) @ basis.T
    return rows


def _orthonormal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of columns, given as rows; negligible columns are left out."""
    norms = np.linalg.norm(columns, axis=1)
    seen = norms > _UNSEEN * norms.max(initial=0.0)
    basis = columns[seen] / norms[seen, None]
    gram = basis @ basis.T
    try:  # Cholesky factors of the Gram matrix, twice at most: a quarter of the time of QR where rows are many
        for _ in range(2):
            basis = np.linalg.inv(np.linalg.cholesky(gram)) @ basis
            gram = basis @ basis.T
            if np.abs(gram - np.eye(len(basis))).max(initial=0.0) < _ORTHONORMAL:
                return np.asarray(basis.T)
    except np.linalg.LinAlgError:
        pass  # columns that depend on each other to half the digits
    return np.asarray(np.linalg.qr((columns[seen] / norms[seen, None]).T)[0])


def _rests(speed: FloatArray, moves: BoolArray, long: int, short: int) -> BoolArray:
    """Points of rests: of those with at least a `long` length, and of shorter ones in which the axis sticks.

    A reversal passes through the slow points at the slopes with which the speed falls before and rises after them. An
    axis that is slow for `_LONGER` times as long sticks: friction then balances the force, and has not its level.
    """
    slow = np.concatenate([[False], ~moves, [False]])
    first, last = np.flatnonzero(slow[1:] & ~slow[:-1]), np.flatnonzero(slow[:-1] & ~slow[1:]) - 1
    before, after = np.maximum(first - 1, 0), np.minimum(last + 1, speed.size - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        passing = speed[first] / (speed[before] - speed[first]) + speed[last] / (speed[after] - speed[last])
    length = last - first + 1
    sticks = (length >= short) & (length - 1 > _LONGER * passing)
    rests = np.zeros(speed.size, dtype=bool)
    for k in np.flatnonzero((length >= long) | sticks):
        rests[first[k] : last[k] + 1] = True
    return rests


def _window(moving: BoolArray, margin: int, taper: int) -> FloatArray:
    """1 where all points within the margin and the taper move; cosine flanks inside the margin."""
    resting = np.flatnonzero(~moving)
    distance = scipy.ndimage.distance_transform_edt(moving) if resting.size else np.full(moving.size, np.inf)
    rise = np.clip((np.asarray(distance) - margin) / taper, 0, 1)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * rise))
