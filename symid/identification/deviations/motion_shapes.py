"""Courses of the forces that small unmodelled effects make along a measured motion, at the rows of an estimate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.identification.criteria import CRITERIA
from symid.identification.rows.coulomb import direction
from symid.identification.rows.excerpts import Excerpt, running_integral
from symid.identification.rows.observation import sliding_velocities
from symid.signal_names import derivative_name

_WIDTHS = (0.05, 0.2)
"""Speeds, over the highest one, within which friction decays."""
_PATHS = (0.03, 0.1)
"""Distances after a reversal, over the stroke, within which friction builds up."""
QUARTER = "cogging a quarter further"
"""Name of cogging a quarter of a period away from that which is named alone."""
FRICTION = "Coulomb friction", "viscous friction"
"""Names of the laws of friction that models have as a rule."""
OF_ACCELERATION = "friction with the load", "a spring that is not linear", "play"
"""Beginnings of the names of effects whose courses hold the noise of the acceleration, as W does."""
_SMOOTH = "a constant force", "a force with the position"
"""Names of the courses that have neither jumps nor kinks."""
_MOST_PERIODS, _STEP = 120.0, 0.5
"""Periods of cogging along the stroke that are tried: the most, and their step."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of the first joint with friction at the rows of a part of a log, as `speeds_of`."""

    velocity: FloatArray
    position: FloatArray  # from its mean
    period: float  # time between two rows, s
    time: FloatArray  # of the rows, s

    @classmethod
    def of(cls, part: Excerpt) -> Motion:
        """Motion of a part whose model `has_speeds`."""
        seen, log = part.observation, part.log
        velocity = np.interp(
            seen.time, log.start + log.sampling_period * np.arange(log.n_samples), speeds_of(part)
        )
        period = (seen.time[-1] - seen.time[0]) / max(seen.time.size - 1, 1)
        position = running_integral(velocity, period)
        return cls(velocity, position - np.mean(position), period, seen.time)


def has_speeds(model: GeneratedModel) -> bool:
    """Whether a model has Coulomb friction, or a position whose velocity is that of a joint."""
    return any(model.sliding) or model.highest_derivatives[model.most_differentiated] > 0


def speeds_of(part: Excerpt) -> FloatArray:
    """First sliding velocity at every sample of a part; without Coulomb friction that of the scale."""
    model, chosen = part.model, replace(part.observation.preparation, trim=None)
    if not any(model.sliding):
        velocity = derivative_name(model.most_differentiated, 1)
        model = replace(model, signals=(velocity,), sliding_velocities=lambda v: v[None])
    return part.kept("speeds", lambda: sliding_velocities(model, part.log, chosen)[0])


def decaying(velocity: FloatArray, highest: float) -> dict[str, FloatArray]:
    """Friction that decays exponentially with the speed, within parts of the highest one."""
    sign, speed = direction(velocity), np.abs(velocity) / highest
    return {
        f"friction at less than {100 * width:g} % of the speed": sign * np.exp(speed / -width)
        for width in _WIDTHS
    }


def shapes_of(motion: Motion, drive: FloatArray | None = None, middle: float = 0.0) -> dict[str, FloatArray]:
    """Courses of the forces of typical effects at the drive, whose force is given, or of those that may act elsewhere.

    `middle` is the time at which friction that drifts is as estimated.
    """
    velocity, sign = motion.velocity, direction(motion.velocity)
    highest = float(np.max(np.abs(velocity))) or 1.0
    stroke = float(np.ptp(motion.position)) or 1.0
    acceleration = np.gradient(velocity, motion.period)
    load = acceleration / (float(np.max(np.abs(acceleration))) or 1.0)
    # way since the last reversal
    path = np.cumsum(np.abs(velocity)) * motion.period
    turned = np.where(np.diff(sign, prepend=sign[0]) != 0.0, path, 0.0)
    since = (path - np.maximum.accumulate(turned)) / stroke
    found = decaying(velocity, highest) | {
        "friction with the square of the speed": velocity * np.abs(velocity) / highest**2,
        "friction that builds up after reversals": sign * np.exp(-since / _PATHS[0]),
        "friction with the load": np.abs(load if drive is None else drive) * sign,
        "a spring that is not linear": load * np.abs(load),
        "play": np.sign(load),
    }
    if drive is None:
        return found | {"Coulomb friction": sign}
    return found | {
        "Coulomb friction": sign,
        "viscous friction": velocity / highest,
        "Coulomb friction that drifts": sign * (motion.time - middle),
        "viscous friction that drifts": velocity * (motion.time - middle) / highest,
        "friction that builds up along the stroke": sign * np.exp(-since / _PATHS[1]),
        "viscous friction that differs by direction": np.abs(velocity) / highest,
        "a constant force": np.ones_like(velocity),
        "a force with the position": motion.position / stroke,
    }


def waves(motions: Sequence[Motion], rests: Sequence[FloatArray]) -> list[dict[str, FloatArray]]:
    """Cogging of the pitch and phase that explain most of what is left of the rows of each motion, 0 where not used."""
    stroke = max(float(np.ptp(motion.position)) for motion in motions) or 1.0
    rest = np.concatenate(rests)
    used = rest != 0.0
    rest, position = rest[used], np.concatenate([m.position for m in motions])[used]
    # waves of 4, 5 ... steps along the stroke: products of few short ones and few long ones
    turns, n = 2j * np.pi * _STEP / stroke * position, math.isqrt(round(_MOST_PERIODS / _STEP) - 1) + 1
    short, long = (np.exp(np.outer(steps, turns)) for steps in (np.arange(4, 4 + n), n * np.arange(n)))
    powers = np.abs((long * rest) @ short.T).ravel()[: round(_MOST_PERIODS / _STEP)]
    pitch = stroke / (_STEP * (4 + int(np.argmax(powers))))
    phase = 2 * np.pi * position / pitch
    cosine, sine = np.linalg.lstsq(np.stack([np.cos(phase), np.sin(phase)], axis=1), rest, rcond=None)[0]
    phases = [2 * np.pi * m.position / pitch - np.arctan2(sine, cosine) for m in motions]
    # the second one is what another phase beside the columns of the model needs
    return [{"cogging": np.cos(phase), QUARTER: np.sin(phase)} for phase in phases]


def least_resolved(names: Sequence[str]) -> FloatArray:
    """Part of the power of each column, by its name, that rounding and filters leave where the model explains it."""
    return np.where(np.isin(names, _SMOOTH), CRITERIA.resolved_smooth, CRITERIA.resolved)
