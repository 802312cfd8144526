"""Time stepping with friction that sticks and slips.

Between two events the motion is linear, and is advanced exactly by a matrix exponential (`Flow`). An event is the
moment at which a sliding joint comes to rest, or the force on a resting joint leaves the range that its law can
hold: Coulomb friction is set-valued at rest, without any smoothing. Events are located within a step to rounding, as
roots of the Taylor series of the motion.

Laws that depend on displacement or speed otherwise (a sine, a cube, a friction that falls with speed) act as a force
that is constant over a step, taken at its midpoint (exponential midpoint rule, second order).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.flow import ORDER
from symid.simulation.mode import StickSlipMode, StickSlipModes
from symid.simulation.plant import Plant

MOST_EVENTS = 100
"""Most events in one step; the rest of the step ignores further ones (Zeno behaviour)."""
_POWERS = np.arange(ORDER)
MOST_TRIALS, SHARP = 100, 2.3e-16
"""Most Newton iterations for an event, and the change, relative to the step, at which they end."""


@dataclass(eq=False)
class Engine:
    """State of a simulated axis, advanced step by step.

    Parameters
    ----------
    plant : Plant
        The axis.
    state : array of shape (2 n,)
        Displacements and velocities; at rest at zero by default.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation.forward_dynamics import plant_of
    >>> plant = plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 4.0})
    >>> engine = Engine(plant, np.array([0.0, 1.0]))
    >>> engine.advance(0.0, 0.75)
    >>> engine.state.tolist()
    [0.25, 0.0]
    """

    plant: Plant
    state: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if self.state.size == 0:
            self.state = np.zeros(2 * len(self.plant.bodies))
        self._modes = StickSlipModes(self.plant)
        self.mode = self._modes.of(self._modes.start(self.state))

    @property
    def impulses(self) -> list[FloatArray]:
        """For each law the change of velocities by an impulse in its joint that changes its own velocity by 1."""
        return self._modes.impulses

    def mode_of(self, signs: tuple[float, ...]) -> StickSlipMode:
        """The mode with these signs of all laws."""
        return self._modes.of(signs)

    def advance(self, forces: float | Sequence[float] | FloatArray, duration: float) -> None:
        """Advance by a duration under a constant drive force, or one for each drive."""
        drives = np.atleast_1d(forces)
        if self._advance_smoothly(drives, duration):
            return
        # Joints that stuck at the last event may break loose under the new force before any time passes.
        drive = self.plant.drives @ drives
        self._release(drive)
        left, events = duration, 0
        while left > 0 and events < MOST_EVENTS:
            made, is_event = self._until_event(drive, left)
            left, events = left - made, events + is_event
        if left > 0:
            self.state = self.mode.flow.advance(self.state, drive + self.mode.force(self.state), left)

    def acceleration(self, forces: float | Sequence[float] | FloatArray) -> FloatArray:
        """Accelerations of the bodies under a drive force, or one for each drive; of shape (n,)."""
        drive = self.plant.drives @ np.atleast_1d(forces)
        self._release(drive)
        return self.mode.flow.acceleration(self.state, drive + self.mode.force(self.state))

    def _advance_smoothly(self, drives: FloatArray, duration: float) -> bool:
        """Advance, unless a sliding joint turns or a stuck one breaks loose; return whether the state advanced."""
        mode, start = self.mode, self.state
        if mode.varying:
            return False
        transition, gain = mode.flow.transition(duration)
        end = transition @ start + ((gain @ self.plant.drives) @ drives + gain @ mode.constant)
        if mode.sliding and (mode.speeds @ end).min() < 0:
            return False
        if mode.flow.stuck:
            force = self.plant.drives @ drives + mode.constant
            if any(self._excess(start, force)) or any(self._excess(end, force)):
                return False
        self.state = end
        return True

    def _set_sign(self, joint: int, sign: float) -> None:
        signs = self.mode.signs
        self.mode = self._modes.of((*signs[:joint], sign, *signs[joint + 1 :]))

    def _release(self, drive: FloatArray) -> None:
        """Release the joints that their laws cannot hold, one at a time, the largest excess first."""
        # Each release changes the forces on the joints that still stick: these are computed again before the next one.
        while stuck := self.mode.flow.stuck:
            excess = self._excess(self.state, drive + self.mode.force(self.state))
            worst = max(range(len(stuck)), key=lambda i: abs(excess[i]))
            if excess[worst] == 0:
                return
            self._set_sign(stuck[worst], math.copysign(1.0, excess[worst]))

    def _excess(self, state: FloatArray, force: FloatArray) -> list[float]:
        """Excess of the force on each stuck joint over the range that its law can hold; 0 inside the range."""
        if not self.mode.flow.stuck:
            return []
        needed, limits = self.mode.flow.holding_forces(state, force), self.mode.limits(state)
        pairs = zip(needed.tolist(), limits.tolist(), strict=True)
        return [max(held - high, 0.0) + min(held - low, 0.0) for held, (low, high) in pairs]

    def _until_event(self, drive: FloatArray, duration: float) -> tuple[float, bool]:
        """Advance to the next event, at most by a duration; return the time advanced and whether there was an event."""
        # Within a mode the motion is a Taylor series in time. A sliding joint's speed and a stuck joint's margin are
        # linear in the state, so each event is the first zero of a polynomial. It is sought only if the sign at the
        # end of the step shows that it was passed; the state at the earliest zero then begins the next mode.
        mode, start = self.mode, self.state
        made = min(duration, mode.flow.reach)
        force = drive + mode.force(start)
        if mode.varying:
            force = drive + mode.force(mode.flow.advance(start, force, made / 2))
        series, whole = mode.flow.series(start, force), made / mode.flow.reach
        end = _value(series, whole)
        events = []
        for joint, row in zip(mode.sliding, mode.speeds, strict=True):
            if row @ end < 0:
                events.append((_first_zero(series @ row, whole), joint, 0.0))
        for i, excess in enumerate(self._excess(end, force)):
            if excess:
                sign = math.copysign(1.0, excess)
                margin = self._margin(mode, i, sign, series, force)
                events.append((_first_zero(margin, whole), mode.flow.stuck[i], sign))
        if not events:
            self.state = end
            return made, False
        time, joint, sign = min(events)
        self.state = _value(series, time)
        if sign == 0.0:
            self.state = self._modes.at_rest(self.state, joint)
        self._set_sign(joint, sign)
        self._release(drive)
        return time * mode.flow.reach, True

    def _margin(
        self, mode: StickSlipMode, i: int, sign: float, series: FloatArray, force: FloatArray
    ) -> FloatArray:
        """Taylor series of the margin between a stuck joint's force and the limit that it exceeds."""
        row = mode.flow.holding_rows[i]
        margin = -sign * (series @ row[: series.shape[1]])
        limit = mode.limits(series[0])[i, 1 if sign > 0 else 0]
        margin[0] += sign * (limit - row[series.shape[1] :] @ force)
        return np.asarray(margin)


def _value(series: FloatArray, time: float) -> FloatArray:
    return np.asarray(time**_POWERS @ series)


def _first_zero(series: FloatArray, end: float) -> float:
    """Zero of a polynomial that is negative at `end`, by Newton's method within a bracket; 0 if it starts negative.

    >>> _first_zero(np.array([1.0, 0.0, -4.0]), 1.0), _first_zero(np.array([0.0, -1.0]), 1.0)
    (0.5, 0.0)
    """
    coefficients = series[::-1].tolist()
    if coefficients[-1] <= 0:
        return 0.0
    # Newton's method from the end; a step that leaves the bracket [low, high] of the zero is replaced by bisection.
    low, high, time = 0.0, end, end
    for _ in range(MOST_TRIALS):
        value = slope = 0.0
        for coefficient in coefficients:
            slope = slope * time + value
            value = value * time + coefficient
        low, high = (time, high) if value > 0 else (low, time)
        change = -value / slope if slope < 0 else low + high
        if abs(change) <= SHARP * end:
            break
        time = time + change if low < time + change < high else (low + high) / 2
    return time
