"""Faults of recorders in a log: one of random kind and extent."""

from dataclasses import replace

import numpy as np
import scipy

from benchmarks.draws import log_uniform
from benchmarks.promise.machines import Case


def _spans(n: int, count: int, length: int, rng: np.random.Generator) -> np.ndarray:
    flags = np.zeros(n, dtype=bool)
    for start in rng.integers(0, max(n - length, 1), count):
        flags[start : start + length] = True
    return flags


def zero_filled(x, rng):
    share = rng.uniform(0.01, 0.2)
    return f"{share:.2f}", np.where(rng.random(x.size) < share, 0.0, x)


def held_samples(x, rng):
    share = rng.uniform(0.05, 0.5)
    place = np.maximum.accumulate(np.where(rng.random(x.size) < share, 0, np.arange(x.size)))
    return f"{share:.2f}", x[place]


def zero_bursts(x, rng):
    length = int(rng.uniform(0.002, 0.01) * x.size)
    return f"{length}", np.where(_spans(x.size, int(rng.integers(5, 40)), length, rng), 0.0, x)


def held_bursts(x, rng):
    length = int(rng.uniform(0.002, 0.01) * x.size)
    held = _spans(x.size, int(rng.integers(5, 40)), length, rng)
    return f"{length}", x[np.maximum.accumulate(np.where(held, 0, np.arange(x.size)))]


def clipped(x, rng):
    level = rng.uniform(0.3, 0.9) * np.max(np.abs(x))
    return f"{level / np.max(np.abs(x)):.2f}", np.clip(x, -level, level)


def clipped_then_noise(x, rng):
    level = rng.uniform(0.3, 0.8) * np.max(np.abs(x))
    noise = rng.uniform(0.0005, 0.01) * level * rng.standard_normal(x.size)
    return f"{level / np.max(np.abs(x)):.2f}", np.clip(x, -level, level) + noise


def soft_limit(x, rng):
    level = rng.uniform(0.4, 1.2) * np.max(np.abs(x))
    return f"{level / np.max(np.abs(x)):.2f}", level * np.tanh(x / level)


def slew_limited(x, rng):
    most = np.quantile(np.abs(np.diff(x)), rng.uniform(0.3, 0.95))
    found = np.empty_like(x)
    last = x[0]
    for k, value in enumerate(x):
        last += min(max(value - last, -most), most)
        found[k] = last
    return f"{most:.3g}", found


def half_gain(x, rng):
    share = rng.uniform(0.1, 0.4)
    return f"{share:.2f}", _part_times(0.5, x, share, rng)


def sign_flips(x, rng):
    share = rng.uniform(0.05, 0.3)
    return f"{share:.2f}", _part_times(-1, x, share, rng)


def _part_times(gain, x, share, rng):
    """x with a gain in a part of the log, which is anywhere."""
    start = int(rng.uniform(0, 1 - share) * x.size)
    found = x.copy()
    found[start : start + int(share * x.size)] *= gain
    return found


def quantised(x, rng):
    step = np.max(np.abs(x)) / rng.uniform(3, 60)
    return f"{step / np.max(np.abs(x)):.3f}", np.round(x / step) * step


def truncated(x, rng):
    step = np.max(np.abs(x)) / rng.uniform(3, 60)
    return f"{step / np.max(np.abs(x)):.3f}", np.trunc(x / step) * step


def updated_rarely(x, rng):
    every = int(rng.choice([2, 4, 8, 16]))
    return f"{every}", np.repeat(x[::every], every)[: x.size]


def absolute(x, rng):
    return "", np.abs(x)


def sign(x, rng):
    return "", -x


def int8_overflow(x, rng):
    top = np.max(np.abs(x)) * rng.uniform(0.5, 0.95)
    return "", (np.round(x / top * 127) + 128) % 256 * (top / 127) - 128 * top / 127


def clock_drift(x, rng):
    drift = rng.choice([-1, 1]) * log_uniform(rng, 1e-4, 1e-2)
    k = np.arange(x.size, dtype=float)
    return f"{drift:.1e}", np.interp(k * (1 + drift), k, x)


