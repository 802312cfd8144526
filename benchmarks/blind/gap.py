"""How far a plant's motion is from its plain model, in multiples of what noise alone would leave.

The gap-to-noise ratio of a case, from the motions of its validation log as they were before noise and rounding:

1. Each force equation of the plain axis is fitted to them by least squares, as drive force = sum of columns: with one
   position measured the hidden body enters through its own second-order filter, whose two coefficients are fitted too.
   direct_2m1s: F = Mm (q2'' + q1'') + Fvm q2' + Fsm sign(q2'), with q1'' = c s^2/(s^2 + d s + w^2) q2'' by that
   filter, or from the accelerometer. ballscrew_2m1s: F = Mm qm'' + Fvm qm' + Fsm sign(qm') + filter; with the load
   measured, the spring and the load instead. A second sensor adds a second equation: the structure's acceleration from
   the motor's by the filter, and the load driven through the spring.
2. Everything passes a zero-phase low-pass filter of 100 Hz. Samples within 20 ms of standstill (|v| < 2 mm/s) are left
   out. The rms error that remains is the missing force that no parameter can stand for.
3. The noise of the sensors passes through the same columns with the same coefficients, plus the noise of the force: its
   rms over the same samples is the in-band noise. With two equations the larger ratio counts.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import bilinear, butter, lfilter, sosfiltfilt

RATE, BAND_HZ, KEEP = 4000, 100, 8
_LOW = butter(4, BAND_HZ, fs=RATE, output="sos")

Signals = dict[str, np.ndarray]


@dataclass(frozen=True)
class Equation:
    """y = columns @ parameters; `hidden` are columns that pass 1/(s^2 + d s + w^2) first, or `carried` s^2/(...).

    There are as many coefficients as the axis has parameters: one more could stand for what no parameter can, as free
    factors of v and a behind a filter stand for a delay.
    """

    y: str
    columns: tuple[str, ...]
    sign: str | None = None
    hidden: tuple[str, ...] = ()
    carried: tuple[str, ...] = ()


def equations(axis: str, sensors: tuple[str, ...], true: dict[str, float]) -> list[Equation]:
    """The equations of an axis with these sensors; the names are those of `_differentiated`."""
    if axis == "rigid_1m":
        return [Equation("F", ("q.a", "q.v"), "q.v")]
    if axis == "direct_2m1s" and len(sensors) == 1:
        return [Equation("F", ("q2.a", "q2.v"), "q2.v", carried=("q2.a",))]
    if axis == "direct_2m1s":
        drive = Equation("F", ("q2.a", "q2.v", "ddq1"), "q2.v")
        return [drive, Equation("ddq1", (), carried=("q2.a",))]
    if len(sensors) == 1:
        return [Equation("F", ("qm.a", "qm.v"), "qm.v", ("qm.v", "qm.a"))]
    through = ("stretch", "stretch.v")
    load = Equation("ql.a", (*through, "ql.v"))
    return [Equation("F", ("qm.a", "qm.v", *through), "qm.v"), load]


def start(axis: str, true: dict[str, float]) -> tuple[float, float] | None:
    """Log of the frequency (rad/s) and of the damping ratio of the hidden body."""
    if axis == "rigid_1m":
        return None
    mass = true["Mm"] + true["Ms"] if axis == "direct_2m1s" else true["Ml"]
    stiffness, damping = (
        (true["Ks"], true["Fvs"]) if axis == "direct_2m1s" else (true["Kt"], true["Ft"] + true["Fvl"])
    )
    w = np.sqrt(stiffness / mass)
    return float(np.log(w)), float(np.log(damping / mass / 2 / w))


def differentiated(signals: Signals) -> Signals:
    """Low-passed signals with velocities `.v` and accelerations `.a` of the positions, and the stretch of the screw."""
    found = {}
    if "ql" in signals:
        signals = signals | {"stretch": signals["qm"] - signals["ql"]}
    for name, values in signals.items():
        x = sosfiltfilt(_LOW, values)
        found[name] = x
        if name.startswith("q") or name == "stretch":
            found[name + ".v"] = np.gradient(x) * RATE
            found[name + ".a"] = np.gradient(found[name + ".v"]) * RATE
    return found


def ratio(axis: str, true: dict[str, float], clean: Signals, noise: Signals, moving: np.ndarray) -> float:
    """The gap-to-noise ratio; `moving`: velocity of the motor at each sample, free of noise."""
    signals, rows = _prepared(clean, moving)
    disturbed = differentiated(noise) | {"sign": np.zeros(moving.size)}
    return max(
        _one(equation, start(axis, true), signals, disturbed, rows)
        for equation in equations(axis, _sensors(clean), true)
    )


def missing_force(
    axis: str, true: dict[str, float], fitted: tuple[Signals, np.ndarray], checked: tuple[Signals, np.ndarray]
) -> float:
    """Rms force error, N, that the plain axis fitted to one log leaves on another; each: signals, velocity."""
    equation = equations(axis, _sensors(fitted[0]), true)[0]
    shape, X, _ = _fit(equation, start(axis, true), *_prepared(*fitted))
    signals, rows = _prepared(*checked)
    error = signals[equation.y] - _columns(equation, signals, shape) @ X
    return float(np.sqrt(np.mean(error[rows] ** 2)))


def _sensors(signals: Signals) -> tuple[str, ...]:
    return tuple(name for name in signals if name != "F")


def _prepared(clean: Signals, moving: np.ndarray) -> tuple[Signals, np.ndarray]:
    """Signals as the equations name them, and the rows that count."""
    keep = ~_near_standstill(moving)
    keep[: RATE // 10] = keep[-RATE // 10 :] = False
    signals = differentiated(clean) | {"sign": sosfiltfilt(_LOW, np.sign(moving))}
    return signals, np.flatnonzero(keep)[::KEEP]


def _near_standstill(velocity: np.ndarray, margin: int = RATE // 50) -> np.ndarray:
    near = (np.abs(velocity) < 2e-3).astype(float)
    return np.convolve(near, np.ones(2 * margin + 1), "same") > 0.5


def _one(
    equation: Equation, mode: tuple[float, float] | None, signals: Signals, noise: Signals, rows: np.ndarray
) -> float:
    shape, X, error = _fit(equation, mode, signals, rows)
    left = (noise[equation.y] - _columns(equation, noise, shape) @ X)[rows]
    return float(np.sqrt(np.mean(error**2) / np.mean(left**2)))


def _columns(equation: Equation, source: Signals, shape: np.ndarray) -> np.ndarray:
    plain = [source[name] for name in equation.columns] + ([source["sign"]] if equation.sign else [])
    plain += [_through_mode(source[name], shape, [1]) for name in equation.hidden]
    plain += [_through_mode(source[name], shape, [1, 0, 0]) for name in equation.carried]
    return np.stack(plain, axis=1)


def _fit(
    equation: Equation, mode: tuple[float, float] | None, signals: Signals, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shape of the hidden filter, coefficients and error."""

    def fit(shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        W, y = _columns(equation, signals, shape)[rows], signals[equation.y][rows]
        norm = np.linalg.norm(W, axis=0)
        X = np.linalg.lstsq(W / norm, y, rcond=1e-12)[0] / norm
        return y - W @ X, X

    filtered = equation.hidden or equation.carried
    shape = np.array(mode if mode and filtered else (0.0, 0.0))
    if filtered:
        scale = np.std(signals[equation.y][rows])
        shape = least_squares(lambda s: fit(s)[0] / scale, shape, x_scale=(0.05, 0.5), max_nfev=12).x
    error, X = fit(shape)
    return shape, X, error


def _through_mode(x: np.ndarray, shape: np.ndarray, numerator: list[float]) -> np.ndarray:
    """x through numerator/(s^2 + 2 D w s + w^2), from rest."""
    w, damping = np.exp(np.clip(shape, -8, 9))
    b, a = bilinear(
        np.multiply(numerator, w**2 if len(numerator) == 1 else 1.0), [1, 2 * damping * w, w**2], RATE
    )
    return lfilter(b, a, x)
