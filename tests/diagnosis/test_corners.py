"""Reversals of motion with friction that is known up to a frequency only, against the motion that was cut off."""

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.prediction.corners import reversals_of, with_corners

N_POINTS, HALF, STOPS, STARTS = 8000, 193.7, 3.0, 1.0
"""Points of a period, points from one reversal to the next, and slopes of the speed before and behind it."""


def speeds(noise: float = 0.0, stops: float = STOPS) -> tuple[FloatArray, FloatArray, float]:
    """A velocity that rises by one slope and falls by another, cut off at a frequency, and its reversals."""
    fine = np.arange(64 * N_POINTS) / 64
    cycle, way = np.divmod(fine, HALF)
    rise = np.minimum(STARTS * way, stops * (HALF - way)) * np.where(cycle % 2, -1.0, 1.0)
    rise[cycle == cycle[-1]] = 0.0
    spectrum = np.fft.rfft(rise) / 64
    kept = N_POINTS // 16
    highest = 2 * np.pi * kept / N_POINTS
    noises = (
        np.random.default_rng(4).normal(0.0, noise * np.sqrt(N_POINTS), (2, kept))
        if noise
        else np.zeros((2, kept))
    )
    cut = np.fft.irfft(spectrum[:kept] + noises[0] + 1j * noises[1], N_POINTS)
    return cut, HALF * np.arange(1, int(cycle[-1])), highest


def off(places: FloatArray, true: FloatArray) -> FloatArray:
    return np.asarray([float(places[np.argmin(np.abs(places - one))] - one) for one in true])


def test_reversals_stay_where_the_motion_has_them() -> None:
    cut, true, highest = speeds()
    rounded, sharp = reversals_of(cut), with_corners(cut, highest, np.abs(cut) > 2.0)
    late = off(rounded.before + rounded.passed, true)
    assert late.min() > 0.8
    assert np.abs(off(sharp.before + sharp.passed, true)).max() < 0.1 * late.mean()
    before, behind = np.floor(true).astype(int) - 1, np.ceil(true).astype(int) + 1
    assert np.abs(np.abs(sharp.velocity[before]) - STOPS * (true - before)).max() < 0.25
    assert np.abs(np.abs(sharp.velocity[behind]) - STARTS * (behind - true)).max() < 0.25


def test_noise_does_not_move_reversals_to_one_side() -> None:
    cut, true, highest = speeds(noise=0.3)
    sharp = with_corners(cut, highest, np.abs(cut) > 2.0)
    shifts = off(sharp.before + sharp.passed, true)
    assert abs(shifts.mean()) < 3 * shifts.std() / np.sqrt(shifts.size) + 0.05


def test_motion_without_corners_stays_as_it_is() -> None:
    cut, _, highest = speeds(stops=STARTS)
    assert np.array_equal(with_corners(cut, highest, np.abs(cut) > 2.0).velocity, cut)
    still = np.zeros(200)
    assert not with_corners(still, 1.0, still > 0).before.size


def test_a_rest_between_two_motions_is_no_reversal() -> None:
    cut, true, highest = speeds()
    dwell = np.full(60, 0.5)
    parts = np.split(cut, np.round(true).astype(int))
    rested = np.concatenate(
        [piece for part in parts for piece in (part, dwell * np.sign(part[-1] + part[-2]))]
    )
    found = with_corners(rested, highest, np.abs(rested) > 2.0)
    assert np.array_equal(found.velocity, rested)
