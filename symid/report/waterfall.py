"""The waterfall of a gap: from the nominal values over the identified ones and each effect down to the noise floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

from symid.diagnosis.gap import Gap, Level
from symid.diagnosis.result import Diagnosis
from symid.report.numbers import words


@dataclass(frozen=True)
class Stage:
    """One stage of the waterfall.

    Parameters
    ----------
    model : str
        Which model the error is of.
    level : Level or None
        Error that is left; None where there is no such model.
    floor : Level
        The noise floor.
    removed : float
        By how much this stage is below the one before it, in the unit of the force; nan where there is none before.
    """

    model: str
    level: Level | None
    floor: Level
    removed: float

    @property
    def multiple(self) -> float:
        """Error in multiples of the noise floor; nan where there is none."""
        return multiple_of_floor(self.level, self.floor)

    @property
    def removed_multiple(self) -> float:
        """Removed error in multiples of the noise floor; nan for the first model."""
        return self.removed / self.floor.rms if self.floor.rms > 0 else math.nan


def multiple_of_floor(level: Level | None, floor: Level) -> float:
    """An error in multiples of the noise floor; nan where there is no error or no floor.

    Examples
    --------
    >>> multiple_of_floor(Level(6.0, 0.3), Level(2.0, 0.1))
    3.0
    """
    return math.nan if level is None or not floor.rms > 0 else level.rms / floor.rms


def waterfall(found: Diagnosis) -> tuple[Stage, ...]:
    """Stages of the gap from the nominal values down to the noise floor.

    What the stages remove and the noise floor add up to the first stage that has a level.
    """
    levels = _levels(found.gap, [words(effect.effect) + f" at {effect.at}" for effect in found.effects])
    stages, before = [], math.nan
    for model, level in levels:
        removed = math.nan if level is None else before - level.rms
        stages.append(Stage(model, level, found.gap.noise_floor, removed))
        before = before if level is None else level.rms
    return tuple(stages)


def _levels(gap: Gap, effects: list[str]) -> list[tuple[str, Level | None]]:
    steps = [("and " if i else "with ") + effect for i, effect in enumerate(effects)]
    return [
        ("nominal values", gap.nominal),
        ("parameters re-identified", gap.reidentified),
        *zip(steps, gap.steps, strict=True),
        ("noise floor", gap.noise_floor),
    ]
