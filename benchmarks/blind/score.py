"""Answers held against the opened labels.

An effect is right if its name and its place are those of the label; effects are named by the verdicts "effect" and
"partly". A stated set is the first effect with what it is said to be indistinguishable from, and counts up to two
members. Right without any effect: "no_gap" or "parameters" on an exact axis, "parameters" where only values were off;
whatever names a cause ("effect", "partly", "recording") is a false alarm there. For a kind that the library lacks:
"unexplained", or a first effect with a probability below one half. No answer is a wrong one.

Worldly cases: right is the strongest effect, first or among the stated ties of the first; without effects, "no_gap" or
"parameters". The closed share of a right answer, 1 - unexplained_share, is held against the truth of its label, see
`draw.removed`: what the strongest effect and the true small ones that were named remove.
"""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

CLEAR = 8.0  # gap-to-noise ratio from which the aims count
CLOSE = 0.1  # of a closed share to the truth
BINS = (0.0, 2.0, 4.0, 8.0, 16.0, 64.0, np.inf)
CALIBRATION = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)
NAMING = ("effect", "partly")
ALARMS = (*NAMING, "recording")

Place = tuple[str, str]


@dataclass(frozen=True)
class Verdict:
    """One case: its label and what was answered."""

    group: str
    sensor_class: str
    axis: str
    ratio: float
    true: tuple[Place, ...]  # the strongest first in a worldly case
    removed: dict[str, float]  # by the digits of the true effects that are named
    verdict: str  # "no answer" where there was none
    found: tuple[Place, ...]
    stated: frozenset[Place]
    probability: float
    with_ties: float  # probability that the first effect, or one of its stated ties, is right
    closed: float
    explained: float | None  # stated share of the excess error that all named effects remove
    removes: tuple[float, float, float] | None  # the same of the first effect, with its bounds
    seconds: float

    @property
    def worldly(self) -> bool:
        return self.group.startswith("worldly")

    @property
    def sought(self) -> tuple[Place, ...]:
        """Effects that may be reported first."""
        return self.true[:1] if self.worldly else self.true

    @property
    def first(self) -> bool:
        """The effect that is named first is one that is there, in a worldly case the strongest."""
        return bool(self.found) and self.found[0] in self.sought

    @property
    def in_stated_set(self) -> bool:
        """A true effect is in the stated set of at most two, or in that of a worldly case."""
        fits = self.worldly or len(self.stated) <= 2
        return self.first or (fits and any(place in self.stated for place in self.sought))

    @property
    def stated_is_right(self) -> bool:
        """A true effect is the first one or any of its stated ties."""
        return any(place in self.stated for place in self.sought)

    @property
    def right(self) -> bool:
        """Required answer for the group of the case."""
        if self.group == "foreign":
            return self.verdict == "unexplained" or (self.verdict in NAMING and self.probability < 0.5)
        if self.group == "two":
            return set(self.true) <= set(self.found)
        if self.group in ("single", "worldly"):
            return self.in_stated_set if self.worldly else self.first
        return self.verdict in ("no_gap", "parameters")[self.group == "parameters" :]

    @property
    def clear(self) -> bool:
        """Strong enough for the aims."""
        return self.ratio >= CLEAR

    @property
    def truth(self) -> float | None:
        """Share of the excess error that the true ones among the named effects remove, if the strongest is named."""
        others = self.found if self.first else self.found[1:]  # the first then stands for the strongest
        named = "".join(str(i) for i, place in enumerate(self.true) if not i or place in others)
        return self.removed.get(named) if self.right else None

    @property
    def miss(self) -> float | None:
        """Stated less true share of the excess error that is removed."""
        truth, stated = self.truth, self.explained
        return None if truth is None or stated is None else stated - truth


def verdict(label: dict[str, Any], record: dict[str, Any]) -> Verdict:
    """One label and one answer, side by side."""
    answer = record["answer"] or {}
    gap = answer.get("gap") or {}
    effects = answer.get("effects", []) if answer.get("verdict") in NAMING else []
    found = tuple((e["effect"], e["at"]) for e in effects)
    others = effects[0].get("indistinguishable_from", []) if effects else []
    closed, left = gap.get("closed_fraction"), gap.get("unexplained_share")
    return Verdict(
        label["group"],
        label["class"],
        label["axis"],
        label["ratio"],
        tuple((e["effect"], e["at"]) for e in label["effects"]),
        label.get("removed", {}),
        answer.get("verdict", "no answer"),
        found,
        frozenset(found[:1] + tuple((e["effect"], e["at"]) for e in others)),
        *_probabilities(effects),
        float(closed) if closed is not None else 0.0,
        None if left is None else 1 - float(left),
        _removes(effects[0]) if effects else None,
        record["seconds"],
    )


def _probabilities(effects: list[dict[str, Any]]) -> tuple[float, float]:
    """Of the first effect, and of it with its ties; answers of code that does not state the latter give the former."""
    if not effects:
        return 0.0, 0.0
    alone = float(effects[0].get("probability") or 0)
    return alone, float(effects[0].get("probability_with_ties") or alone)


