"""Which cases a set holds: every kind at every place of every axis in turn, and the groups without one effect."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.draws import log_uniform

from . import draw, laws, seal
from .axes import KINDS, draw_nominal

CLASSES = {
    "rigid": [("rigid_1m", ("q",))],
    "second sensor": [("direct_2m1s", ("q2", "ddq1")), ("ballscrew_2m1s", ("qm", "ql"))],
    "motor only": [("direct_2m1s", ("q2",)), ("ballscrew_2m1s", ("qm",))],
}
SHARES = {"single": 0.66, "none": 0.1, "parameters": 0.08, "two": 0.08, "foreign": 0.08}
WORLDLY = {"worldly": 0.8, "worldly none": 0.2}
OFF = {"none": (0.0, 0.0), "worldly none": (0.0, 0.0), "parameters": (0.15, 0.4)}
# Of worldly cases: force of the strongest effect in multiples of the noise; of each small one in multiples of the
# strongest one's; and what the plain axis, identified from one log, misses in the other with all of them in multiples
# of the same with the strongest alone: effects that raise each other would leave none that is the strongest.
STRONGEST, SMALL, TOGETHER, OTHERS = (4.0, 60.0), (0.12, 0.25), (0.8, 1.25), 3


@dataclass(frozen=True)
class Plan:
    """Plan of a case before it is drawn."""

    name: str
    group: str
    sensor_class: str
    axis: str
    sensors: tuple[str, ...]
    effects: tuple[tuple[str, str], ...]
    seed: tuple[int, int]
    size: tuple[float, float] | None = None


@dataclass(frozen=True)
class Wish:
    """What a set is confined to; nothing unless given. `size`: bounds of the effect's own number, not of its ratio."""

    group: str | None = None
    worldly: bool = False
    kind: str | None = None
    at: str | None = None
    axes: tuple[str, ...] = ()
    size: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.size and (self.worldly or not self.kind):
            raise ValueError("bounds of a size need the one kind of effect that has it, and no worldly cases")

    def shares(self) -> dict[str, float]:
        """Share of the cases in each group."""
        chosen = self.group or (("worldly" if self.worldly else "single") if self.kind else None)
        return {chosen: 1.0} if chosen else WORLDLY if self.worldly else SHARES

    def allows(self, axis: str, effect: str, at: str) -> bool:
        """Whether a case may have this effect there."""
        return axis in (self.axes or KINDS) and effect == (self.kind or effect) and at == (self.at or at)


