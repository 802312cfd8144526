"""Time stepping with friction that sticks and slips.

Between two events the motion is linear, and is advanced exactly by a matrix exponential (`Flow`). An event is the
moment at which a sliding joint comes to rest, or the force on a resting joint leaves the range that its law can
hold: Coulomb friction is set-valued at rest, without any smoothing. Events are located within a step to rounding.

Laws that depend on displacement or speed otherwise (a sine, a cube, a friction that falls with speed) act as a force
that is constant over a step, taken at its midpoint (exponential midpoint rule, second order).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

from symid.arrays import FloatArray
from symid.simulation.flow import Flow
from symid.simulation.plant import JUST_MOVING, LawFunction, Plant

_MOST_EVENTS = 100
"""Events in one step, after which the rest of the step is made without further ones (Zeno's chattering)."""


@dataclass(frozen=True, eq=False)
class _SmoothStep:
    """One step without events: matrix of the state, effect of the drive force and of all constant forces.

    `speeds` times the state are the velocities of the joints that slide, positive while they keep their direction;
    `holding` times the state, with the effects of the forces, are those on the stuck joints, between their limits.
    """

    transition: FloatArray
    drive: FloatArray
    offset: FloatArray
    speeds: FloatArray
    holding: FloatArray
    holding_drive: FloatArray
    holding_offset: FloatArray
    lowest: FloatArray
    highest: FloatArray

    def holds(self, state: FloatArray, drive_force: float) -> bool:
        """Whether no stuck joint breaks loose."""
        if not self.lowest.size:
            return True
        force = self.holding @ state + self.holding_drive * drive_force + self.holding_offset
        return bool((force >= self.lowest).all() and (force <= self.highest).all())


@dataclass(eq=False)
class Engine:
    """State of a simulated axis, advanced step by step.

    Parameters
    ----------
    plant : Plant
        The axis.
    state : array of shape (2 n,)
        Displacements and velocities; at rest at zero by default.
    """

    plant: Plant
    state: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        n = len(self.plant.bodies)
        if self.state.size == 0:
            self.state = np.zeros(2 * n)
        self._n = n
        self._flows: dict[tuple[int, ...], Flow] = {}
        self._steps: dict[tuple[float, ...], _SmoothStep] = {}
        self._holding = [j for j, law in enumerate(self.plant.laws) if law.can_hold]
        self._varying = [j for j, law in enumerate(self.plant.laws) if not _is_constant(law.force)]
        self._sign = [float(np.sign(self._velocity(j, self.state))) for j in range(len(self.plant.laws))]

    def advance(self, drive_force: float, duration: float) -> None:
        """Advance by a duration under a constant drive force."""
        if not self._varying and self._advance_smoothly(drive_force, duration):
            return
        external = self.plant.drive * drive_force + self.plant.constant
        self._release(external)
        left = duration
        for _ in range(_MOST_EVENTS):
            left -= self._until_event(external, left)
            if left <= 0:
                return
        self.state = self._flow().advance(self.state, self._force(external, self.state), left)

    def _advance_smoothly(self, drive_force: float, duration: float) -> bool:
        """Advance without an event, if there is none: sliding joints keep their direction, stuck ones hold."""
        key = (duration, *self._sign)
        if key not in self._steps:
            self._steps[key] = self._smooth_step(duration)
        step = self._steps[key]
        if not step.holds(self.state, drive_force):
            return False
        end = step.transition @ self.state + (step.drive * drive_force + step.offset)
        if step.speeds.size and (step.speeds @ end).min() < 0:
            return False
        if not step.holds(end, drive_force):
            return False
        self.state = end
        return True

    def _smooth_step(self, duration: float) -> _SmoothStep:
        flow, rest = self._flow(), np.zeros(2 * self._n)
        transition, gain = flow.transition(duration)
        force = self._force(self.plant.constant, self.state)
        rows = [self._sign[j] * self.plant.laws[j].direction for j in self._holding if self._sign[j]]
        limits = np.array([self.plant.laws[j].limits(0.0) for j in flow.stuck]).reshape(-1, 2)
        return _SmoothStep(
            transition,
            gain @ self.plant.drive,
            gain @ force,
            speeds=np.array([np.concatenate([np.zeros(self._n), row]) for row in rows]),
            holding=np.stack([flow.holding_forces(unit, 0 * force) for unit in np.eye(2 * self._n)], axis=1),
            holding_drive=flow.holding_forces(rest, self.plant.drive),
            holding_offset=flow.holding_forces(rest, force),
            lowest=limits[:, 0],
            highest=limits[:, 1],
        )

    def acceleration(self, drive_force: float) -> FloatArray:
        """Accelerations of the bodies under a drive force, of shape (n,)."""
        external = self.plant.drive * drive_force + self.plant.constant
        self._release(external)
        return self._flow().acceleration(self.state, self._force(external, self.state))

    def _velocity(self, j: int, state: FloatArray) -> float:
        return float(self.plant.laws[j].direction @ state[self._n :])

    def _flow(self) -> Flow:
        stuck = tuple(j for j in self._holding if self._sign[j] == 0)
        if stuck not in self._flows:
            self._flows[stuck] = Flow(self.plant, stuck)
        return self._flows[stuck]

    def _force(self, external: FloatArray, state: FloatArray) -> FloatArray:
        """External force and those of all joints that move."""
        force = external
        for j, law in enumerate(self.plant.laws):
            if not (j in self._holding and self._sign[j] == 0):
                q, v = float(law.direction @ state[: self._n]), self._velocity(j, state)
                speed = self._sign[j] * max(abs(v), JUST_MOVING) if j in self._holding else v
                force = force - law.direction * law.force(q, speed)
        return force

    def _release(self, external: FloatArray) -> None:
        """Let joints go that their laws cannot hold, one after the other, the worst first."""
        while True:
            flow = self._flow()
            if not flow.stuck:
                return
            excess = self._excess(flow, self.state, self._force(external, self.state))
            worst = int(np.argmax(np.abs(excess)))
            if excess[worst] == 0:
                return
            self._sign[flow.stuck[worst]] = float(np.sign(excess[worst]))

    def _excess(self, flow: Flow, state: FloatArray, force: FloatArray) -> FloatArray:
        """By how much the force on each stuck joint leaves the range that its law can hold; 0 inside."""
        excess = np.zeros(len(flow.stuck))
        for i, (j, needed) in enumerate(zip(flow.stuck, flow.holding_forces(state, force), strict=True)):
            low, high = self.plant.laws[j].limits(float(self.plant.laws[j].direction @ state[: self._n]))
            excess[i] = max(needed - high, 0.0) + min(needed - low, 0.0)
        return excess

    def _until_event(self, external: FloatArray, duration: float) -> float:
        """Advance to the next event, at most by a duration; the time that was made."""
        flow, start = self._flow(), self.state
        force = self._force(external, start)
        if self._varying:
            middle = flow.advance(start, force, duration / 2)
            force = self._force(external, middle)
        end = flow.advance(start, force, duration)
        moving = [j for j in self._holding if self._sign[j] * self._velocity(j, end) < 0]
        leaving = np.flatnonzero(self._excess(flow, end, force))
        if not moving and not leaving.size:
            self.state = end
            return duration
        times = [(self._stop_time(flow, j, start, force, duration), j) for j in moving]
        times += [(self._leave_time(flow, int(i), start, force, duration), flow.stuck[i]) for i in leaving]
        time, joint = min(times)
        self.state = flow.advance(start, force, time)
        if self._sign[joint] != 0:
            self._come_to_rest(joint)
        self._release(external)
        return time

    def _come_to_rest(self, joint: int) -> None:
        """Stop a joint: take what rounding has left of its velocity out by an impulse along its direction."""
        direction = self.plant.laws[joint].direction
        shape = np.linalg.solve(self.plant.mass, direction)
        self.state = self.state.copy()
        self.state[self._n :] -= shape * (direction @ self.state[self._n :]) / (direction @ shape)
        self._sign[joint] = 0.0

    def _stop_time(self, flow: Flow, j: int, start: FloatArray, force: FloatArray, duration: float) -> float:
        def speed(time: float) -> float:
            return self._sign[j] * self._velocity(j, flow.advance(start, force, time))

        if speed(0.0) <= 0:
            return 0.0
        return float(brentq(speed, 0.0, duration, xtol=1e-15 * duration, rtol=8.9e-16))

    def _leave_time(self, flow: Flow, i: int, start: FloatArray, force: FloatArray, duration: float) -> float:
        low, high = 0.0, duration
        for _ in range(60):
            middle = (low + high) / 2
            out = self._excess(flow, flow.advance(start, force, middle), force)[i] != 0
            low, high = (low, middle) if out else (middle, high)
            if high - low <= 1e-15 * duration:
                break
        return high


def _is_constant(force: LawFunction) -> bool:
    """Whether a joint's force depends on nothing but the sign of its velocity."""
    probes = [(q, v) for q in (-1.3, 0.4, 2.1) for v in (0.7, 3.9)]
    forward = {force(q, v) for q, v in probes}
    backward = {force(q, -v) for q, v in probes}
    return len(forward) == 1 and len(backward) == 1
