"""A case: axis, hidden effect, motions and noise drawn; simulated; the effect sized to a gap-to-noise ratio."""

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np
import polars as pl
from scipy.signal import lfilter

from benchmarks.draws import log_uniform

from . import axes, engine, gap, laws, motion

RATIOS = (2.0, 200.0)
# Of the record of the force in worldly cases, in multiples of its white noise; hertz.
WANDER, WANDER_HZ, QUANTUM = (1.0, 2.2), (2.0, 4.5), (0.7, 1.4)
SECONDS = {"identification": 10.0, "validation": 6.0}

Ratio = Callable[["Setting", tuple[laws.Effect, ...]], float]


@dataclass(frozen=True)
class Setting:
    """All of a case but its effects: what the simulator runs and what the sensors add."""

    axis: str
    sensors: tuple[str, ...]
    true: dict[str, float]
    controller: dict[str, float]
    lowpass: float  # weight of the newest difference in the controller's velocity
    noisy_controller: bool
    motions: dict[str, np.ndarray]
    noise: dict[str, float]
    seed: int
    travel: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Run:
    """A simulated log at 4 kHz before its noise: what each column would read, and the motor's velocity."""

    readings: dict[str, np.ndarray]
    reference: np.ndarray
    velocity: np.ndarray
    deflection: np.ndarray


def draw_setting(axis: str, sensors: tuple[str, ...], rng: np.random.Generator) -> Setting:
    """Everything but the effect."""
    true = axes.draw_parameters(axis, rng)
    moved = {"rigid_1m": ("M",), "direct_2m1s": ("Mm",), "ballscrew_2m1s": ("Mm", "Ml")}[axis]
    style, motions = motion.draw_style(axis, rng), {}
    for log, seconds in SECONDS.items():
        path = motion.draw_reference(seconds, style, rng)
        force = motion.draw_multisine(axis, sum(true[m] for m in moved), seconds, rng)
        motions[log] = np.vstack([path, force if log == "identification" else 0 * force])
    noise = {
        "F": log_uniform(rng, 0.4, 4),
        "position": log_uniform(rng, 3e-8, 2.5e-7),
        "step": log_uniform(rng, 2e-8, 2e-7),
        "ddq1": float(rng.uniform(0.006, 0.015)),
    }
    lowpass, noisy = float(rng.uniform(0.1, 0.4)), bool(rng.random() < 1 / 3)
    controller = axes.draw_controller(axis, true, rng)
    setting = Setting(
        axis, sensors, true, controller, lowpass, noisy, motions, noise, int(rng.integers(1 << 31))
    )
    plain = [simulate(setting, (), log, disturbed=False) for log in SECONDS]
    travel = {
        "force": max(float(np.abs(run.readings["F"]).max()) for run in plain),
        "deflection": max(float(np.abs(run.deflection).max()) for run in plain),
    }
    return replace(setting, travel=travel)


def wandering(setting: Setting, rng: np.random.Generator) -> Setting:
    """The setting with a record of the force that wanders slowly and is rounded to whole quanta."""
    white, (low, high) = setting.noise["F"], np.log([WANDER, WANDER_HZ, QUANTUM]).T
    wander, hertz, quantum = np.exp(rng.uniform(low, high)).tolist()
    record = {"wander": wander * white, "wander_hz": hertz, "quantum": quantum * white}
    return replace(setting, noise=setting.noise | record)


_ORDER = {"presliding_friction": 1, "position_dependent_friction": 2}
"""Order of the effects of a case: presliding takes all that rubs, and a level that varies is never negative."""


def simulate(setting: Setting, effects: tuple[laws.Effect, ...], log: str, *, disturbed: bool) -> Run:
    """One log by the engine; `disturbed`: the controller sees the encoder's noise and step, if it does in this case."""
    kind, plant = axes.KINDS[setting.axis], axes.machine(setting.axis, setting.true)
    for effect in sorted(effects, key=lambda e: _ORDER.get(e.effect, 0)):
        plant = laws.enter(plant, effect, setting.axis, setting.travel)
    ticks = setting.motions[log].shape[1]
    noise = np.zeros((2, ticks))
    if disturbed and setting.noisy_controller:
        rng = np.random.default_rng([setting.seed, len(log)])
        noise[0], noise[1, 0] = setting.noise["position"] * rng.standard_normal(ticks), setting.noise["step"]
    gains = np.array([*(setting.controller[name] for name in ("Kpp", "Kpv", "Kiv")), setting.lowpass])
    x, a, command = engine.loop(plant.arguments(), gains, setting.motions[log], noise)
    _stable(setting, x, command, motor := _joint(plant, x, kind.bodies.index("motor")), log)
    readings = {"F": _held(command)}
    for sensor in setting.sensors:
        body = kind.bodies.index(kind.position.get(sensor, "structure"))
        readings[sensor] = (
            a[:, body] if sensor == "ddq1" else _rippled(_joint(plant, x, body), sensor, effects)
        )
    spring = plant.springs[0, :2].astype(int) if kind.springs else (0, 0)
    deflection = x[:, spring[0]] - (x[:, spring[1]] if spring[1] >= 0 else 0)
    return Run(
        readings, setting.motions[log][0, :: engine.LOG_TICKS], np.gradient(motor) * gap.RATE, deflection
    )


