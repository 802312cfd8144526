"""The score as text and as a record."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from . import score
from .answers import difference
from .score import Verdict


def record(verdicts: list[Verdict], sha256: str) -> dict[str, Any]:
    """All that is printed, for a file; figures without a case are null."""
    return {
        "sha256": sha256,
        "cases": len(verdicts),
        "aims": [
            {
                "name": a.name,
                "aim": a.aim,
                "value": None if math.isnan(a.value) else a.value,
                "cases": a.cases,
                "met": a.met,
            }
            for a in score.aims(verdicts)
        ],
        "worldly": [
            {"name": f.name, "value": None if math.isnan(f.value) else f.value, "cases": f.cases}
            for f in score.worldly(verdicts)
        ],
        "by_ratio": {"bins": [str(b) for b in score.BINS], **score.by_ratio(verdicts)},
        "confusion": score.confusion(verdicts),
        "calibration": score.calibration(verdicts),
        "seconds": score.time_quantiles(verdicts),
        "no_answer": _silent(verdicts),
    }


def _silent(verdicts: list[Verdict]) -> int:
    return sum(v.verdict == "no answer" for v in verdicts)


def text(verdicts: list[Verdict]) -> str:
    """Aims first, then where the answers went."""
    parts = [] if all(v.worldly for v in verdicts) else [_aims(verdicts)]
    parts += [_worldly(verdicts)] if any(v.worldly for v in verdicts) else []
    return "\n\n".join(
        [*parts, _ratios(verdicts), _confusion(verdicts), _calibration(verdicts), _rest(verdicts)]
    )


def _worldly(verdicts: list[Verdict]) -> str:
    lines = [f"{'Worldly cases':58}reached  cases"]
    lines += [f"{f.name:56}  {f.value:7.3f}  {f.cases:5}" for f in score.worldly(verdicts)]
    return "\n".join(lines)


def _aims(verdicts: list[Verdict]) -> str:
    lines = [
        f"Aims (one effect, two, left out: gap at least {score.CLEAR:g} times the noise)",
        f"{'':48}    aim  reached  cases",
    ]
    for a in score.aims(verdicts):
        bound = f"<= {a.aim:g}" if a.at_most else f">= {a.aim:g}"
        verdict = "" if not a.cases else "met" if a.met else "missed"
        lines.append(f"{a.name:46} {bound:>8}  {a.value:7.3f}  {a.cases:5}  {verdict}")
    return "\n".join(lines)


def _ratios(verdicts: list[Verdict]) -> str:
    heads = "".join(f"{f'{low:g}-{high:g}':>10}" for low, high in pairwise(score.BINS))
    lines = ["One effect or a strongest one, right, by gap-to-noise ratio", f"{'':14}{heads}"]
    for name, bins in score.by_ratio(verdicts).items():
        lines.append(f"{name:14}" + "".join(f"{f'{right}/{n}' if n else '-':>10}" for right, n in bins))
    return "\n".join(lines)


def _confusion(verdicts: list[Verdict]) -> str:
    lines = ["What was answered, where the gap is clear"]
    for truth, answers in score.confusion(verdicts).items():
        told = ", ".join(
            f"{'right' if answered == truth else answered} {n}" for answered, n in answers.items()
        )
        lines.append(f"{truth:45}  {told}")
    return "\n".join(lines)


def _calibration(verdicts: list[Verdict]) -> str:
    lines = ["Probability of the first effect: cases, mean, share that was right, with its ties"]
    lines += [
        f"{lo:5.2f} to {hi:4.2f} {n:6} {mean:7.3f} {share:7.3f} {tied:7.3f}"
        for lo, hi, n, mean, share, tied in score.calibration(verdicts)
    ]
    return "\n".join(lines)


def _rest(verdicts: list[Verdict]) -> str:
    seconds = ", ".join(f"{name} {value:.1f}" for name, value in score.time_quantiles(verdicts).items())
    return f"Processor seconds a case: {seconds}\nWithout an answer: {_silent(verdicts)} of {len(verdicts)}"


def cost_line(name: str, runs: Sequence[dict[str, Any]]) -> str:
    """Processor time and peak memory of a case by this code and, if it ran, by another, and how the answers differ."""
    cells = [f"{run['seconds']:7.2f} s {run['peak_mb']:5.0f} MB" for run in runs]
    given = [run["answer"] for run in runs]
    if len(runs) > 1:
        differ = difference(*given)
        cells.append(
            "the same" if differ == 0 else f"numbers within {differ:.0e}" if differ < 1 else "differs"
        )
    return "  ".join([f"{name:28}", *cells, *(["no answer"] if None in given else [])])


def cost_summary(found: Sequence[Sequence[dict[str, Any]]]) -> str:
    """Median, 95th percentile and largest value of each code."""
    lines = []
    for name, share in (("median", 0.5), ("95 %", 0.95), ("largest", 1.0)):
        costs = [
            [float(np.quantile([run[k] for run in code], share)) for k in ("seconds", "peak_mb")]
            for code in zip(*found, strict=True)
        ]
        lines.append("  ".join([f"{name:28}", *(f"{s:7.2f} s {mb:5.0f} MB" for s, mb in costs)]))
    return "\n".join(lines)
