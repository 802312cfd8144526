"""Results of a short script on the same logs: filter, differentiate, least squares, without code of symid.

Signals go through a Butterworth low-pass of order 4, forward and backward, with half the power left at the band's end;
derivatives are those of a spline of degree 5 through the filtered positions. Rows are left out where the speed is below
1 % of the log's greatest, half a period of the band's end (at most 20 ms) around these and around reversals, and 50 ms
at the ends. A model is a sum of columns fitted by least squares on the training logs; the frequency and damping of a
mode are found by a search, the load of a load-dependent friction by repetition. Errors are those of the force on the
log that was held out, after the same filter.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate, ndimage, optimize, signal

from .recordings import FloatArray, Recording

GRAVITY = 9.80665
MODE = "mode"
LOAD = "load-dependent"
_ORDER = 4
_SLOW_SHARE = 0.01
_MARGIN = 0.020
_END = 0.050
_DAMPING = (0.01, 0.05, 0.2)
_REPETITIONS = 8
Values = dict[str, float]
Shape = tuple[float, float]
"""Frequency in Hz and damping of a mode; inertia and weight of the load of a friction."""


@dataclass(frozen=True)
class Script:
    """Model that the script fits."""

    # force, position: signals
    force: str
    position: str
    base: tuple[str, ...]  # columns of the model as the case declares it, see `columns_of`
    # columns of the one published effect that helps most; none where nothing is published
    added: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Motion:
    """A recording in a band, with derivatives."""

    recording: Recording  # the run
    script: Script  # names the signals
    band: float  # Hz

    def low_passed(self, x: FloatArray) -> FloatArray:
        return low_passed(x, self.recording.period, self.band)

    @cached_property
    def time(self) -> FloatArray:
        """Since the first sample, s."""
        steps = np.arange(self.recording[self.script.force].size, dtype=np.float64)
        return np.asarray(self.recording.period * steps, dtype=np.float64)

    @cached_property
    def force(self) -> FloatArray:
        return self.low_passed(self.recording[self.script.force])

    @cached_property
    def derivatives(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity, acceleration."""
        q = self.low_passed(self.recording[self.script.position])
        spline = interpolate.make_interp_spline(self.time, q, k=5)
        return q, spline.derivative()(self.time), spline.derivative(2)(self.time)

    @cached_property
    def rows(self) -> NDArray[np.bool_]:
        """Where the axis moves."""
        v = self.derivatives[1]
        turns = np.append(np.diff(np.sign(v)) != 0, False)
        rest = (np.abs(v) < _SLOW_SHARE * np.abs(v).max()) | turns
        margin = min(_MARGIN, 0.5 / self.band)
        rest = ndimage.binary_dilation(rest, iterations=max(round(margin / self.recording.period), 1))
        end = round(_END / self.recording.period) + 1
        rest[:end] = rest[-end:] = True
        return ~rest


def low_passed(x: FloatArray, period: float, band: float) -> FloatArray:
    share = 2.0 * period * band / (np.sqrt(2.0) - 1.0) ** (0.5 / _ORDER)
    if share > 0.98:
        return x
    return np.array(signal.sosfiltfilt(signal.butter(_ORDER, share, output="sos"), x), dtype=np.float64)


def columns_of(motion: Motion, name: str, shape: Shape | None = None) -> dict[str, FloatArray]:
    """Columns of one name: a law of q, v and a; ``cogging N`` of N waves a turn; those that need a shape."""
    q, v, a = motion.derivatives
    if name == MODE and shape:
        return {MODE: hidden_mass(a, motion.recording.period, shape) - a}
    if name == LOAD and shape:
        return {LOAD: np.abs(shape[0] * a + shape[1] * GRAVITY * np.sin(q)) * np.sign(v)}
    if name.startswith("cogging"):
        waves = int(name.split()[1])
        return {f"{name} sin": np.sin(waves * q), f"{name} cos": np.cos(waves * q)}
    laws = {
        "inertia": a,
        "weight": GRAVITY * np.sin(q),
        "viscous": v,
        "coulomb": np.sign(v),
        "asymmetry": np.abs(v),
        "offset": np.ones_like(q),
    }
    return {name: laws[name]}