def _stable(setting: Setting, x: np.ndarray, command: np.ndarray, motor: np.ndarray, log: str) -> None:
    """ArithmeticError for a loop that has left its reference, or oscillates with several times the usual force."""
    error = (
        np.abs(motor - setting.motions[log][0, :: engine.LOG_TICKS]).max() if np.isfinite(x).all() else np.inf
    )
    if error > 0.02 or np.abs(command).max() > 4 * setting.travel.get("force", np.inf):
        raise ArithmeticError(f"{setting.axis}: the closed loop is unstable")


def _held(command: np.ndarray) -> np.ndarray:
    """The held force averaged over the sample centred on each log instant."""
    padded = np.pad(command, (2, 2), mode="edge")
    return padded[: command.size].reshape(-1, 4).mean(axis=1)


def _joint(plant: axes.Machine, x: np.ndarray, body: int) -> np.ndarray:
    return x[:, body] - (x[:, plant.minus[body]] if plant.minus[body] >= 0 else 0)


def _rippled(position: np.ndarray, sensor: str, effects: tuple[laws.Effect, ...]) -> np.ndarray:
    for effect in effects:
        if effect.effect == "encoder_ripple" and effect.at == sensor:
            n = effect.numbers
            position = position + n["amplitude"] * np.sin(2 * np.pi * position / n["pitch"] + n["phase"])
    return position


def measured(setting: Setting, readings: dict[str, np.ndarray], log: str) -> dict[str, np.ndarray]:
    """The readings as a log holds them: with noise, positions rounded to the encoder's step."""
    rng, step = np.random.default_rng([setting.seed, len(log), 1]), setting.noise["step"]
    found = {}
    for name, values in readings.items():
        position = name not in ("F", "ddq1")
        noisy = values + setting.noise["position" if position else name] * rng.standard_normal(values.size)
        found[name] = np.round(noisy / step) * step if position else noisy
    if "quantum" in setting.noise:
        found["F"] = _recorded(found["F"], setting, log)
    return found


def _recorded(force: np.ndarray, setting: Setting, log: str) -> np.ndarray:
    """A force with slow wandering, from zero on and drawn back at a corner frequency, in whole quanta."""
    rng, noise = np.random.default_rng([setting.seed, len(log), 2]), setting.noise
    back = np.exp(-2 * np.pi * noise["wander_hz"] / gap.RATE)
    walk = lfilter([np.sqrt(1 - back**2)], [1, -back], rng.standard_normal(force.size))
    return np.round((force + noise["wander"] * walk) / noise["quantum"]) * noise["quantum"]


def force_density(setting: Setting, frequency: np.ndarray) -> np.ndarray:
    """Power density, N^2, of the noise in a record of the force at frequencies in cycles a sample."""
    noise, white = setting.noise, np.full(frequency.shape, setting.noise["F"] ** 2)
    if "quantum" not in noise:
        return white
    back = np.exp(-2 * np.pi * noise["wander_hz"] / gap.RATE)
    wander = noise["wander"] ** 2 * (1 - back**2) / np.abs(1 - back * np.exp(-2j * np.pi * frequency)) ** 2
    return np.asarray(white + noise["quantum"] ** 2 / 12 + wander)


def gap_ratio(setting: Setting, effects: tuple[laws.Effect, ...]) -> float:
    """Gap-to-noise ratio on the validation log, see `gap`."""
    return _ratio(setting, effects, setting.sensors)


def force_ratio(setting: Setting, effects: tuple[laws.Effect, ...]) -> float:
    """The same of the force as it follows from the motor's position alone, whatever else is measured."""
    return _ratio(setting, effects, driven(setting))


