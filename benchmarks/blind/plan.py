"""Which cases a set holds: every kind at every place of every axis in turn, and the groups without one effect."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from . import draw, laws, seal
from .axes import KINDS, draw_nominal

CLASSES = {
    "rigid": [("rigid_1m", ("q",))],
    "second sensor": [("direct_2m1s", ("q2", "ddq1")), ("ballscrew_2m1s", ("qm", "ql"))],
    "motor only": [("direct_2m1s", ("q2",)), ("ballscrew_2m1s", ("qm",))],
}
SHARES = {"single": 0.66, "none": 0.1, "parameters": 0.08, "two": 0.08, "foreign": 0.08}
OFF = {"none": (0.0, 0.0), "parameters": (0.15, 0.4)}


@dataclass(frozen=True)
class Plan:
    """One case to be drawn."""

    name: str
    group: str
    sensor_class: str
    axis: str
    sensors: tuple[str, ...]
    effects: tuple[tuple[str, str], ...]
    seed: tuple[int, int]


def plans(cases: int, seed: int, only: str | None = None) -> list[Plan]:
    """The cases of a set in random order; `only` one group."""
    rng = np.random.default_rng(seed)
    shares = {only: 1.0} if only else SHARES
    groups = [g for g, share in shares.items() for _ in range(round(share * cases))][:cases]
    groups += ["single"] * (cases - len(groups))
    turns = {name: _turns(name, rng) for name in CLASSES}
    names, found = list(CLASSES), []
    for i, group in enumerate(groups):
        sensor_class = names[i % len(names)]
        axis, sensors, *one = turns[sensor_class][(i // len(names)) % len(turns[sensor_class])]
        effects = _effects(group, axis, sensors, (one[0], one[1]), rng)
        found.append((group, sensor_class, axis, sensors, effects))
    order = rng.permutation(cases)
    return [Plan(f"case{k:03d}", *found[i], seed=(seed, int(i))) for k, i in enumerate(order)]


def _turns(sensor_class: str, rng: np.random.Generator) -> list[tuple[str, tuple[str, ...], str, str]]:
    everything = [(a, s, *place) for a, s in CLASSES[sensor_class] for place in laws.places(a, s)]
    return [everything[i] for i in rng.permutation(len(everything))]


def _effects(
    group: str, axis: str, sensors: tuple[str, ...], one: tuple[str, str], rng: np.random.Generator
) -> tuple[tuple[str, str], ...]:
    if group == "single":
        return (one,)
    if group == "two":
        others = [place for place in laws.places(axis, sensors) if place[0] != one[0]]
        return (one, others[rng.integers(len(others))])
    if group == "foreign":
        bodies = [body for body in KINDS[axis].bodies if body != "structure"]
        return ((str(rng.choice(list(laws.FOREIGN))), str(rng.choice(bodies))),)
    return ()


def draw_case(plan: Plan, folder: Path) -> dict[str, Any]:
    """Simulate and write one case; its label."""
    rng = np.random.default_rng(plan.seed)
    setting = draw.draw_setting(plan.axis, plan.sensors, rng)
    low, high = (15.0, 120.0) if plan.group == "two" else draw.RATIOS
    wanted = []
    for effect, at in plan.effects:
        target = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        wanted.append(draw.sized(setting, laws.draw(effect, at, rng), target))
    effects, runs = draw.tamed(setting, tuple(wanted))
    nominal = draw_nominal(setting.true, OFF.get(plan.group, (0.0, 0.12)), rng)
    draw.write(folder / plan.name, setting, runs, nominal)
    alone = [draw.gap_ratio(setting, (effect,)) for effect in effects]
    return {
        "group": plan.group,
        "class": plan.sensor_class,
        "axis": plan.axis,
        "sensors": list(plan.sensors),
        "true": setting.true,
        "effects": [{"effect": e.effect, "at": e.at, "numbers": e.numbers} for e in effects],
        "ratios": alone,
        "ratio": draw.gap_ratio(setting, effects) if len(effects) > 1 else (alone or [0.0])[0],
    }


def draw_set(folder: Path, cases: int, seed: int, jobs: int, only: str | None = None) -> str:
    """Write all cases, seal their labels; SHA-256 of the sealed file."""
    folder.mkdir(parents=True)
    todo = plans(cases, seed, only)
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:  # polars' threads do not survive a fork
        labels = list(pool.map(draw_case, todo, [folder] * len(todo)))
    return seal.close(folder, {plan.name: label for plan, label in zip(todo, labels, strict=True)})
