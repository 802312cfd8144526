"""Modes of an axis: which joints slide, which way, and which stick. Within a mode the motion is smooth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from symid.arrays import FloatArray
from symid.simulation.flow import Flow
from symid.simulation.plant import JUST_MOVING, JointLaw, Plant

_PROBES = (0.0, *(sign * 10.0**power for power in range(-12, 5) for sign in (1.3, -0.7)))
"""Displacements and speeds at which a law is looked at, to know whether it is constant."""


@dataclass(frozen=True, eq=False)
class Step:
    """Motion over a duration: state after it = transition @ state + drive * drive force + offset - gain @ others.

    Parameters
    ----------
    transition : array of shape (2 n, 2 n)
        Matrix of the state.
    gain : array of shape (2 n, n)
        Matrix of constant forces on the bodies.
    drive, offset : array of shape (2 n,)
        Effects of a unit of drive force and of the mode's constant forces.
    """

    transition: FloatArray
    gain: FloatArray
    drive: FloatArray
    offset: FloatArray


class Mode:
    """Motion of an axis while the joints in `signs` keep their direction, or stick where that is 0.

    Parameters
    ----------
    plant : Plant
        The axis.
    flow : Flow
        Its motion with the joints that stick.
    signs : tuple of float
        Direction of motion for each law, 0 for one that sticks or can not.
    can_hold, varies : sequence of bool
        Whether each law can hold its joint, and whether its force varies within a mode.

    Attributes
    ----------
    constant : array of shape (n,)
        Constant forces of the plant and of the laws that do not vary.
    varying : tuple of (JointLaw, float)
        Laws whose force varies with the motion, and their sign.
    speeds : array of shape (n_sliding, 2 n)
        Rows whose products with the state are the speeds of the sliding joints, positive while they keep direction.
    """

    def __init__(
        self,
        plant: Plant,
        flow: Flow,
        signs: tuple[float, ...],
        can_hold: Sequence[bool],
        varies: Sequence[bool],
    ) -> None:
        self.plant, self.flow, self.signs = plant, flow, signs
        n = len(plant.bodies)
        moving = [j for j in range(len(signs)) if j not in flow.stuck]
        self.varying = tuple((plant.laws[j], signs[j]) for j in moving if varies[j])
        steady = [
            plant.laws[j].direction * plant.laws[j].force(0.0, signs[j]) for j in moving if not varies[j]
        ]
        self.constant = np.asarray(plant.constant - sum(steady, start=np.zeros(n)))
        rows = [signs[j] * plant.laws[j].direction for j in moving if can_hold[j]]
        self.sliding = tuple(j for j in moving if can_hold[j])
        self.speeds = np.hstack([np.zeros((len(rows), n)), np.array(rows).reshape(len(rows), n)])
        self._fixed = None if any(varies[j] for j in flow.stuck) else self._limits(np.zeros(2 * n))
        self.step = lru_cache(maxsize=32)(self._step)

    def force(self, state: FloatArray) -> FloatArray:
        """All forces but that of the drive, of shape (n,)."""
        force, n = self.constant, len(self.plant.bodies)
        for law, sign in self.varying:
            force = force - law.direction * law_force(
                law, sign, float(law.direction @ state[:n]), float(law.direction @ state[n:])
            )
        return force

    def limits(self, state: FloatArray) -> FloatArray:
        """Lowest and highest force that each stuck joint can hold, of shape (n_stuck, 2)."""
        return self._limits(state) if self._fixed is None else self._fixed

    def _limits(self, state: FloatArray) -> FloatArray:
        laws = [self.plant.laws[j] for j in self.flow.stuck]
        displacements = state[: len(self.plant.bodies)]
        return np.array([law.limits(float(law.direction @ displacements)) for law in laws]).reshape(-1, 2)

    def _step(self, duration: float) -> Step:
        transition, gain = self.flow.transition(duration)
        return Step(transition, gain, gain @ self.plant.drive, gain @ self.constant)


def law_force(law: JointLaw, sign: float, q: float, v: float) -> float:
    """Force of a joint that slides in direction `sign`, at speed 0 too; of any joint if `sign` is 0."""
    return law.force(q, sign * max(sign * v, JUST_MOVING) if sign else v)


class Modes:
    """All modes of a plant, each made when first met.

    Examples
    --------
    >>> from symid.axis import load_axis
    >>> from symid.simulation.plant import plant_of
    >>> modes = Modes(plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 4.0}))
    >>> modes.of((1.0,)).constant.tolist(), modes.of((0.0,)).limits(np.zeros(2)).tolist()
    ([-4.0], [[-4.0, 4.0]])
    """

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.can_hold = tuple(law.can_hold for law in plant.laws)
        self.varies = tuple(_varies(law, held) for law, held in zip(plant.laws, self.can_hold, strict=True))
        self.of = lru_cache(maxsize=256)(self._of)
        self._flow = lru_cache(maxsize=64)(lambda stuck: Flow(plant, stuck))

    def start(self, state: FloatArray) -> tuple[float, ...]:
        """Signs of a state: joints at rest stick until their laws cannot hold them."""
        velocities = state[len(self.plant.bodies) :]
        return tuple(
            float(np.sign(law.direction @ velocities)) if held else 0.0
            for law, held in zip(self.plant.laws, self.can_hold, strict=True)
        )

    def _of(self, signs: tuple[float, ...]) -> Mode:
        stuck = tuple(j for j, held in enumerate(self.can_hold) if held and signs[j] == 0)
        return Mode(self.plant, self._flow(stuck), signs, self.can_hold, self.varies)


def _varies(law: JointLaw, can_hold: bool) -> bool:
    """Whether a joint's force depends on more than the direction of motion, which counts where it can hold."""
    forward = {law.force(q, abs(v) or JUST_MOVING) for q, v in _pairs()}
    backward = {law.force(q, -abs(v) or -JUST_MOVING) for q, v in _pairs()}
    return len(forward) > 1 or len(backward) > 1 or (not can_hold and forward != backward)


def _pairs() -> list[tuple[float, float]]:
    crossed = [(q, v) for q in (-1.3, 0.4, 2.1) for v in _PROBES]
    return crossed + [(q, v) for q in _PROBES for v in (0.7, 3.9)]