def driven(setting: Setting) -> tuple[str, ...]:
    """The sensor of the motor's position."""
    position = axes.KINDS[setting.axis].position
    return tuple(name for name in setting.sensors if position.get(name) == "motor")


def _ratio(setting: Setting, effects: tuple[laws.Effect, ...], sensors: tuple[str, ...]) -> float:
    run = simulate(setting, effects, "validation", disturbed=False)
    log = measured(setting, run.readings, "validation")
    clean = {name: run.readings[name] for name in ("F", *sensors)}
    noise = {name: log[name] - values for name, values in clean.items()}
    return gap.ratio(setting.axis, setting.true, clean, noise, run.velocity)


def missing_square(setting: Setting, effects: tuple[laws.Effect, ...]) -> float:
    """Square of the force, N^2, that the plain axis, identified from one log, misses in the other; without noise."""
    fitted, checked = (simulate(setting, effects, log, disturbed=False) for log in SECONDS)
    names = ("F", *driven(setting))
    logs = (({name: run.readings[name] for name in names}, run.velocity) for run in (fitted, checked))
    return gap.missing_force(setting.axis, setting.true, *logs) ** 2


def removed(setting: Setting, effects: tuple[laws.Effect, ...]) -> dict[str, float]:
    """What naming the first effect, alone or with others, removes of the missing force's square; by their digits.

    The simulator runs again without the named effects, and the plain axis is fitted again: what is then missing is
    what a model that has these effects exactly, and no other, would leave.
    """
    others = range(1, len(effects))
    chosen = [(0, *some) for n in range(len(effects)) for some in combinations(others, n)]
    whole, none = missing_square(setting, effects), missing_square(setting, ())
    found = {}
    for named in chosen:
        left = tuple(effect for i, effect in enumerate(effects) if i not in named)
        with suppress(ArithmeticError):  # an unstable loop has no such share
            rest = missing_square(setting, left) if left else none
            found["".join(map(str, named))] = 1 - (rest - none) / (whole - none)
    return found


def sized(
    setting: Setting, effect: laws.Effect, target: float, within: float = 0.2, ratio: Ratio = gap_ratio
) -> tuple[laws.Effect, float]:
    """The effect with the size that gives the target ratio to about `within`, and the ratio that it gives."""
    size, best, reached = effect.numbers[effect.size], (np.inf, effect), 0.0
    for _ in range(6):
        size = min(size, effect.most)
        trial = effect.sized(size)
        try:
            found = max(ratio(setting, (trial,)), 1e-3)
        except ArithmeticError:
            size /= 3
            continue
        if abs(np.log(found / target)) < best[0]:
            best, reached = (abs(np.log(found / target)), trial), found
        if best[0] < within or (size == effect.most and found < target):
            break
        size *= np.clip(target / found, 1 / 20, 20)
    return best[1], reached


def tamed(
    setting: Setting, effects: tuple[laws.Effect, ...]
) -> tuple[tuple[laws.Effect, ...], dict[str, Run]]:
    """Effects, made weaker by a quarter until the loop is stable in both logs, and the runs with them."""
    for _ in range(20):
        try:
            return effects, {log: simulate(setting, effects, log, disturbed=True) for log in SECONDS}
        except ArithmeticError:
            effects = tuple(effect.sized(0.75 * effect.numbers[effect.size]) for effect in effects)
    raise ArithmeticError(f"{setting.axis}: the closed loop stays unstable with {effects}")


def write(folder: Path, setting: Setting, runs: dict[str, Run], nominal: dict[str, float]) -> None:
    """The logs and what a diagnosis may know of the axis."""
    folder.mkdir(parents=True)
    force = axes.KINDS[setting.axis].drive
    for log, run in runs.items():
        t = np.arange(run.reference.size) / gap.RATE
        columns = {"t": t, "reference": run.reference}
        readings = measured(setting, run.readings, log)
        columns |= {force if name == "F" else name: values for name, values in readings.items()}
        pl.DataFrame(columns).write_parquet(folder / f"{log}.parquet")
    units = {"t": "s", "reference": "m", force: "N", "ddq1": "m/s^2"}
    record = {
        "model": setting.axis,
        "sampling_frequency_hz": float(gap.RATE),
        "nominal": nominal,
        "controller": setting.controller,
        "columns": {name: units.get(name, "m") for name in columns},
    }
    (folder / "case.json").write_text(json.dumps(record, indent=1))
    (folder / "nominal.json").write_text(json.dumps(nominal, indent=1))