def lagged(x, rng):
    samples = log_uniform(rng, 1.5, 80)
    a = np.exp(-1 / samples)
    return f"{samples:.1f}", scipy.signal.lfilter([1 - a], [1, -a], x, zi=[a * x[0]])[0]


def smoothed(x, rng):
    n = int(rng.choice([11, 51, 101, 201]))
    return f"{n}", np.convolve(np.pad(x, n // 2, mode="edge"), np.full(n, 1 / n), mode="valid")


def moving_average(x, rng):
    n = int(rng.choice([5, 21, 51, 101]))
    return f"{n}", np.convolve(np.pad(x, (n - 1, 0), mode="edge"), np.full(n, 1 / n), mode="valid")


def spikes(x, rng):
    share = log_uniform(rng, 1e-4, 0.02)
    size = np.max(np.abs(x)) * rng.uniform(1, 5)
    return f"{share:.1e}", x + size * (rng.random(x.size) < share) * rng.choice([-1, 1], x.size)


def interpolated(x, rng):
    every = int(rng.choice([2, 4]))
    k = np.arange(x.size)
    return f"{every}", np.interp(k, k[::every], x[::every])


def noisy(x, rng):
    return "", x + rng.uniform(0.3, 3) * np.std(x) * rng.standard_normal(x.size)


def gain_drift(x, rng):
    return "", x * np.linspace(1, rng.uniform(0.4, 0.8), x.size)


def part_gain(x, rng):
    """Another gain, 0.3 to 2.5, in a part of the log, 3 to 60 % of it."""
    share, gain = log_uniform(rng, 0.03, 0.6), log_uniform(rng, 0.3, 2.5)
    return f"{share:.2f} {gain:.2f}", _part_times(gain, x, share, rng)


def moved(x: np.ndarray, samples: int) -> np.ndarray:
    """x delayed by a number of samples, with the first value before it."""
    place = np.clip(np.arange(x.size) - samples, 0, x.size - 1)
    return x[place]


OF_FORCE = (
    zero_filled, held_samples, zero_bursts, held_bursts, clipped, clipped_then_noise, soft_limit, slew_limited,
    half_gain, sign_flips, quantised, truncated, updated_rarely, absolute, sign, int8_overflow, clock_drift, lagged,
    smoothed, moving_average, spikes, interpolated, noisy, gain_drift,
)  # fmt: skip
OF_POSITION = (
    held_samples, held_bursts, updated_rarely, clock_drift, lagged, smoothed, moving_average, interpolated, zero_filled,
    clipped, spikes,
)  # fmt: skip


def late(case: Case, rng: np.random.Generator) -> Case:
    """A signal is late or early by 1 ms to 1 s."""
    name = str(rng.choice(list(case.signals)))
    seconds = rng.choice([-1, 1]) * log_uniform(rng, 1e-3, 1)
    samples = int(np.sign(seconds) * max(1, round(abs(seconds) * case.rate)))
    return case.changed(f"late {name}", **{name: moved(case.signals[name], samples)})


def in_g(case: Case, rng: np.random.Generator) -> Case:
    """An accelerometer reads in g; without one, the force has a fault."""
    accelerometers = [name for name in case.measured if name.startswith("dd")]
    if not accelerometers:
        return of_force(case, rng)
    name = str(rng.choice(accelerometers))
    return case.changed(f"in g {name}", **{name: case.signals[name] / 9.80665})


def two_machines(case: Case, rng: np.random.Generator) -> Case:
    """A part of the log is as if another machine had been recorded: all forces times a factor."""
    factor, n = rng.choice([0.4, 0.6, 1.5, 2.0]), case.signals[case.force].size
    gain = np.where(np.arange(n) < rng.uniform(0.3, 0.7) * n, 1, factor)
    return case.changed("two machines", **{case.force: case.signals[case.force] * gain})


def all_interpolated(case: Case, rng: np.random.Generator) -> Case:
    """All signals are interpolated from every second or fourth sample."""
    every = int(rng.choice([2, 4]))
    k = np.arange(case.signals[case.force].size)
    changed = {}
    for name, x in case.signals.items():
        rough = x[::every]
        if not name.startswith("dd") and name != case.force:
            noise = log_uniform(rng, 1e-8, 5e-5)
            rough = rough + noise * rng.standard_normal(rough.size)
        changed[name] = np.interp(k, k[::every], rough)
    return case.changed("both interpolated", **changed)


def folded(case: Case, rng: np.random.Generator) -> Case:
    """Samples are left out until half the rate is 0.3 to 1.5 times the fastest motion, which is not filtered before."""
    fastest = 2 * case.mode_hz or 20.0
    every = max(2, round(case.rate / (2 * fastest * rng.uniform(0.3, 1.5))))
    signals = {name: x[::every] for name, x in case.signals.items()}
    return replace(case, signals=signals, rate=case.rate / every, fault="folded")


def low_passed(case: Case, rng: np.random.Generator) -> Case:
    """A signal has passed a Butterworth low-pass of order 1 to 4, causal or without phase."""
    name = str(rng.choice(list(case.signals)))
    order, corner = int(rng.integers(1, 5)), _corner(1.0, 200.0, case, rng)
    sos = scipy.signal.butter(order, corner, "lowpass", fs=case.rate, output="sos")
    x = case.signals[name]
    run = scipy.signal.sosfiltfilt if rng.random() < 0.5 else scipy.signal.sosfilt
    passed = run(sos, x - x[0]) + x[0]
    return case.changed(f"low_passed {'F' if name == case.force else name}", **{name: passed})


def ac_coupled(case: Case, rng: np.random.Generator) -> Case:
    """An accelerometer, else the force, has passed a high-pass of order 1 or 2, as piezoelectric sensors are."""
    accelerometers = [name for name in case.measured if name.startswith("dd")]
    name = str(rng.choice(accelerometers or [case.force]))
    order, corner = int(rng.integers(1, 3)), _corner(0.02, 5.0, case, rng)
    sos = scipy.signal.butter(order, corner, "highpass", fs=case.rate, output="sos")
    passed = scipy.signal.sosfilt(sos, case.signals[name])
    return case.changed(f"ac_coupled {'F' if name == case.force else name}", **{name: passed})


def _corner(low: float, high: float, case: Case, rng: np.random.Generator) -> float:
    """A corner frequency, evenly in the logarithm, below 0.45 of the rate."""
    return min(log_uniform(rng, low, high), 0.45 * case.rate)


def of_force(case: Case, rng: np.random.Generator) -> Case:
    return _of_channel(case, case.force, rng.choice(OF_FORCE), rng)


def of_sensor(case: Case, rng: np.random.Generator) -> Case:
    name = str(rng.choice(case.measured))
    return _of_channel(case, name, rng.choice(OF_POSITION), rng)


def _of_channel(case: Case, name: str, fault, rng: np.random.Generator) -> Case:
    _, x = fault(case.signals[name], rng)
    return case.changed(f"{fault.__name__} {'F' if name == case.force else 'sensor'}", **{name: x})


OF_CASE = (of_force, of_sensor, late, two_machines, all_interpolated, in_g)
_OFTEN = (0.5, 0.15, 0.2, 0.05, 0.07, 0.03)
BY_NAME = {
    f.__name__: f for f in (*OF_FORCE, *OF_POSITION, *OF_CASE, folded, part_gain, low_passed, ac_coupled)
}
"""The last four only by name: what other seeds draw stays."""


def damaged(case: Case, rng: np.random.Generator, name: str = "") -> Case:
    """The log with one fault, of `BY_NAME` or any; one of a channel is mostly of the force, if forces have it."""
    if not name:
        return OF_CASE[rng.choice(len(OF_CASE), p=_OFTEN)](case, rng)
    fault = BY_NAME[name]
    if fault not in (*OF_FORCE, *OF_POSITION, part_gain):
        return fault(case, rng)
    is_of_force = fault is part_gain or (
        fault in OF_FORCE and (fault not in OF_POSITION or rng.random() < 0.7)
    )
    return _of_channel(case, case.force if is_of_force else str(rng.choice(case.measured)), fault, rng)
