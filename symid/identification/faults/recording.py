"""Faults of recorders in a channel: values missing, held, wrapped around, limited in slope, too coarse.

Each check looks at the samples themselves, so that it needs no model, and counts what a machine does not do: a value
that is exactly 0 between two that are far from it, a sample that repeats the last one in the middle of a motion, many
steps of exactly the same largest size.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from symid.arrays import FloatArray, runs_of_true, unexplained_by
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.data.quality import FEWEST_LOST, dropped, is_switched, jumps_of, repeated, step_of
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.faults.smoothing import slow_update
from symid.identification.rows.excerpts import Excerpt
from symid.text import counted, moment

_SPAN = 8
"""Fewest equal samples that count as a held span."""
_ALIKE, _MOSTLY = 0.01, 0.5
"""Share of samples outside held spans that may repeat the last one, and share that held spans may be."""
_ROUGH, _ROUNDING = 0.6, 1e-9
"""Share of fourth differences that change sign, 0.8 of white noise; and their part of the signal by rounding."""
_BENDS = 0.25
"""Change of an acceleration within a span, over its rms along the log, during which no force stays the same."""
_JUMP = 2.0
"""Times the usual steps that a reading catches up with at the end of a held span."""
_FEW_TURNS = 30
"""Samples of the sharpest turns of a reading that are compared with the forces, where a hundredth are less."""
_UNDRIVEN = 0.1
"""Part of the power of these turns that forces leave of an acceleration at most."""
_WRAPPED = 0.8
"""Step in one sample, over the range, that counts as a wrap; a reversal of force and friction makes half at most."""
_USUAL_STEP = 0.2
"""Size, over the range, that most steps of a channel must not exceed for a jump to stand out."""
_SAME = 1e-6
"""Relative difference of two steps that count as of the same size."""
_BEYOND_STEPS = 5.0
"""Largest error, in steps of the force, that the steps can explain."""
_LIMITED_SHARE = 0.01
"""Share of steps of the largest size in a slew-limited channel; with noise no two steps are equal."""


def recording_fault(model: GeneratedModel, parts: Sequence[Excerpt], fit: LeastSquares) -> str:
    """Statement on the fault of a channel; empty without one. Friction in the fit decides which steps are coarse."""
    for part in parts:
        mover = part.log[model.most_differentiated]
        for name in model.highest_derivatives:
            x, is_force = part.log[name], name in model.forces
            if is_force and is_switched(x):
                continue
            if not is_force and (spikes := _undriven(model, part.log, name)):
                k = spikes[0]
                return (
                    f"{name} jumps by {x[k] - x[k - 1]:.3g} and back within a sample at t = "
                    f"{moment(part.log.time[k])} s, as no machine moves ({counted(len(spikes), 'time')}): cut that "
                    "out, or repair the channel"
                )
            slow = slow_update(x, name)
            if (fault := channel_fault(x, name, is_force=is_force)) or (slow and not is_force):
                return slow or fault
            if held := held_fault(x, name, mover if is_force else None):
                return held
    return _coarse_force(model, [part.log for part in parts], fit)


def channel_fault(
    x: FloatArray, name: str, dead_share: float = CRITERIA.dead_share, *, is_force: bool = True
) -> str:
    """Statement on a fault of the samples of a channel; empty without one.

    >>> x = np.sin(np.arange(4000) / 50) + 1e-6 * np.random.default_rng(0).standard_normal(4000)
    >>> channel_fault(x, "F")
    ''
    >>> channel_fault(np.where(np.arange(4000) % 37, x, 0.0), "F")[:38]
    'F is exactly 0 in 95 single samples be'
    """
    if is_force and is_switched(x):
        return ""
    most = max(FEWEST_LOST, dead_share * x.size)
    if (lost := int(np.count_nonzero(dropped(x)))) >= most:
        return f"{name} is exactly 0 in {lost} single samples between others: samples were lost and filled with 0"
    if (again := int(np.count_nonzero(repeated(x)))) >= most:
        return (
            f"{name} repeats the last value in {again} samples ({100 * again / x.size:.2g} %) while it moves: "
            "samples were lost and held, or the channel is updated more rarely than it is recorded"
        )
    if (wrapped := _wrapped(x)) >= FEWEST_LOST:
        return f"{name} jumps across its whole range {wrapped} times: its number overflows"
    if is_force and (limited := _slew_limited(x)) > _LIMITED_SHARE:  # a position does so at constant speed
        share = f"{100 * limited:.2g} %"
        return f"{name} changes by exactly its largest step in {share} of the samples: its slope is limited"
    return ""


def held_fault(x: FloatArray, name: str, mover: FloatArray | None) -> str:
    """Statement on spans in which a channel keeps one value while the axis moves; empty without them.

    The mover is the position beside which a force is judged; a reading is judged alone.
    """
    if not (held := _held(x, mover)):
        return ""
    return (
        f"{name} keeps exactly one value over {held} spans of {_SPAN} samples and more while the axis moves: samples "
        "were lost and held or set to a value; cut those parts out"
    )


def _held(x: FloatArray, mover: FloatArray | None) -> int:
    """Spans in which a channel keeps one value inside its range, while it hardly ever repeats one elsewhere.

    A span of a force counts if the mover moves as usual, and the force is noisy or the acceleration changes; a span of
    a reading counts if it ends with a jump larger than any other.
    """
    step = np.diff(x)
    spans = runs_of_true(step == 0.0)
    spans = spans[(spans[:, 1] - spans[:, 0] >= _SPAN - 1) & (spans[:, 1] < step.size)]
    length = spans[:, 1] - spans[:, 0]
    # A coarse or slow channel repeats values everywhere: spans count only where other repetitions are rare.
    alike = np.count_nonzero(step == 0.0) - int(length.sum())
    if len(spans) < FEWEST_LOST or alike > _ALIKE * x.size or length.sum() > _MOSTLY * x.size:
        return 0
    inside = (x[spans[:, 0]] > x.min()) & (x[spans[:, 0]] < x.max())
    free = np.ones(step.size, dtype=bool)
    for start, stop in spans:
        free[start : stop + 1] = False
    usual = step[free]
    if mover is None:
        odd = np.abs(step[spans[:, 1]]) > _JUMP * np.quantile(np.abs(usual), 0.99)
    else:
        rough = np.diff(x, 4)[free[3:]]
        is_noise = np.median(np.abs(rough)) > _ROUNDING * np.sqrt(np.mean(x**2))
        pace = np.array([np.sqrt(np.mean((mover[k:] - mover[:-k]) ** 2)) for k in length])
        odd = np.abs(mover[spans[:, 1]] - mover[spans[:, 0]]) > 0.25 * pace
        if not is_noise or np.mean(rough[1:] * rough[:-1] < 0.0) < _ROUGH:
            odd &= [_bends(mover, *span) for span in spans]
    count = int(np.count_nonzero(inside & odd))
    return count if count >= FEWEST_LOST else 0


def _bends(mover: FloatArray, start: int, stop: int) -> bool:
    """Whether the acceleration of the mover changes within a span: a drive that follows no noise must do so as well.

    It is the second difference over a quarter of the span, in which the noise of an encoder hardly counts.
    """
    k = max((stop - start) // 4, 1)
    bent = mover[2 * k :] - 2.0 * mover[k:-k] + mover[: -2 * k]
    return bool(np.ptp(bent[start : stop - 2 * k + 1]) > _BENDS * np.sqrt(np.mean(bent**2)))


def _undriven(model: GeneratedModel, log: Log, name: str) -> list[int]:
    """Spikes of a reading, none where its sharpest turns follow those of the forces at once, as accelerations do.

    The first sensor of an axis closes its loop: there it is the force that follows.
    """
    spikes = _spikes(x := log[name])
    if not spikes or name == model.measured[0]:
        return spikes
    forces, turns = np.stack([log[force] for force in model.forces], axis=1), np.diff(x, 2)
    sharpest = np.abs(turns) >= np.sort(np.abs(turns))[-max(_FEW_TURNS, turns.size // 100) :][0]
    made, seen = np.diff(forces, 2, axis=0)[sharpest], turns[sharpest]
    left = unexplained_by(made, seen)
    return spikes if left @ left > _UNDRIVEN * (seen @ seen) else []


def _spikes(x: FloatArray) -> list[int]:
    """Samples to which a reading jumps, and from which it jumps back.

    >>> _spikes(np.sin(np.arange(99) / 9) + 5.0 * (np.arange(99) == 40) + 3.0 * (np.arange(99) > 70))
    [40]
    """
    jumps, step = jumps_of(x), np.diff(x)
    return [k for k, after in pairwise(jumps) if after == k + 1 and step[k - 1] * step[k] < 0.0]


def _wrapped(x: FloatArray) -> int:
    """Jumps across the whole range of a channel that goes on beyond, unlike a force switched between its limits.

    Before and after an overflow the channel moves against the jump.
    """
    reach, step = float(np.ptp(x)), np.diff(x)
    jumps = np.flatnonzero(np.abs(step) > _WRAPPED * reach)
    if reach == 0.0 or not jumps.size or float(np.quantile(np.abs(step), 0.98)) > _USUAL_STEP * reach:
        return 0
    inside = jumps[(jumps > 0) & (jumps < step.size - 1)]
    goes_on = (step[inside - 1] * step[inside] < 0.0) & (step[inside + 1] * step[inside] < 0.0)
    return jumps.size if 2 * np.count_nonzero(goes_on) > jumps.size else 0


def _slew_limited(x: FloatArray) -> float:
    """Share of steps that are as large as the largest, of a channel whose values are not coarse."""
    step = np.abs(np.diff(x))
    largest = float(step.max(initial=0.0))
    share = float(np.mean(step > largest * (1.0 - _SAME)))
    return 0.0 if largest == 0.0 or share <= _LIMITED_SHARE or step_of(x) > 0.0 else share


def _coarse_force(model: GeneratedModel, logs: Sequence[Log], fit: LeastSquares) -> str:
    """Statement on a force whose steps are not small against friction and the error of the fit; empty for others."""
    steps = (
        (step_of(log[force]), force) for log in logs for force in model.forces if not is_switched(log[force])
    )
    step, force = max(steps, default=(0.0, ""))
    if float(fit.sigma_rho_equation[0]) > _BEYOND_STEPS * step:
        return ""
    laws = {parameter for _, parameter in model.law_columns}
    units = list(model.minimal_units.items())
    output_unit = model.output_units[0] if model.output_units else ""
    for j in sorted(laws):
        name, unit = units[j]
        level = abs(float(fit.solution[j]))
        if unit == output_unit and step / 2 > CRITERIA.step_share * level:
            return (
                f"{force} is recorded in steps of {step:.3g}, {100 * step / max(level, 1e-300):.2g} % of the "
                f"friction {name}: record it with more digits"
            )
    return ""
