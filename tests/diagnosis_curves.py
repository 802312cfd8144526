"""Curves of a made-up machine, and errors, maps and spectra computed from them."""

from itertools import pairwise

import numpy as np

from symid.diagnosis import Level, MapCell, Signals, Spectrum

FLOOR = 1.9
"""Noise of the force in N."""
RATE = 4000.0
FOUND = ("effect", "two effects", "partly")
"""Kinds of diagnoses that hold effects."""


def curves_of(kind: str, seconds: float) -> Signals:
    random = np.random.default_rng(4)
    time = np.arange(round(seconds * RATE)) / RATE
    position, velocity, acceleration = np.zeros((3, time.size))
    for amplitude, frequency, phase in ((0.05, 0.3, 0.4), (0.008, 1.7, 1.0), (0.0007, 6.1, 0.2)):
        rate, angle = 2 * np.pi * frequency, 2 * np.pi * frequency * time + phase
        position += amplitude * np.sin(angle)
        velocity += amplitude * rate * np.cos(angle)
        acceleration -= amplitude * rate**2 * np.sin(angle)
    direction = np.sign(velocity)
    model = 362.58 * acceleration + 88.6 * velocity + 146 * direction
    stribeck = 45 * direction * np.exp(-((velocity / 0.02) ** 2))
    late = 0.0006 * np.gradient(model, time) * (np.abs(np.gradient(direction)) == 0)
    ripple = 9 * np.sin(2 * np.pi * 23 * time) * np.sin(2 * np.pi * 0.9 * time) ** 2
    missing = {
        "effect": stribeck,
        "two effects": stribeck + late,
        "partly": stribeck + 2 * ripple,
        "unexplained": ripple,
        "recording": ripple,
    }.get(kind, 0 * time)
    explained = stribeck if kind == "partly" else missing
    found = 0.85 * explained if kind in FOUND else 0 * time
    noise = random.normal(0.0, FLOOR, time.size)
    nominal = model if kind == "no gap" else 1.05 * 362.58 * acceleration + 60 * velocity + 130 * direction
    measured, before = model + missing + noise, model + 0.08 * missing
    compared = np.abs(velocity) > 0.004
    return Signals(time, position, velocity, measured, nominal, before, before + found, compared)


def level_of(error: np.ndarray, signals: Signals) -> Level:
    used = signals.compared
    rms = float(np.sqrt(np.mean(error[used] ** 2)))
    return Level(rms, rms / float(np.sqrt(np.mean(signals.measured[used] ** 2))))


def maps_of(signals: Signals) -> dict[str, tuple[MapCell, ...]]:
    speed, inner = np.abs(signals.velocity), (-np.inf, np.inf)
    drive = np.abs(signals.measured)
    masks = {
        "regime": (
            ("reversal", *inner, speed < 0.008),
            ("slow", *inner, (speed >= 0.008) & (speed < 0.04)),
            ("fast", *inner, speed >= 0.04),
        ),
        "direction": (("forward", *inner, signals.velocity > 0), ("backward", *inner, signals.velocity < 0)),
        "position": _parts(signals.position, 6, "m"),
        "drive force": _parts(drive, 5, "N"),
        "time": _parts(signals.time, 5, "s"),
    }
    bands = (
        ("0–2 Hz", 0, 2, 0.31),
        ("2–10 Hz", 2, 10, 0.46),
        ("10–40 Hz", 10, 40, 0.19),
        ("40–120 Hz", 40, 120, 0.04),
    )
    maps = {
        "band": tuple(
            MapCell(label, lo, hi, (hi - lo) / 120, s, 1 + 20 * s, 1.05) for label, lo, hi, s in bands
        )
    }
    return maps | {name: tuple(_cell(signals, *mask) for mask in cells) for name, cells in masks.items()}


def _parts(values: np.ndarray, count: int, unit: str) -> list[tuple[str, float, float, np.ndarray]]:
    digits = 3 - int(np.ceil(np.log10(np.ptp(values))))
    limits = np.round(np.linspace(values.min(), values.max(), count + 1), digits)
    return [
        (f"{low + 0:.4g} to {high:.4g} {unit}", low, high, (values >= low) & (values < high))
        for low, high in pairwise(limits)
    ]


def _cell(signals: Signals, label: str, low: float, high: float, inside: np.ndarray) -> MapCell:
    error = signals.measured - signals.reidentified
    used = signals.compared
    excess = float(np.sum(error[used] ** 2 - FLOOR**2))
    here = used & inside
    if not np.any(here):
        return MapCell(label, low, high, 0.0, 0.0, np.nan, np.nan)
    part = float(np.sum(error[here] ** 2 - FLOOR**2)) / excess if excess > FLOOR**2 * used.sum() else np.nan
    before, after = (
        level_of(signals.measured[here] - force[here], _rows(signals, here)).rms / FLOOR
        for force in (signals.reidentified, signals.explained)
    )
    return MapCell(label, low, high, float(here.sum() / used.sum()), part, before, after)


def _rows(signals: Signals, rows: np.ndarray) -> Signals:
    return Signals(*(getattr(signals, name)[rows] for name in Signals.__dataclass_fields__))


def spectrum_of(signals: Signals) -> Spectrum:
    window, size = np.hanning(4096), 4096
    density = []
    for force in (signals.reidentified, signals.explained):
        error = signals.measured - force
        parts = np.lib.stride_tricks.sliding_window_view(error, size)[:: size // 2] * window
        power = np.mean(np.abs(np.fft.rfft(parts, axis=1)) ** 2, axis=0)
        density.append(np.sqrt(2 * power / (RATE * np.sum(window**2))))
    frequency = np.fft.rfftfreq(size, 1 / RATE)
    noise = np.full(frequency.size, FLOOR * np.sqrt(2 / RATE))
    return Spectrum(frequency, density[0], density[1], noise)
