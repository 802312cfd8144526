"""Spans in which a channel of a log is stuck or clipped.

They are notes, not faults: whether they do harm depends on the use of the log. A machine at rest must not raise a note.
A position counts as stuck only if something that follows it moves meanwhile, or if it jumps when it comes free.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.data.columns import REFERENCE
from symid.data.quality.lost_samples import step_of
from symid.text import counted, moment

_STUCK_SAMPLES: Final = 20  # shortest run of equal values that can be called stuck
_CLIPPED_SAMPLES: Final = 5  # shortest run at an extreme value that can be called clipped
_USUAL_RUNS: Final = 10  # times the median run: coarse encoders and slow controllers repeat values by nature
_TRAVEL: Final = 0.05  # of its whole range, by which another position moves in a span that is not at rest
_TOGETHER: Final = 0.9  # least correlation of two positions that move together
_CLIPPED_SHARE: Final = 0.001  # of all samples: the least for a note on a clipped force
_FEW_STEPS: Final = 10  # changes of a force that are a sequence of steps
# change that is a step, and scatter between steps that is noise alone, in its standard deviations
_STEP_IN_NOISE, _STEADY_IN_NOISE = 8.0, 1.5
_FIRST_LOOK: Final = 1000  # samples that are looked at before all of them


@dataclass(frozen=True)
class _Runs:
    """Runs of equal neighbouring samples: sample at which each starts, and number of its samples."""

    start: npt.NDArray[np.intp]
    length: npt.NDArray[np.intp]

    @classmethod
    def of(cls, x: FloatArray) -> _Runs:
        start = np.concatenate(([0], np.flatnonzero(x[1:] != x[:-1]) + 1))
        return cls(start, np.diff(start, append=x.size))

    def longer(self, samples: float) -> _Runs:
        """Runs of at least a number of samples."""
        return self.only(self.length >= samples)

    def only(self, keep: npt.NDArray[np.bool_]) -> _Runs:
        return _Runs(self.start[keep], self.length[keep])

    @property
    def none(self) -> _Runs:
        """An empty set of runs."""
        return _Runs(self.start[:0], self.length[:0])


@np.errstate(over="ignore", invalid="ignore")  # damaged numbers may be near the end of the range
def inspect_spans(
    time: FloatArray, signals: Mapping[str, FloatArray], positions: Collection[str]
) -> tuple[str, ...]:
    """Notes on spans in which a channel is stuck at a value or clipped at the end of its range.

    `positions` are the positions and angles among the signals: they rest when the machine rests. The commanded position
    shows that it moves, and is not checked. No channel has missing values.
    """
    moving = {name: x for name, x in signals.items() if name in positions or name.startswith(REFERENCE)}
    notes = []
    for name, x in signals.items():
        if name.startswith(REFERENCE):
            continue
        runs = _Runs.of(x)
        if np.max(runs.length) < _CLIPPED_SAMPLES:
            continue
        usual = float(np.median(runs.length))
        extreme = _extreme(x, runs)
        clipped = runs.only(extreme).longer(max(_CLIPPED_SAMPLES, 3.0 * usual))
        long = runs.only(~extreme).longer(max(_STUCK_SAMPLES, _USUAL_RUNS * usual))
        if name in positions:
            clipped = _cut_in_motion(x, clipped)
            long = runs.longer(max(_STUCK_SAMPLES, _USUAL_RUNS * usual)) if not clipped.start.size else long
            stuck = _left_behind(x, long, [y for name_beside, y in moving.items() if name_beside != name])
        else:
            clipped = clipped.only(x[clipped.start] != 0.0)  # 0 is the value of a drive at rest and no limit
            clipped = clipped.only(~_between_steps(x, clipped))
            if places := [y for name_beside, y in signals.items() if name_beside in positions]:
                # the output of a controller between two counts is not a limit either
                clipped = clipped.only(_travels(clipped, places, 0.0))
            if is_switched(x) or np.sum(clipped.length) < max(2 * _CLIPPED_SAMPLES, _CLIPPED_SHARE * x.size):
                clipped = clipped.none
            mostly = 2 * np.sum(long.length) > x.size  # then the channel repeats values by nature
            stuck = long.none if mostly else long.only(_travels(long, list(moving.values()), _TRAVEL))
            stuck = stuck.only(~_between_steps(x, stuck))
        if clipped.start.size:
            notes.append(f"{name!r} is clipped at the end of its range{_spans(time, clipped)}")
        if stuck.start.size:
            notes.append(f"{name!r} keeps exactly one value while the machine moves{_spans(time, stuck)}")
    return tuple(notes)


def cut_in_motion(x: FloatArray) -> int:
    """Samples in which a signal of motion is clipped at the end of its range, which it reached at speed.

    Examples
    --------
    >>> cut_in_motion(np.clip(np.sin(np.arange(200) / 10), -0.8, 1.0))
    39
    """
    runs = _Runs.of(x)
    long = runs.only(_extreme(x, runs)).longer(max(_CLIPPED_SAMPLES, 3.0 * float(np.median(runs.length))))
    return int(np.sum(_cut_in_motion(x, long).length))


def is_switched(force: FloatArray, noise: float = 0.0) -> bool:
    """Whether a force is switched: a relay or binary sequence with two levels and 0 at rest, or a few steps.

    A small force that is coarsely rounded also has two levels and 0, but changes often. `noise` is the standard
    deviation of noise on a force of a few steps.

    >>> is_switched(np.array([0.0, 4.0, 4.0, -4.0, 4.0])), is_switched(np.tile([0.0, 1.0, 0.0, -1.0], 9))
    (True, False)
    >>> noisy = np.repeat([0.0, 4.0, -4.0], 50) + 0.1 * np.random.default_rng(0).standard_normal(150)
    >>> is_switched(noisy), is_switched(noisy, 0.1), is_switched(noisy + np.linspace(0, 3, 150), 0.1)
    (False, True, False)
    """
    if noise > 0.0 and _is_of_noisy_steps(force, noise):
        return True
    if np.unique(force[:: max(force.size // _FIRST_LOOK, 1)]).size > _FEW_STEPS + 1:
        return False
    levels, steps = np.unique(force), np.abs(np.diff(force))
    changes = steps[steps > 0]
    across = bool(changes.size) and 2 * np.mean(changes == np.ptp(levels)) >= 1.0
    two = levels.size == 2 or (levels.size == 3 and 0.0 in levels and across)
    return bool(two or 0 < changes.size <= _FEW_STEPS)


def _is_of_noisy_steps(force: FloatArray, noise: float) -> bool:
    """Whether a force is constant but for a few steps and noise of a standard deviation."""
    steps = np.flatnonzero(np.abs(np.diff(force)) > _STEP_IN_NOISE * noise) + 1
    if not 0 < steps.size <= _FEW_STEPS:
        return False
    rest = np.concatenate([level - np.mean(level) for level in np.split(force, steps)])
    return float(np.std(rest)) < _STEADY_IN_NOISE * noise


def _extreme(x: FloatArray, runs: _Runs) -> npt.NDArray[np.bool_]:
    return np.asarray((x[runs.start] == x.max()) | (x[runs.start] == x.min()))


def _cut_in_motion(x: FloatArray, runs: _Runs) -> _Runs:
    """Runs that a position enters and leaves at speed: its range ended before the motion did."""
    if not runs.start.size:
        return runs
    # Over several changes of value: a single encoder count is not a speed, and the step into a run is truncated.
    span = 2 + 2 * int(np.ceil(np.median(_Runs.of(x).length)))
    moved = np.abs(x[span:] - x[:-span])
    if not moved.size:
        return runs.none
    fast = max(0.3 * float(np.quantile(moved, 0.95)), 1.5 * step_of(x))
    stop = runs.start + runs.length
    entered = (runs.start > span) & (moved[np.clip(runs.start - 1 - span, 0, moved.size - 1)] > fast)
    left = np.where(stop + span < x.size, moved[np.minimum(stop, moved.size - 1)] > fast, True)
    return runs.only(entered & left)


def _left_behind(x: FloatArray, runs: _Runs, others: list[FloatArray]) -> _Runs:
    """Runs of a position during which another that moves with it travels, or at whose end it jumps.

    A deflection, or a body that swings on a spring, moves also while the position rests.
    """
    if not runs.start.size:
        return runs
    stop = runs.start + runs.length
    step = np.abs(np.diff(x))
    inner = stop[stop < x.size] - 1
    jumps = np.zeros(runs.start.size, dtype=np.bool_)
    usual = step.copy()
    usual[inner] = 0.0
    jumps[stop < x.size] = step[inner] > 2.0 * float(usual.max())
    outside = np.ones(x.size, dtype=np.bool_)
    for start, end in zip(runs.start, stop, strict=True):
        outside[start:end] = False
    together = [y for y in others if _correlation(x[outside], y[outside]) > _TOGETHER]
    return runs.only(jumps | _travels(runs, together, _TRAVEL))


def _correlation(x: FloatArray, y: FloatArray) -> float:
    """Absolute correlation of two signals; 0 where one does not change."""
    changes = x.size > 1 and np.ptp(x) > 0.0 and np.ptp(y) > 0.0
    return abs(float(np.corrcoef(x, y)[0, 1])) if changes else 0.0


def _between_steps(x: FloatArray, runs: _Runs) -> npt.NDArray[np.bool_]:
    """Runs that a coarse signal enters and leaves by a single step, as at constant speed."""
    step = step_of(x) if runs.start.size else 0.0
    change = np.abs(np.diff(x, prepend=x[0], append=x[-1]))
    return np.asarray(np.maximum(change[runs.start], change[runs.start + runs.length]) < 1.5 * step)


def _travels(runs: _Runs, positions: list[FloatArray], share: float) -> npt.NDArray[np.bool_]:
    """Whether a position travels more than a share of its range in each run."""
    ranges = [float(np.ptp(y)) for y in positions]
    return np.array(
        [
            any(
                np.ptp(y[start : start + length]) > share * whole
                for y, whole in zip(positions, ranges, strict=True)
                if whole > 0.0
            )
            for start, length in zip(runs.start, runs.length, strict=True)
        ],
        dtype=np.bool_,
    )


def _spans(time: FloatArray, runs: _Runs) -> str:
    longest = int(np.argmax(runs.length))
    first = int(runs.start[longest])
    span = f"from t = {moment(time[first])} s to {moment(time[first + runs.length[longest] - 1])} s"
    times = f" ({runs.start.size} times, longest {span})" if runs.start.size > 1 else f" {span}"
    return f"{times}, {counted(int(np.sum(runs.length)), 'sample')} in all"