def _removes(effect: dict[str, Any]) -> tuple[float, float, float] | None:
    stated = [(effect.get("removes") or {}).get(name) for name in ("share", "low", "high")]
    return None if None in stated else (float(stated[0]), float(stated[1]), float(stated[2]))


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
    verdicts = [v for v in verdicts if not v.worldly]
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
    alarms = [v.verdict in ALARMS for v in plain]
    rows.append(
        Aim("false alarms on exact axes and wrong values", 0.02, _share(alarms), len(plain), at_most=True)
    )
    for group, name, aim in (
        ("foreign", "kinds left out: unexplained or unsure", 0.9),
        ("two", "both of two effects", 0.8),
    ):
        some = [v for v in clear if v.group == group]
        rows.append(Aim(name, aim, _share([v.right for v in some]), len(some)))
    rows.append(Aim("median closed fraction", 0.9, _median([v.closed for v in single]), len(single)))
    named = [v for v in verdicts if v.found]
    rows.append(Aim("Brier score of the first effect", 0.05, brier(named), len(named), at_most=True))
    rows.append(
        Aim("Brier score, first effect or its ties", 0.05, brier(named, ties=True), len(named), at_most=True)
    )
    return rows


def brier(named: list[Verdict], *, ties: bool = False) -> float:
    """Mean squared difference between the probability of the first effect, or with its ties, and what is right."""
    stated = [(v.with_ties, v.stated_is_right) if ties else (v.probability, v.first) for v in named]
    return float(np.mean([(p - hit) ** 2 for p, hit in stated])) if named else float("nan")


@dataclass(frozen=True)
class Figure:
    """Results of worldly cases, and their number; no aim is set here."""

    name: str
    value: float
    cases: int


def worldly(verdicts: list[Verdict]) -> list[Figure]:
    strong = [v for v in verdicts if v.group == "worldly"]
    none = [v for v in verdicts if v.group == "worldly none"]
    named = [v for v in strong + none if v.found]
    misses = [abs(v.miss) for v in strong if v.miss is not None]
    bounds = [(v.removed["0"], v.removes) for v in strong if v.first and v.removed and v.removes]
    some = [
        (name, [v for v in strong if v.sensor_class == name])
        for name in ("rigid", "second sensor", "motor only")
    ]
    some += [(f"gap at least {CLEAR:g} times the noise", [v for v in strong if v.clear]), ("all", strong)]
    return [
        *(
            Figure(f"strongest first or tied, {name}", _share([v.right for v in part]), len(part))
            for name, part in some
        ),
        Figure("strongest itself first", _share([v.first for v in strong]), len(strong)),
        Figure("no effect: no_gap or parameters", _share([v.right for v in none]), len(none)),
        Figure("no effect: a cause is named", _share([v.verdict in ALARMS for v in none]), len(none)),
        Figure(
            "right: closed share within 10 points of the truth",
            _share([m <= CLOSE for m in misses]),
            len(misses),
        ),
        Figure("right: median distance of the closed share", _median(misses), len(misses)),
        Figure(
            "first: interval of what it removes holds the truth",
            _share([low <= t <= high for t, (_, low, high) in bounds]),
            len(bounds),
        ),
        Figure("Brier score, first effect", brier(named), len(named)),
        Figure("Brier score, first effect or its ties", brier(named, ties=True), len(named)),
    ]


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def by_ratio(verdicts: list[Verdict]) -> dict[str, list[tuple[int, int]]]:
    """Right answers and cases of one effect or a strongest one, per class and bin of the gap-to-noise ratio."""
    single = [v for v in verdicts if v.group in ("single", "worldly")]
    table = {}
    for name in sorted({v.sensor_class for v in single}):
        some = [v for v in single if v.sensor_class == name]
        bins = [[v for v in some if low <= v.ratio < high] for low, high in pairwise(BINS)]
        table[name] = [(sum(v.right for v in part), len(part)) for part in bins]
    return table


def confusion(verdicts: list[Verdict]) -> dict[str, dict[str, int]]:
    """Answers for each true kind at each place of the clear cases; groups without a kind by their name."""
    table: dict[str, Counter[str]] = {}
    for v in verdicts:
        if v.true and not v.clear:
            continue
        truth = " + ".join(" at ".join(place) for place in v.sought) or v.group
        answered = " + ".join(" at ".join(place) for place in v.found[: max(len(v.sought), 1)]) or v.verdict
        table.setdefault(truth, Counter())[answered] += 1
    return {truth: dict(counts.most_common()) for truth, counts in sorted(table.items())}


def calibration(verdicts: list[Verdict]) -> list[tuple[float, float, int, float, float, float]]:
    """Per bin of the first effect's probability: its bounds, cases, mean probability, share right, right with ties."""
    named, rows = [v for v in verdicts if v.found], []
    for low, high in pairwise(CALIBRATION):
        some = [v for v in named if low <= v.probability < high or (high == 1 and v.probability == 1)]
        if some:
            mean, right = float(np.mean([v.probability for v in some])), _share([v.first for v in some])
            rows.append((low, high, len(some), mean, right, _share([v.in_stated_set for v in some])))
    return rows


def time_quantiles(verdicts: list[Verdict]) -> dict[str, float]:
    """Processor seconds of a whole process."""
    seconds = [v.seconds for v in verdicts]
    shares = (("median", 0.5), ("90 %", 0.9), ("95 %", 0.95), ("longest", 1.0))
    return {name: float(np.quantile(seconds, q)) for name, q in shares}
