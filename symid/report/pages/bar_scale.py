"""The scale of bars in multiples of the noise floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

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
