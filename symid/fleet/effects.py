"""Effects that diagnoses found, counted over a fleet."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class EffectCount:
    """How often diagnoses found an effect at a place.

    Parameters
    ----------
    effect, at : str
        The effect and its place.
    logs : int
        Logs in which it was found.
    axes : mapping of str to int
        Axes in which it was found, and in how many of their logs.
    """

    effect: str
    at: str
    logs: int
    axes: Mapping[str, int]


def count_effects(found: Iterable[tuple[str, object, object]]) -> tuple[EffectCount, ...]:
    """Effects over the fleet, the most frequent first.

    Parameters
    ----------
    found : iterable of (axis, effect, at)
        One for each log; without an effect it does not count.

    Examples
    --------
    >>> count_effects([("emps", "backlash", "load"), ("rig", None, None), ("emps", "backlash", "load")])
    (EffectCount(effect='backlash', at='load', logs=2, axes={'emps': 2}),)
    """
    axes: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for axis, effect, at in found:
        if effect:
            axes[str(effect), str(at or "")][axis] += 1
    counts = (EffectCount(*place, counted.total(), dict(counted)) for place, counted in axes.items())
    return tuple(sorted(counts, key=lambda one: (-one.logs, one.effect, one.at)))
