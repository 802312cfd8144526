"""Answers held against the opened labels.

An effect is right if its name and its place are those of the label. A stated set is the first effect with what it is
said to be indistinguishable from, and counts up to two members. Right without any effect: "no_gap" or "parameters" on
an exact axis, "parameters" where only values were off; all but these two is a false alarm there. For a kind that the
library lacks: "unexplained", or a first effect with a probability below one half. No answer is a wrong one.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

CLEAR = 8.0  # gap-to-noise ratio from which the aims count
BINS = (0.0, 2.0, 4.0, 8.0, 16.0, 64.0, np.inf)
CALIBRATION = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)

Place = tuple[str, str]


@dataclass(frozen=True)
class Verdict:
    """One case: its label and what was answered."""

    group: str
    sensor_class: str
    axis: str
    ratio: float
    true: tuple[Place, ...]
    verdict: str  # "no answer" where there was none
    found: tuple[Place, ...]
    stated: frozenset[Place]
    probability: float
    closed: float
    seconds: float

    @property
    def first(self) -> bool:
        """The effect that is named first is one that is there."""
        return bool(self.found) and self.found[0] in self.true

    @property
    def in_stated_set(self) -> bool:
        """A true effect is in the stated set of at most two."""
        return self.first or (len(self.stated) <= 2 and any(place in self.stated for place in self.true))

    @property
    def right(self) -> bool:
        """What the group of the case asks for."""
        if self.group == "foreign":
            return self.verdict == "unexplained" or (self.verdict == "effect" and self.probability < 0.5)
        if self.group == "two":
            return set(self.true) <= set(self.found)
        if self.group == "single":
            return self.first
        return self.verdict == "parameters" or (self.group == "none" and self.verdict == "no_gap")

    @property
    def clear(self) -> bool:
        """Strong enough for the aims."""
        return self.ratio >= CLEAR


def verdict(label: dict[str, Any], record: dict[str, Any]) -> Verdict:
    """One label and one answer, side by side."""
    answer = record["answer"] or {}
    effects = answer.get("effects", []) if answer.get("verdict") == "effect" else []
    found = tuple((e["effect"], e["at"]) for e in effects)
    others = effects[0].get("indistinguishable_from", []) if effects else []
    closed = (answer.get("gap") or {}).get("closed_fraction")
    return Verdict(
        label["group"],
        label["class"],
        label["axis"],
        label["ratio"],
        tuple((e["effect"], e["at"]) for e in label["effects"]),
        answer.get("verdict", "no answer"),
        found,
        frozenset(found[:1] + tuple((e["effect"], e["at"]) for e in others)),
        float(effects[0].get("probability") or 0) if effects else 0.0,
        float(closed) if closed is not None else 0.0,
        record["seconds"],
    )


@dataclass(frozen=True)
class Aim:
    """A figure of the issue beside what was reached, over a number of cases."""

    name: str
    aim: float
    value: float
    cases: int
    at_most: bool = False

    @property
    def met(self) -> bool:
        """Reached, on at least one case."""
        return self.cases > 0 and (self.value <= self.aim if self.at_most else self.value >= self.aim)


def _share(hits: list[bool]) -> float:
    return float(np.mean(hits)) if hits else float("nan")


def aims(verdicts: list[Verdict]) -> list[Aim]:
    """All aims of the issue."""
    clear = [v for v in verdicts if v.clear]
    single = [v for v in clear if v.group == "single"]
    rows = []
    for name, first, stated in (
        ("rigid", 0.97, 0.99),
        ("second sensor", 0.95, 0.98),
        ("motor only", 0.92, 0.96),
    ):
        some = [v for v in single if v.sensor_class == name]
        rows.append(
            Aim(f"{name}: right effect and place first", first, _share([v.first for v in some]), len(some))
        )
        rows.append(
            Aim(f"{name}: in the stated set", stated, _share([v.in_stated_set for v in some]), len(some))
        )
    plain = [v for v in verdicts if v.group in ("none", "parameters")]
    alarms = [v.verdict not in ("no_gap", "parameters") for v in plain]
    rows.append(
        Aim("false alarms on exact axes and wrong values", 0.02, _share(alarms), len(plain), at_most=True)
    )
    for group, name, aim in (
        ("foreign", "kinds left out: unexplained or unsure", 0.9),
        ("two", "both of two effects", 0.8),
    ):
        some = [v for v in clear if v.group == group]
        rows.append(Aim(name, aim, _share([v.right for v in some]), len(some)))
    closed = float(np.median([v.closed for v in single])) if single else float("nan")
    rows.append(Aim("median closed fraction", 0.9, closed, len(single)))
    named = [v for v in verdicts if v.found]
    rows.append(Aim("Brier score of the first effect", 0.05, brier(named), len(named), at_most=True))
    return rows


def brier(named: list[Verdict]) -> float:
    """Mean squared difference between the probability of the first effect and whether it is there."""
    return float(np.mean([(v.probability - v.first) ** 2 for v in named])) if named else float("nan")


def by_ratio(verdicts: list[Verdict]) -> dict[str, list[tuple[int, int]]]:
    """Right answers and cases of one effect, per class and bin of the gap-to-noise ratio."""
    single = [v for v in verdicts if v.group == "single"]
    table = {}
    for name in sorted({v.sensor_class for v in single}):
        some = [v for v in single if v.sensor_class == name]
        bins = [[v for v in some if low <= v.ratio < high] for low, high in pairwise(BINS)]
        table[name] = [(sum(v.first for v in part), len(part)) for part in bins]
    return table


def confusion(verdicts: list[Verdict]) -> dict[str, dict[str, int]]:
    """What was answered for each true kind at each place of the clear cases; groups without a kind by their name."""
    table: dict[str, Counter[str]] = {}
    for v in verdicts:
        if v.true and not v.clear:
            continue
        truth = " + ".join(" at ".join(place) for place in v.true) or v.group
        answered = " + ".join(" at ".join(place) for place in v.found[: max(len(v.true), 1)]) or v.verdict
        table.setdefault(truth, Counter())[answered] += 1
    return {truth: dict(counts.most_common()) for truth, counts in sorted(table.items())}


def calibration(verdicts: list[Verdict]) -> list[tuple[float, float, int, float, float]]:
    """Per bin of the first effect's probability: its bounds, cases, mean probability, share that was right."""
    named, rows = [v for v in verdicts if v.found], []
    for low, high in pairwise(CALIBRATION):
        some = [v for v in named if low <= v.probability < high or (high == 1 and v.probability == 1)]
        if some:
            mean = float(np.mean([v.probability for v in some]))
            rows.append((low, high, len(some), mean, _share([v.first for v in some])))
    return rows


def time_quantiles(verdicts: list[Verdict]) -> dict[str, float]:
    """Seconds of a whole process."""
    seconds = [v.seconds for v in verdicts]
    return {
        name: float(np.quantile(seconds, q)) for name, q in (("median", 0.5), ("90 %", 0.9), ("longest", 1.0))
    }
