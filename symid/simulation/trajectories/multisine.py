"""Periodic references with power at chosen frequencies only."""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray, read_only
from symid.errors import SettingError
from symid.simulation.trajectories.limits import MOST_SAMPLES, Limits, checked_positive, faded, intervals
from symid.simulation.trajectories.trajectory import Trajectory

MotionQuantity = Literal["position", "velocity", "acceleration"]
"""Quantity to which an amplitude refers."""

DERIVATIVE_ORDER: Final[dict[str, int]] = {"position": 0, "velocity": 1, "acceleration": 2}
_FINEST: Final = 1_000_000  # largest denominator of a frequency in Hz
_LONGEST_PERIOD: Final = 500_000  # samples
_FADES: Final = 10  # a fade is this part of the duration


@dataclass(frozen=True, eq=False, kw_only=True)
class Multisine(Trajectory):
    """A multisine: a trajectory that is periodic between its fades."""

    quantity: MotionQuantity  # quantity of the amplitudes: position, velocity or acceleration
    # frequencies, amplitudes, phases: shape (n_lines,): lines of the spectrum, Hz; their amplitudes, SI; the
    # phases of their cosines at the beginning of the first period with full amplitude, rad
    frequencies: FloatArray
    amplitudes: FloatArray
    phases: FloatArray
    period: int  # samples of one period
    # first sample with full amplitude, and the sample after the last: whole periods, whose discrete Fourier
    # transform is zero except at the lines
    steady: tuple[int, int]

    def __post_init__(self) -> None:
        super().__post_init__()
        for kind in ("frequencies", "amplitudes", "phases"):
            object.__setattr__(self, kind, read_only(getattr(self, kind)))


def frequency_lines(lowest: float, highest: float, step: float) -> FloatArray:
    """Evenly spaced frequencies from `lowest` to at most `highest`, Hz.

    Parameters
    ----------
    lowest, highest, step : float
        Limits and distance of the frequencies, Hz.

    Raises
    ------
    SettingError
        If a frequency is not positive or the highest is below the lowest.

    Examples
    --------
    >>> frequency_lines(1.0, 2.0, 0.25).tolist()
    [1.0, 1.25, 1.5, 1.75, 2.0]
    """
    for value, what in ((lowest, "lowest frequency"), (step, "step of frequencies")):
        checked_positive(value, what, "Hz")
    if not lowest <= highest < math.inf:
        raise SettingError(f"no frequencies lie from {lowest:g} Hz to {highest:g} Hz: give the lowest first")
    count = math.floor((highest - lowest) / step + 1e-9) + 1
    return lowest + step * np.arange(count, dtype=np.float64)


