"""The waterfall of a gap: nominal values, identified values, each effect, noise floor."""

import math
from dataclasses import dataclass

from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.findings.gap import Level
from symid.text import spoken


@dataclass(frozen=True)
class Stage:
    """One stage of the waterfall: the remaining error of a model (None without the model), and the noise floor.

    `removed` is the reduction relative to the previous stage, in the unit of the force; nan for the first.
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
    effects = [spoken(effect.effect, effect.at) for effect in found.effects]
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
