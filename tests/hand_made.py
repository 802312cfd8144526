"""Logs of one mass written by hand: motion as a sum of sines, so that every derivative and every force is exact."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from symid import Log

RATE = 2000.0
RIGID = {"M": 100.0, "Fv": 150.0, "Fs": 8.0}
QUIET = {"F": 2.0, "q": 2e-8}
"""Standard deviations of noise, N and m."""


@dataclass(frozen=True)
class Sines:
    """q = sum of A sin(w t + phase)."""

    amplitudes: np.ndarray
    frequencies: np.ndarray
    phases: np.ndarray

    def at(self, time: np.ndarray, order: int = 0, response: Callable | None = None) -> np.ndarray:
        """Derivative of an order, or the steady response of a transfer function of s."""
        w = 2 * np.pi * self.frequencies
        gain = (1j * w) ** order if response is None else response(1j * w)
        arguments = (np.asarray(values, dtype=float).tobytes() for values in (w, self.phases, time))
        return np.imag((self.amplitudes * gain) @ _turning(*arguments))


@lru_cache(maxsize=8)  # takes longer than all else of a log, whose derivatives have it in common
def _turning(w: bytes, phases: bytes, time: bytes) -> np.ndarray:
    """Waves of unit amplitude, one a row, of angular frequencies, phases and times."""
    w, phases, time = (np.frombuffer(values) for values in (w, phases, time))
    return np.exp(1j * (np.outer(w, time) + phases[:, None]))


def motion(seed: int) -> Sines:
    """Strokes of 0.1 m with faster, smaller motion up to 20 Hz on them."""
    rng = np.random.default_rng(seed)
    frequencies = np.concatenate([rng.uniform(0.25, 0.4, 2), rng.uniform(1, 3, 3), np.geomspace(5, 20, 8)])
    amplitudes = np.concatenate([[0.08, 0.04], np.full(3, 4e-3), 0.6 / (2 * np.pi * frequencies[5:]) ** 2])
    return Sines(amplitudes, frequencies, rng.uniform(0, 2 * np.pi, frequencies.size))


def rigid_log(
    missing: Callable | None = None, *, seconds: float = 6.0, seed: int = 1, noise: dict[str, float] = QUIET
) -> Log:
    """A log of `RIGID` with a missing force of (t, q, v, a, path), which may also be a later force: (M a + ...)(t)."""
    t, path = np.arange(round(seconds * RATE)) / RATE, motion(seed)
    rng = np.random.default_rng([seed, 9])
    force = plain_force(path, t)
    if missing is not None:
        force = force + missing(t, path.at(t), path.at(t, 1), path.at(t, 2), path)
    return Log(
        "by hand",
        0.0,
        1 / RATE,
        {
            "F": force + noise["F"] * rng.standard_normal(t.size),
            "q": path.at(t) + noise["q"] * rng.standard_normal(t.size),
        },
    )


def plain_force(path: Sines, t: np.ndarray) -> np.ndarray:
    """Force of the axis as it is declared."""
    v = path.at(t, 1)
    return RIGID["M"] * path.at(t, 2) + RIGID["Fv"] * v + RIGID["Fs"] * np.sign(v)


def hung(path, t):
    """What 30 kg on a spring of 12 Hz and 5 % damping pull with beyond being carried along."""
    m, w, D = 30.0, 2 * np.pi * 12.0, 0.05

    def pull(s):
        return m * s**2 * (2 * D * w * s + w**2) / (s**2 + 2 * D * w * s + w**2) - m * s**2

    return path.at(t, response=pull)