def multisine(
    frequencies: npt.ArrayLike,
    amplitude: npt.ArrayLike,
    *,
    sampling_period: float,
    quantity: MotionQuantity = "velocity",
    periods: int = 1,
    seconds: float | None = None,
    rng: np.random.Generator | None = None,
    fade: float | None = None,
    centre: float = 0.0,
    limits: Limits | None = None,
) -> Multisine:
    """Sum of sines about a position, periodic between a fade-in and a fade-out.

    Position, velocity and acceleration are synthesised from one spectrum: each is the exact derivative of the one
    before. A period is the shortest time with whole cycles of every line and whole samples.

    Parameters
    ----------
    frequencies : array_like of shape (n_lines,)
        Lines, Hz, ascending; see `frequency_lines`.
    amplitude : float or array_like of shape (n_lines,)
        Amplitude of every line, or of each, in SI units of `quantity`.
    sampling_period : float
        Time between two samples, s.
    quantity : {"position", "velocity", "acceleration"}
        Quantity of the amplitudes.
    periods : int
        Periods with full amplitude.
    seconds : float, optional
        Least time with full amplitude, s, instead of `periods`; rounded up to whole periods.
    rng : numpy.random.Generator, optional
        Draws phases at random; without it they are Schroeder's, which keep the crest factor low.
    fade : float, optional
        Duration of the fade-in and of the fade-out, s: one period if not given. With 0 the trajectory is
        whole periods only, and neither begins nor ends at rest.
    centre : float
        Mean position, m or rad; a faded trajectory begins and ends there.
    limits : Limits, optional
        Limits of the axis, which all samples must keep.

    Raises
    ------
    SettingError
        If the lines have no common period, reach half the sampling frequency, or exceed the limits.

    Examples
    --------
    >>> shaking = multisine(frequency_lines(1.0, 20.0, 0.5), 0.01, sampling_period=0.001, periods=4)
    >>> shaking.duration, shaking.velocity[[0, -1]].tolist()
    (12.0, [0.0, 0.0])
    """
    if quantity not in DERIVATIVE_ORDER:
        raise SettingError(f"amplitude of {quantity!r} is not known: choose {', '.join(DERIVATIVE_ORDER)}")
    lines, sizes = _lines(frequencies, amplitude, checked_positive(sampling_period, "sampling period", "s"))
    base, period = _common_period(lines, sampling_period)
    if seconds is not None:
        periods = max(1, -(-intervals(seconds, sampling_period, "multisine") // period))
    if periods < 1:
        raise SettingError(f"{periods} periods make no multisine: give 1 or more")
    n_fade = period if fade is None else intervals(fade, sampling_period, "fade")
    n_steady = periods * period
    intervals((n_steady + 2 * n_fade) * sampling_period, sampling_period, "multisine")
    phases = _schroeder(sizes) if rng is None else rng.uniform(0.0, 2.0 * np.pi, lines.size)
    waves = _waves(lines, sizes, phases, quantity, base, period)
    motion = faded(waves, n_steady, n_fade, sampling_period)
    return Multisine(
        position=centre + motion[0],
        velocity=motion[1],
        acceleration=motion[2],
        sampling_period=sampling_period,
        name=f"multisine of {lines.size} lines from {lines[0]:g} to {lines[-1]:g} Hz",
        quantity=quantity,
        frequencies=lines,
        amplitudes=sizes,
        phases=phases,
        period=period,
        steady=(n_fade, n_fade + n_steady),
    ).checked(limits)


def whole_periods(
    frequencies: FloatArray,
    amplitude: float,
    seconds: float,
    rate: float,
    *,
    quantity: MotionQuantity = "velocity",
    rng: np.random.Generator | None = None,
) -> Multisine:
    """Multisine at about these frequencies in a given time: whole periods between fades of a tenth of the time each.

    Lines are rounded to whole cycles of a period that is short enough to keep their frequencies simple fractions.

    Parameters
    ----------
    frequencies : array of shape (n_lines,)
        Wanted frequencies, Hz.
    amplitude : float
        Amplitude of each line in `quantity`, SI.
    seconds : float
        Duration with both fades, s.
    rate : float
        Samples per second, Hz.
    quantity : {"position", "velocity", "acceleration"}
        Quantity of the amplitude.
    rng : numpy.random.Generator, optional
        Draws the phases; those of Schroeder by default.

    Examples
    --------
    >>> shaking = whole_periods(np.array([0.9, 2.6]), 0.01, 5.0, 1000.0)
    >>> shaking.frequencies.tolist(), shaking.duration
    ([1.0, 2.5], 5.0)
    """
    total = max(round(seconds * rate), 1)
    periods = -(-total // _LONGEST_PERIOD)
    period = max((total - 2 * (total // _FADES)) // periods, 1)
    cycles = np.unique(np.round(frequencies * period / rate).clip(1))
    return multisine(
        cycles * rate / period,
        amplitude,
        sampling_period=1.0 / rate,
        quantity=quantity,
        seconds=periods * period / rate,
        fade=(total - periods * period) // 2 / rate,
        rng=rng,
    )


def _lines(
    frequencies: npt.ArrayLike, amplitude: npt.ArrayLike, sampling_period: float
) -> tuple[FloatArray, FloatArray]:
    lines = np.array(frequencies, dtype=np.float64, ndmin=1)
    given = np.asarray(amplitude, dtype=np.float64)
    if lines.ndim != 1 or lines.size == 0 or not (np.isfinite(lines).all() and lines[0] > 0.0):
        raise SettingError("the lines of a multisine must be positive frequencies in Hz: give at least one")
    if (np.diff(lines) <= 0.0).any():
        raise SettingError(
            "the lines of a multisine do not ascend: sort the frequencies and leave out duplicates"
        )
    if lines[-1] * sampling_period >= 0.5:
        raise SettingError(
            f"line at {lines[-1]:g} Hz is not below half the sampling frequency of {1.0 / sampling_period:g} Hz: "
            f"leave it out or sample faster"
        )
    if given.shape not in ((), lines.shape):
        raise SettingError(
            f"amplitudes have shape {given.shape}: give one number, or one for each of the {lines.size} lines"
        )
    if not np.isfinite(given).all() or (given < 0.0).any() or not given.any():
        raise SettingError(
            "amplitudes of a multisine must be finite, 0 or more and not all 0: give such numbers"
        )
    return lines, np.broadcast_to(given, lines.shape).copy()


def _common_period(lines: FloatArray, sampling_period: float) -> tuple[float, int]:
    """Greatest common divisor of the lines and the sampling frequency, Hz, and the samples in its period."""
    exact = [_rational(value) for value in (*lines.tolist(), 1.0 / sampling_period)]
    base = Fraction(math.gcd(*(f.numerator for f in exact)), math.lcm(*(f.denominator for f in exact)))
    period = exact[-1] / base
    if period >= MOST_SAMPLES:
        raise SettingError(
            f"lines of the multisine first repeat together after {float(1 / base):.3g} s, which is too long: choose "
            "multiples of one step, of which the sampling frequency is a multiple too"
        )
    return float(base), int(period)


def _rational(frequency: float) -> Fraction:
    exact = Fraction(frequency).limit_denominator(_FINEST)
    if abs(exact - Fraction(frequency)) > 1e-9 * Fraction(frequency):
        raise SettingError(
            f"{frequency!r} Hz is not a fraction with a denominator up to {_FINEST}, so that a multisine would not "
            "repeat: choose rounder frequencies and sampling period"
        )
    return exact


def _schroeder(amplitudes: FloatArray) -> FloatArray:
    """Phases of Schroeder (1970): -2 pi sum over j < k of (k - j) times the share of line j in the power."""
    power = amplitudes**2 / np.sum(amplitudes**2)
    turns = np.concatenate([[0.0], np.cumsum(np.cumsum(power))[:-1]])
    return np.asarray(-2.0 * np.pi * np.mod(turns, 1.0))


def _waves(
    lines: FloatArray,
    amplitudes: FloatArray,
    phases: FloatArray,
    quantity: MotionQuantity,
    base: float,
    period: int,
) -> FloatArray:
    """One period of position, velocity and acceleration, as rows."""
    omega = 2.0 * np.pi * lines
    spectrum = np.zeros((3, period // 2 + 1), dtype=np.complex128)
    index = np.rint(lines / base).astype(np.intp)
    for order in range(3):
        factor = (1j * omega) ** (order - DERIVATIVE_ORDER[quantity])
        spectrum[order, index] = 0.5 * period * amplitudes * np.exp(1j * phases) * factor
    return np.fft.irfft(spectrum, n=period, axis=1)