def plans(cases: int, seed: int, wish: Wish = Wish()) -> list[Plan]:
    """The cases of a set in random order."""
    rng = np.random.default_rng(seed)
    shares = wish.shares()
    groups = [g for g, share in shares.items() for _ in range(round(share * cases))][:cases]
    groups += [next(iter(shares))] * (cases - len(groups))
    turns = {name: some for name in CLASSES if (some := _turns(name, rng, wish))}
    if not turns:
        raise ValueError("no axis has such an effect there")
    names, found = list(turns), []
    for i, group in enumerate(groups):
        sensor_class = names[i % len(names)]
        axis, sensors, *one = turns[sensor_class][(i // len(names)) % len(turns[sensor_class])]
        effects = _effects(group, axis, sensors, (one[0], one[1]), rng)
        found.append((group, sensor_class, axis, sensors, effects))
    order = rng.permutation(cases)
    return [Plan(f"case{k:03d}", *found[i], (seed, int(i)), wish.size) for k, i in enumerate(order)]


def _turns(
    sensor_class: str, rng: np.random.Generator, wish: Wish
) -> list[tuple[str, tuple[str, ...], str, str]]:
    everything = [
        (a, s, *place)
        for a, s in CLASSES[sensor_class]
        for place in laws.places(a, s)
        if wish.allows(a, *place)
    ]
    return [everything[i] for i in rng.permutation(len(everything))]


def _effects(
    group: str, axis: str, sensors: tuple[str, ...], one: tuple[str, str], rng: np.random.Generator
) -> tuple[tuple[str, str], ...]:
    if group in ("single", "worldly"):  # the small ones of a worldly case are drawn with it
        return (one,)
    if group == "two":
        others = [place for place in laws.places(axis, sensors) if place[0] != one[0]]
        return (one, others[rng.integers(len(others))])
    if group == "foreign":
        bodies = [body for body in KINDS[axis].bodies if body != "structure"]
        return ((str(rng.choice(list(laws.FOREIGN))), str(rng.choice(bodies))),)
    return ()


def _hidden(plan: Plan, setting: draw.Setting, rng: np.random.Generator) -> tuple[laws.Effect, ...]:
    """The effects of a case with their sizes, the strongest of a worldly one first."""
    if plan.group == "worldly":
        return _worldly(plan, setting, rng)
    bounds, found = (15.0, 120.0) if plan.group == "two" else draw.RATIOS, []
    for effect, at in plan.effects:
        if plan.size:
            found.append(laws.draw(effect, at, rng).sized(log_uniform(rng, *plan.size)))
            continue
        target = log_uniform(rng, *bounds)
        found.append(draw.sized(setting, laws.draw(effect, at, rng), target)[0])
    return tuple(found)


def _worldly(plan: Plan, setting: draw.Setting, rng: np.random.Generator) -> tuple[laws.Effect, ...]:
    """One strong effect and three small ones of other kinds, each with its share of the strong one's force."""
    places = laws.places(plan.axis, plan.sensors)
    places = [*plan.effects, *(places[i] for i in rng.permutation(len(places)))]
    strength, missing, found = 0.0, 0.0, []
    for effect, at in places:
        if effect in [one.effect for one in found]:
            continue
        one = laws.draw(effect, at, rng)
        if not found:
            one, strength = draw.sized(setting, one, log_uniform(rng, *STRONGEST), ratio=draw.force_ratio)
            missing = _missing(setting, one)
            found += [one] if strength > STRONGEST[0] * 0.8 and np.isfinite(missing) else []
            continue
        share = rng.uniform(*SMALL)
        one, reached = draw.sized(setting, one, share * strength, 0.1, draw.force_ratio)
        if _within(reached, SMALL, strength) and _within(_missing(setting, *found, one), TOGETHER, missing):
            found.append(one)
        if len(found) == 1 + OTHERS:
            break
    return tuple(found)


def _missing(setting: draw.Setting, *effects: laws.Effect) -> float:
    """Force, N, that the plain axis misses; infinite where the loop is unstable."""
    try:
        return float(np.sqrt(draw.missing_square(setting, effects)))
    except ArithmeticError:
        return np.inf


def _within(value: float, bounds: tuple[float, float], unit: float) -> bool:
    return bounds[0] * unit <= value <= bounds[1] * unit


def draw_case(plan: Plan, folder: Path) -> dict[str, Any]:
    """Simulate and write one case; its label."""
    rng = np.random.default_rng(plan.seed)
    setting = draw.draw_setting(plan.axis, plan.sensors, rng)
    if plan.group in WORLDLY:
        setting = draw.wandering(setting, rng)
    effects, runs = draw.tamed(setting, _hidden(plan, setting, rng))
    nominal = draw_nominal(setting.true, OFF.get(plan.group, (0.0, 0.12)), rng)
    draw.write(folder / plan.name, setting, runs, nominal)
    ratio = draw.force_ratio if plan.group == "worldly" else draw.gap_ratio
    alone = [ratio(setting, (effect,)) for effect in effects]
    return {
        "group": plan.group,
        "class": plan.sensor_class,
        "axis": plan.axis,
        "sensors": list(plan.sensors),
        "seed": list(plan.seed),
        "true": setting.true,
        "noise": setting.noise,
        "effects": [{"effect": e.effect, "at": e.at, "numbers": e.numbers} for e in effects],
        "ratios": alone,
        "ratio": ratio(setting, effects) if len(effects) > 1 else (alone or [0.0])[0],
        "removed": draw.removed(setting, effects) if plan.group == "worldly" else {},
    }


def draw_set(folder: Path, cases: int, seed: int, jobs: int, wish: Wish = Wish()) -> str:
    """Write all cases, seal their labels; SHA-256 of the sealed file."""
    todo = plans(cases, seed, wish)
    folder.mkdir(parents=True)
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:  # polars' threads do not survive a fork
        labels = list(pool.map(draw_case, todo, [folder] * len(todo)))
    return seal.close(folder, {plan.name: label for plan, label in zip(todo, labels, strict=True)})
