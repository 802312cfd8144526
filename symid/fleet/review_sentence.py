"""The summary of a review of a fleet in words."""

from collections.abc import Mapping, Sequence

from symid.fleet.results import UNKNOWN_AXIS, EffectCount
from symid.fleet.review_records import AxisReview
from symid.text import counted, listed, spoken


def review_sentence(
    axes: Sequence[AxisReview], statuses: Mapping[str, int], effects: Sequence[EffectCount]
) -> str:
    """Sentences on the logs, the parameters that differ or change, and the most frequent effect."""
    logs = sum(statuses.values())
    if not logs:
        return "No log."
    known = [review for review in axes if review.axis != UNKNOWN_AXIS]
    only = known[0].name if len(known) == 1 else ""
    good = statuses.get("ok", 0)
    others = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in statuses.items() if name != "ok")
    ok = "all ok" if good == logs else f"{good} ok ({others})"
    parts = [f"{counted(logs, 'log')} of {only or counted(len(known), 'axis', 'axes')}, {ok}."]
    tested = [review for review in axes if review.verdict.probabilities]
    differing = [review for review in tested if review.verdict.differs]
    differing.sort(key=lambda axis: -max(review.spread.share for review in axis.parameters))
    if differing:
        which = [
            f"{_names(review.verdict.parameters)}{'' if only else f' of {review.name}'}"
            for review in differing
        ]
        verb = "differs" if len(differing) == len(differing[0].verdict.parameters) == 1 else "differ"
        parts.append(f"{_names(which)} {verb} from run to run beyond the intervals.")
    elif tested:
        parts.append("No parameter differs from run to run beyond the intervals.")
    changed = [(review, p) for review in axes for p in review.parameters if p.chart.changes]
    for kind in ("step", "drift"):
        moved = [
            p.name if only else f"{p.name} of {review.name}"
            for review, p in changed
            if any(change.kind == kind for change in p.chart.changes)
        ]
        if moved:
            parts.append(f"{_names(moved)} {kind}{'s' if len(moved) == 1 else ''}.")
    if effects:
        first = effects[0]
        parts.append(
            f"Most frequent effect: {spoken(first.effect, first.at)}, in {counted(first.logs, 'log')}"
            + ("." if only else f" of {counted(len(first.axes), 'axis', 'axes')}.")
        )
    return " ".join(parts)


def _names(names: Sequence[str]) -> str:
    """The first three names.

    >>> _names(["M"]), _names(["M", "Fv"]), _names(["M", "Fv", "Fs", "Kt", "D"])
    ('M', 'M and Fv', 'M, Fv, Fs and 2 more')
    """
    return listed([*names[:3], f"{len(names) - 3} more"] if len(names) > 3 else names)