def hidden_mass(a: FloatArray, period: float, shape: Shape) -> FloatArray:
    """Acceleration of a mass on a spring and a damper whose other end has the acceleration `a`, at rest at first."""
    omega, damping = 2.0 * np.pi * shape[0], shape[1]
    rate = omega / np.tan(0.5 * omega * period)
    b, c = signal.bilinear(
        [2.0 * damping * omega, omega**2], [1.0, 2.0 * damping * omega, omega**2], rate / 2
    )
    return np.asarray(signal.lfilter(b, c, a))


def matrix(motion: Motion, names: Sequence[str], shape: Shape | None) -> tuple[list[str], FloatArray]:
    """Names of all columns, and the columns."""
    columns: dict[str, FloatArray] = {}
    for name in names:
        columns |= columns_of(motion, name, shape)
    return list(columns), np.stack(list(columns.values()), axis=1)


@dataclass(frozen=True, eq=False)
class Model:
    names: tuple[str, ...]  # what it is made of
    values: Values  # of each column, SI
    shape: Shape | None  # of the mode or the load, if there is one

    def error(self, motion: Motion) -> FloatArray:
        """Measured less predicted force."""
        columns = matrix(motion, self.names, self.shape)[1]
        return np.asarray(motion.force - columns @ np.array(list(self.values.values())))


def fitted(motions: Sequence[Motion], names: Sequence[str]) -> Model:
    """Least squares on some logs; a mode's shape is sought on a grid, then refined; a load is that of the last fit."""
    if LOAD in names:
        found = fitted(motions, [name for name in names if name != LOAD])
        for _ in range(_REPETITIONS):
            load = found.values["inertia"], found.values.get("weight", 0.0)
            found = _with_shape(motions, names, load)[0]
        return found
    if MODE not in names:
        return _with_shape(motions, names, None)[0]

    def cost(logarithms: FloatArray) -> float:
        return _with_shape(motions, names, _shape(logarithms))[1]

    frequencies = np.geomspace(0.1, 0.9, 25) * motions[0].band
    grid = [np.log([f, damping]) for f in frequencies for damping in _DAMPING]
    best = min(grid, key=cost)
    refined = optimize.minimize(cost, best, method="Nelder-Mead", options={"xatol": 1e-4, "maxiter": 120})
    return _with_shape(motions, names, _shape(refined.x))[0]


def _shape(logarithms: FloatArray) -> Shape:
    frequency, damping = np.exp(logarithms)
    return float(frequency), float(damping)


def _with_shape(motions: Sequence[Motion], names: Sequence[str], shape: Shape | None) -> tuple[Model, float]:
    parts = [matrix(motion, names, shape) for motion in motions]
    columns = np.concatenate([x[motion.rows] for (_, x), motion in zip(parts, motions, strict=True)])
    force = np.concatenate([motion.force[motion.rows] for motion in motions])
    scale = np.linalg.norm(columns, axis=0)
    solution = np.linalg.lstsq(columns / scale, force, rcond=None)[0] / scale
    values = dict(zip(parts[0][0], map(float, solution), strict=True))
    return Model(tuple(names), values, shape), float(np.linalg.norm(force - columns @ solution))


@dataclass(frozen=True)
class Error:
    """Force error on the held-out log: root mean square, and relative to that of the force."""

    rms: float
    relative: float


@dataclass(frozen=True, eq=False)
class Plain:
    # before, after: of the base model, and with the published effect
    before: Error
    after: Error
    # base, best: both
    base: Model
    best: Model
    motion: Motion  # the held-out log in the band

    @property
    def removed(self) -> float:
        """Share of the mean squared error that the effect removes on the held-out log."""
        return 1.0 - (self.after.rms / self.before.rms) ** 2


def plain(script: Script, training: Sequence[Recording], held_out: Recording, band: float) -> Plain:
    """Fit the base model and that with the published effect on some logs, and measure both on another.

    Parameters
    ----------
    script : Script
        What to fit.
    training : sequence of Recording
        Logs.
    held_out : Recording
        The log for the errors.
    band : float
        Highest frequency that counts, Hz.
    """
    motions, other = [Motion(run, script, band) for run in training], Motion(held_out, script, band)
    base = fitted(motions, script.base)
    best = fitted(motions, (*script.base, *script.added)) if script.added else base
    return Plain(
        before=_measured(base, other), after=_measured(best, other), base=base, best=best, motion=other
    )


def _measured(model: Model, motion: Motion) -> Error:
    error, force = model.error(motion)[motion.rows], motion.force[motion.rows]
    rms = float(np.sqrt(np.mean(error**2)))
    return Error(rms, rms / float(np.sqrt(np.mean(force**2))))
