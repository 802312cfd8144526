"""Location of the gap: over frequency, motion, stroke, drive force and time, and by place of the axis."""

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.axis import Axis, joint_label, length_unit
from symid.diagnosis.effects.effect import ACTUATOR
from symid.diagnosis.findings.comparison import ENOUGH, Comparison
from symid.diagnosis.findings.gap import Location, MapCell
from symid.diagnosis.fitting.fit import Fit
from symid.text import moment
from symid.units import Unit

_BANDS = (0.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
_PARTS = 8
_SEGMENT = 2048  # rows of a segment of the power density
_AROUND_REVERSAL = 0.05  # s
_SLOW, _FAST, _ACCELERATING = 0.1, 0.5, 0.3  # shares of the top speed, and of the hardest acceleration
_MOST_OF_IT = 0.8  # share of the error
_UNEVEN = 2.0  # ratio of two mean squares from which on an error depends on the motion
_MOMENT = 0.1
"""Longest span of time, relative to the log, that is a moment of it."""
_CLEAR = 2.0
"""Least error, relative to the noise floor, whose moment is looked for."""


def maps(comparison: Comparison) -> Mapping[str, tuple[MapCell, ...]]:
    """The gap over ``band``, ``regime``, ``direction``, ``position``, ``drive force`` and ``time``."""
    axis, motion = comparison.record.dynamics.axis, _Motion(comparison)
    drive = axis.drives[comparison.drive]
    before, after = comparison.squares(1), comparison.squares(len(comparison.errors) - 1)
    return {
        "band": _by_band(comparison),
        "regime": _cells(before, after, motion.regimes()),
        "direction": _cells(before, after, motion.directions()),
        "position": _cells(before, after, _ranges(motion.position, length_unit(drive.at))),
        "drive force": _cells(before, after, _ranges(motion.force, axis.signal_units[drive.signal])),
        "time": _cells(before, after, _ranges(motion.time + comparison.record.log.start, Unit.of("s"))),
    }


class _Part(NamedTuple):
    """A part of the rows, with its limits where it is a range of a quantity."""

    label: str
    rows: BoolArray
    low: float = math.nan
    high: float = math.nan


class _Motion:
    """Motion of the axis at the kept rows."""

    def __init__(self, comparison: Comparison) -> None:
        record, kept = comparison.record, comparison.weighting.kept
        s, driven = 1j * record.omega, comparison.motion
        self.position = record.rows(driven)[kept]
        self.velocity = record.rows(s * driven)[kept]
        self.acceleration = record.rows(s**2 * driven * record.taper)[kept]
        self.force = np.abs(record.rows(comparison.measured * record.taper)[kept])
        self.time = record.row_time[kept]
        self.speed = np.abs(self.velocity)
        whole = record.rows(s * driven)
        turns = record.row_time[1:][
            np.diff(np.signbit(whole)) & (np.abs(whole[1:]) < 0.2 * self.speed.max(initial=0))
        ]
        nearest = np.searchsorted(turns, self.time)
        padded = np.concatenate([[-np.inf], turns, [np.inf]])
        self.from_reversal = np.minimum(self.time - padded[nearest], padded[nearest + 1] - self.time)

    def regimes(self) -> list[_Part]:
        """Regimes of motion; each row belongs to the first that applies."""
        top, hard = (
            self.speed.max(initial=0.0),
            np.quantile(np.abs(self.acceleration), 0.99) if self.speed.size else 0,
        )
        reversal = self.from_reversal < _AROUND_REVERSAL
        accelerating = ~reversal & (np.abs(self.acceleration) > _ACCELERATING * hard)
        rest = ~(reversal | accelerating)
        slow, fast = self.speed < _SLOW * top, self.speed > _FAST * top
        return [
            _Part("reversal", reversal),
            _Part("accelerating", accelerating),
            _Part("low speed", rest & slow, 0.0, _SLOW * top),
            _Part("medium speed", rest & ~slow & ~fast, _SLOW * top, _FAST * top),
            _Part("high speed", rest & fast, _FAST * top, top),
        ]

    def directions(self) -> list[_Part]:
        """Forward and backward motion."""
        forward = self.velocity > 0
        return [_Part("forward", forward), _Part("backward", ~forward)]


def _ranges(values: FloatArray, unit: Unit) -> list[_Part]:
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    edges = np.linspace(low, high, _PARTS + 1)
    place = np.clip(np.digitize(values, edges[1:-1]), 0, _PARTS - 1)
    return [
        _Part(f"{_rounded(a, edges)} to {_rounded(b, edges)} {unit}", place == i, float(a), float(b))
        for i, (a, b) in enumerate(pairwise(edges))
    ]


def _rounded(value: float, edges: FloatArray) -> str:
    """A limit, rounded to less than a tenth of the distance between two limits."""
    step = float(edges[1] - edges[0])
    return f"{round(value, 2 - math.ceil(math.log10(step))) + 0.0:.6g}" if step > 0 else f"{value:.3g}"


def _cells(before: FloatArray, after: FloatArray, parts: Iterable[_Part]) -> tuple[MapCell, ...]:
    chosen = [part for part in parts if np.any(part.rows)]
    excess = [max(float(np.sum(before[part.rows] - 1)), 0.0) for part in chosen]
    total = sum(excess) or 1.0
    return tuple(
        MapCell(
            label=part.label,
            low=part.low,
            high=part.high,
            samples=float(np.mean(part.rows)),
            share=over / total,
            before=float(np.sqrt(np.mean(before[part.rows]))),
            after=float(np.sqrt(np.mean(after[part.rows]))),
        )
        for part, over in zip(chosen, excess, strict=True)
    )


def _by_band(comparison: Comparison) -> tuple[MapCell, ...]:
    """Mean square of both errors by frequency band, in multiples of the noise."""
    models = (1, len(comparison.errors) - 1)
    (frequency, before), (_, after) = (_density(comparison, model) for model in models)
    used = frequency < 0.65 * comparison.record.band_hz
    frequency, before, after = frequency[used], before[used], after[used]
    bands = [
        _Part(f"{low:g} to {high:g} Hz", np.asarray((frequency >= low) & (frequency < high)), low, high)
        for low, high in pairwise(_BANDS)
    ]
    return _cells(before, after, bands)


def _density(comparison: Comparison, model: int) -> tuple[FloatArray, FloatArray]:
    """Power density of the error of a model, relative to noise."""
    frequency, power = comparison.power(model, _SEGMENT)
    return frequency, power * comparison.row_rate / 2 / comparison.kept_share * comparison.record.freedom


def joint_at(axis: Axis, place: str) -> str:
    """Name of the joint at a place of an effect: that in which a drive acts, or the place itself.

    >>> from symid import load_axis
    >>> joint_at(load_axis("direct_2m1s"), "actuator"), joint_at(load_axis("direct_2m1s"), "structure")
    ('motor', 'structure')
    """
    drives = (drive for drive in axis.drives if place in (ACTUATOR, drive.signal))
    return next((joint_label(drive.at) for drive in drives), place)


def located(found: Mapping[str, tuple[MapCell, ...]], shares: Mapping[str, float]) -> tuple[Location, ...]:
    """Places with their shares of the excess error, and the band and regime that hold most of it, if there is any."""
    bands, regimes = found["band"], found["regime"]
    if regimes and not any(cell.share for cell in regimes):
        return ()
    regime = max(regimes, key=lambda cell: cell.share).label if regimes else ""
    held = _narrowest(bands)
    ranked = sorted(shares.items(), key=lambda item: -item[1])
    return tuple(Location(place, share, held, regime) for place, share in ranked if share > 0.005)


def _narrowest(bands: tuple[MapCell, ...]) -> tuple[float, float]:
    """The shortest run of bands that holds most of the excess error."""
    runs = [
        (j - i, bands[i].low, bands[j].high)
        for i in range(len(bands))
        for j in range(i, len(bands))
        if sum(cell.share for cell in bands[i : j + 1]) >= _MOST_OF_IT
    ]
    return min(runs)[1:] if runs else (0.0, bands[-1].high if bands else 0.0)


def is_stationary(comparison: Comparison) -> bool:
    """Whether the error of the re-identified model is independent of the motion, as coloured noise is.

    Rows are split at the median speed, and at the median acceleration, of the driven joint, and the errors of both
    halves are compared. False with too few rows.
    """
    record, kept = comparison.record, comparison.weighting.kept
    if kept.sum() < ENOUGH:
        return False
    s, squares = 1j * record.omega, comparison.squares(1)
    for motion in (s * comparison.motion, s**2 * comparison.motion * record.taper):
        course = np.abs(record.rows(motion)[kept])
        lively = course > np.median(course)
        halves = np.mean(squares[lively]), np.mean(squares[~lively])
        if max(halves) > _UNEVEN * min(halves):
            return False
    return True


def momentary(comparison: Comparison, last: Fit) -> str:
    """Sentence if most of the error that the last model leaves belongs to a moment of the log; otherwise empty.

    A collision, an end stop or a drive that was switched off is not an effect of the whole log, and distorts the errors
    of all models, in the part on which they are compared or in that on which the last one was fitted.
    """
    training = Comparison(last.weighting, (last.state,), (last.left,), comparison.drive)
    return _moment_of(comparison) or _moment_of(training)


def _moment_of(comparison: Comparison) -> str:
    record, kept = comparison.record, comparison.weighting.kept
    time, squares = record.row_time[kept], comparison.squares(len(comparison.errors) - 1)
    if not np.mean(squares) > (_CLEAR * comparison.floor) ** 2:
        return ""
    # The shortest span with most of the excess: for each beginning, the first end that reaches it
    reached = np.concatenate([[0.0], np.cumsum(np.maximum(squares - comparison.floor**2, 0.0))])
    ends = np.searchsorted(reached, reached[:-1] + _MOST_OF_IT * reached[-1])
    begins = np.flatnonzero(ends < reached.size)
    spans = time[ends[begins] - 1] - time[begins]
    begin = int(begins[np.argmin(spans)])
    if not spans.min() < _MOMENT * np.ptp(time):
        return ""
    first, last = (float(at) + record.log.start for at in (time[begin], time[ends[begin] - 1]))
    return (
        f"Look at what happened between {moment(first, 4)} and {moment(last, 4)} s, where {100 * _MOST_OF_IT:.0f} % of "
        "the error that stays lies, or leave that part out with `trim`."
    )
