"""The waterfall of a gap: from the nominal values over the identified ones and each effect down to the noise floor.

Bars show multiples of the noise floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.gap import Level
from symid.report.number_text import words


@dataclass(frozen=True)
class Stage:
    """One stage of the waterfall: the remaining error of a model (None without it) above the noise floor.

    `removed` is the reduction against the stage before, in the unit of the force; nan for the first.
    """

    model: str
    level: Level | None
    floor: Level
    removed: float

    @property
    def multiple(self) -> float:
        """Error in multiples of the noise floor; nan where there is no error or no floor."""
        return self.level.rms / self.floor.rms if self.level and self.floor.rms > 0 else math.nan

    @property
    def removed_multiple(self) -> float:
        """Removed error in multiples of the noise floor; nan for the first model."""
        return self.removed / self.floor.rms if self.floor.rms > 0 else math.nan


def waterfall(found: Diagnosis) -> tuple[Stage, ...]:
    """Stages of the gap from the nominal values down to the noise floor.

    The reductions of all stages and the noise floor add up to the first stage that has a level.
    """
    effects = [f"{words(effect.effect)} at {effect.at}" for effect in found.effects]
    levels = [
        ("nominal values", found.gap.nominal),
        ("parameters re-identified", found.gap.reidentified),
        *zip(
            [("and " if i else "with ") + name for i, name in enumerate(effects)],
            found.gap.steps,
            strict=True,
        ),
        ("noise floor", found.gap.noise_floor),
    ]
    stages, before = [], math.nan
    for model, level in levels:
        removed = math.nan if level is None else before - level.rms
        stages.append(Stage(model, level, found.gap.noise_floor, removed))
        before = before if level is None else level.rms
    return tuple(stages)


_ORIGIN = 0.5
"""Lower end of a logarithmic scale, in multiples of the noise floor."""
_MOST_LINEAR = 25.0
_LEAST = 4.0
"""Least upper end of a scale, in multiples of the noise floor."""
_TICKS = 6
"""Most ticks on a scale."""


@dataclass(frozen=True)
class Scale:
    """Scale of bars up to a multiple of the noise floor: linear up to 25, logarithmic from half of that on.

    >>> Scale(10.0).percent(5.0), Scale(5000.0).logarithmic, Scale(5000.0).percent(50.0)
    (50.0, True, 50.0)
    >>> Scale(10.0).ticks, Scale(1244.0).ticks
    ((0.0, 2.0, 4.0, 6.0, 8.0, 10.0), (1.0, 10.0, 100.0, 1000.0))
    """

    largest: float

    @property
    def logarithmic(self) -> bool:
        """Whether equal lengths are equal ratios."""
        return self.largest > _MOST_LINEAR

    def percent(self, multiple: float) -> float:
        """Length of a bar in percent of the full length; 0 for nan."""
        if not math.isfinite(multiple) or multiple <= 0:
            return 0.0
        if not self.logarithmic:
            return min(100 * multiple / self.largest, 100.0)
        return min(100 * max(math.log(multiple / _ORIGIN), 0.0) / math.log(self.largest / _ORIGIN), 100.0)

    @property
    def ticks(self) -> tuple[float, ...]:
        """Multiples at which the scale is marked."""
        if self.logarithmic:
            decades = range(math.floor(math.log10(self.largest)) + 1)
            return tuple(10.0**k for k in decades)
        steps = (m * 10.0**k for k in range(-2, 2) for m in (1, 2, 5))
        step = next(step for step in steps if self.largest / step < _TICKS)
        return tuple(step * i for i in range(math.floor(self.largest / step) + 1))


def scale_of(multiples: list[float]) -> Scale:
    """Scale that contains all of these multiples, with a margin above the floor."""
    return Scale(max([_LEAST, *(value for value in multiples if math.isfinite(value))]))
