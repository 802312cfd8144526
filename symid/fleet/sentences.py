"""Sentences of a fleet review."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import polars as pl

from symid.fleet.results import UNKNOWN, EffectCount

if TYPE_CHECKING:
    from symid.fleet.review import AxisReview


def sentence(
    table: pl.DataFrame,
    axes: Sequence[AxisReview],
    statuses: Mapping[str, int],
    effects: Sequence[EffectCount],
) -> str:
    """Counts, axes that differ, changes and the most frequent effect."""
    if not table.height:
        return "No log."
    known = sum(one.axis != UNKNOWN for one in axes)
    parts = [f"{_plural(table.height, 'log')} of {_plural(known, 'axis', 'axes')}, {_ok(table, statuses)}."]
    tested = [one for one in axes if one.verdict.probabilities]
    differing = [one for one in tested if one.verdict.differs]
    if differing:

        def largest_share(axis: AxisReview) -> float:
            known = (one.spread for one in axis.parameters if math.isfinite(one.spread.between))
            return max((spread.share for spread in known), default=0.0)

        worst = max(differing, key=largest_share)
        which = ", ".join(worst.verdict.parameters[:3])
        parts.append(
            f"{len(differing)} of {_plural(len(tested), 'axis', 'axes')} really "
            f"{'differs' if len(differing) == 1 else 'differ'} from run to run"
            f"{', most of all' if len(differing) > 1 else ':'} {worst.name} in {which}."
        )
    elif tested:
        parts.append("No axis differs from run to run beyond its intervals.")
    changed = [one.name for one in axes if any(p.chart.changes for p in one.parameters)]
    if changed:
        names = ", ".join(changed[:3]) + (f" and {len(changed) - 3} more" if len(changed) > 3 else "")
        parts.append(f"Parameters of {_plural(len(changed), 'axis', 'axes')} step or drift: {names}.")
    if effects:
        first = effects[0]
        place = f" at {first.at}" if first.at else ""
        parts.append(
            f"Most frequent effect: {first.effect.replace('_', ' ')}{place}, in {_plural(first.logs, 'log')} of "
            f"{_plural(len(first.axes), 'axis', 'axes')}."
        )
    return " ".join(parts)


def _ok(table: pl.DataFrame, statuses: Mapping[str, int]) -> str:
    good = statuses.get("ok", 0)
    if good == table.height:
        return "all ok"
    others = ", ".join(
        f"{count} {name.replace('_', ' ')}" for name, count in statuses.items() if name != "ok"
    )
    return f"{good} ok ({others})"


def _plural(count: int, one: str, many: str = "") -> str:
    return f"{count} {one if count == 1 else many or one + 's'}"
