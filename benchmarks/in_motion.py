"""Logs that begin and end in motion: is symid right where filters do not start from rest?

First 24 logs of 4 s of one sine of 5 to 20 rad/s at 1 kHz, of a rigid axis. Then random logs of known truth as in
`benchmarks.ok_promise`, cut at both ends, in turn with sines, pairs of sines, multisines and chirps that begin and end
in motion, at 0.25 to 10 kHz, of rigid and flexible axes.

Usage: python -m benchmarks.in_motion [--logs 60] [--seed 1]
"""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.ok_promise import Outcome, outcome_of, show, summary, table
from benchmarks.options import parser_of
from benchmarks.promise.machines import (
    FORCE,
    RATES,
    SENSORS,
    SHARES,
    Case,
    clean_signals,
    draw_case,
    draw_noise,
    draw_truth,
    with_noise,
)
from benchmarks.promise.motions import Motion

SECONDS, SETTLED = 4, 2
"""Length of a log, and what is left out before it, so that a mode is in motion too."""


def sines() -> Iterator[Case]:
    """24 logs of a rigid axis that follows one sine."""
    t = np.arange(4000) / 1000
    for k, w in enumerate(np.linspace(5.0, 20.0, 24)):
        q, v, a = np.sin(w * t), w * np.cos(w * t), -w * w * np.sin(w * t)
        force = 5.0 * a + v + 2.0 * np.sign(v) + 0.05 * np.random.default_rng(k).standard_normal(t.size)
        yield Case("rigid_1m", {"M": 5.0, "Fv": 1.0, "Fs": 2.0}, {"q": q, "F": force}, 1000, "one sine")


def harmonic(n: int, rng: np.random.Generator) -> Motion:
    """A sum of n sines: up to two of 5 to 20 rad/s, more as multiples of 3 to 5 rad/s."""
    few = n <= 2
    w = rng.uniform(5, 20, n) if few else rng.uniform(3, 5) * np.arange(1, n + 1)
    size = rng.uniform(0.05, 1, n) if few else 1.0 / np.arange(1, n + 1) ** 2
    phase = rng.uniform(0, 2 * np.pi, n)

    def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        angle = t[:, None] * w + phase
        q, v = np.sin(angle) @ size, np.cos(angle) @ (size * w)
        return q, v, -np.sin(angle) @ (size * w * w)

    return motion


def chirp(rng: np.random.Generator) -> Motion:
    """0.1 m at a frequency that rises evenly from 3 to 8 rad/s to 20 to 60 rad/s."""
    first, last, phase = rng.uniform(3, 8), rng.uniform(20, 60), rng.uniform(0, 2 * np.pi)
    rise = (last - first) / (SECONDS + SETTLED)

    def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        w, angle = first + rise * t, first * t + rise * t * t / 2 + phase
        return (
            0.1 * np.sin(angle),
            0.1 * w * np.cos(angle),
            0.1 * (rise * np.cos(angle) - w * w * np.sin(angle)),
        )

    return motion


def moving(kind: str, axis: str, rng: np.random.Generator) -> Case:
    """A log of an axis that follows a motion of a kind all the time."""
    motion = (
        chirp(rng) if kind == "chirp" else harmonic({"sine": 1, "two sines": 2, "multisine": 8}[kind], rng)
    )
    measured = SENSORS[axis][rng.integers(len(SENSORS[axis]))]
    rate = int(rng.choice(RATES))
    mode = None if axis == "rigid_1m" else rng.uniform(3, 8)
    truth = draw_truth(axis, mode, motion, rng)
    clean = clean_signals(axis, rate, SECONDS + SETTLED, motion, truth, rng)
    signals = {name: clean[name][SETTLED * rate :] for name in (*measured, FORCE[axis])}
    case = Case(axis, truth, signals, rate, kind, mode or 0.0)
    noisy = {name: with_noise(x, draw_noise(case, name, rng), rng) for name, x in case.signals.items()}
    return replace(case, signals=noisy)


def cut(rng: np.random.Generator) -> Case:
    """A log of `benchmarks.ok_promise` without a part at each end."""
    case = draw_case(rng)
    n = case.signals[case.force].size
    inside = slice(int(n * rng.uniform(0.1, 0.3)), int(n * rng.uniform(0.75, 0.95)))
    signals = {name: x[inside] for name, x in case.signals.items()}
    return replace(case, signals=signals, motion=f"cut {case.motion}")


def drawn(logs: int, seed: int) -> Iterator[Case]:
    """Random logs; sines and pairs of sines are of rigid axes, since they determine no more."""
    for i in range(logs):
        rng = np.random.default_rng([seed, i])
        if i % 2:
            yield cut(rng)
            continue
        kind = ("sine", "two sines", "multisine", "chirp")[i // 2 % 4]
        determined = list(SHARES) if kind in ("multisine", "chirp") else ["rigid_1m"]
        yield moving(kind, str(rng.choice(determined)), rng)


def outcomes_of(cases: Iterator[Case]) -> list[Outcome]:
    """Outcomes with nothing chosen, each with its processor time."""
    found = []
    for i, case in enumerate(cases):
        begin = time.process_time()
        outcome = outcome_of(case, i, "wls")
        found.append(replace(outcome, seconds=time.process_time() - begin))
    return found


def main() -> None:
    chosen = parser_of(__doc__, logs=60, seed=1).parse_args()
    with threadpool_limits(1):
        for outcomes in (outcomes_of(sines()), outcomes_of(drawn(chosen.logs, chosen.seed))):
            print(summary(outcomes))
            print("\n".join(table(outcomes, "motion", lambda case: case.motion)))
            show(outcomes)


if __name__ == "__main__":
    main()
