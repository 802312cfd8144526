"""Numbers that options take, checked when they are read."""

from __future__ import annotations

import math
from typing import Any

import click


class Number(click.types.FloatParamType):
    """A finite number above a bound, which may be included; infinity is possible for limits that do not bind."""

    def __init__(self, above: float = 0.0, *, included: bool = False, infinite: bool = False) -> None:
        self.above, self.included, self.infinite = above, included, infinite

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; click's error, which names the option, for any other text."""
        number = float(super().convert(value, param, ctx))
        big_enough = number >= self.above if self.included else number > self.above
        if not big_enough or not (math.isfinite(number) or (self.infinite and number > 0)):
            least = f"{self.above:g} or more" if self.included else "positive"
            what = "finite" if self.above == -math.inf else least
            self.fail(f"{value} is not possible: it must be {what}", param, ctx)
        return number


class Rate(Number):
    """A rate in Hz, or ``own``."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The rate; ``own`` as it is."""
        return value if value == "own" else super().convert(value, param, ctx)


POSITIVE = Number()
RATE = Rate()
NOT_NEGATIVE = Number(included=True)
LIMIT = Number(infinite=True)
COUNT = click.IntRange(1, 10**9)
ORDER = click.IntRange(1, 50)
