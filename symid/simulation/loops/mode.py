"""Stick-slip modes of an axis: which joints slide, in which direction, and which stick. In a mode motion is smooth.

With the joints S stuck, D x(1) = 0 for their directions D. The forces that hold them are
lambda = (D M^-1 D')^-1 D M^-1 (w - C x(1) - K x), w being all other forces, and the motion is linear again.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.simulation.plants.plant import JUST_MOVING, JointLaw, Plant

TAYLOR_ORDER = 20
"""Terms of the Taylor series; within `Flow.reach` the next one is below 1/20! = 4e-19 of the first."""
_MOST_DOUBLINGS = 42
"""Halvings of a step down to the fastest motion, after which rounding changes slow motion by 2^42 * 2e-16 = 0.1 %."""
_DEPENDENT = 1e-10
"""Relative eigenvalue of the mobility of stuck joints, each scaled to 1, below which they depend on each other."""


class Flow:
    """Motion under a constant generalised force with the joints of some laws, by their indices, stuck.

    >>> from symid.axis import load_axis
    >>> from symid.simulation.plants.forward_dynamics import plant_of
    >>> flow = Flow(plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 0.0}), ())
    >>> of_state, of_force = flow.transition(0.5)
    >>> (of_state @ [1.0, 3.0] + of_force @ [4.0]).tolist()
    [2.75, 4.0]
    """

    def __init__(self, plant: Plant, stuck: Sequence[int]) -> None:
        n = len(plant.bodies)
        self.stuck = tuple(stuck)
        inverse = np.linalg.inv(plant.mass)
        directions = np.array([plant.laws[j].direction for j in stuck]).reshape(len(self.stuck), n)
        # Joints that depend on each other, such as two carriages and the turn of their beam, share the friction that
        # holds them.
        felt = directions @ inverse @ directions.T
        size = 1.0 / np.sqrt(np.diag(felt))
        shared = np.linalg.pinv(felt * np.outer(size, size), rcond=_DEPENDENT, hermitian=True)
        holding = np.outer(size, size) * shared @ directions @ inverse
        free = inverse - inverse @ directions.T @ holding
        motion = np.hstack([plant.stiffness, plant.damping])
        self.acceleration_rows = np.hstack([-free @ motion, free])
        self.holding_rows = np.hstack([-holding @ motion, holding])
        frequency = math.sqrt(np.linalg.norm(free @ plant.stiffness, 2))
        self.reach = 1.0 / max(frequency + float(np.linalg.norm(free @ plant.damping, 2)), 1.0)
        self.transition = lru_cache(maxsize=64)(self._transition)

    def _transition(self, duration: float) -> tuple[FloatArray, FloatArray]:
        """Matrices of state and force over a duration, by scaling and squaring of the Taylor series.

        Each squaring doubles the relative error of slow motion; SettingError where nothing of that would be left.
        SciPy's matrix exponential takes milliseconds for matrices of this size, which its library shares among threads.
        """
        doublings = max(math.ceil(math.log2(duration / self.reach)), 0) if duration > 0 else 0
        if doublings > _MOST_DOUBLINGS:
            raise SettingError(
                f"the axis moves within {self.reach:.1e} s, too fast to be simulated over steps of {duration:.1e} s: "
                "check its masses, dampings and stiffnesses"
            )
        whole = np.tensordot((duration / 2**doublings / self.reach) ** np.arange(TAYLOR_ORDER), self.terms, 1)
        size = len(whole)
        transition, gain = whole[:, :size], whole[:, size:]
        for _ in range(doublings):
            transition, gain = transition @ transition, transition @ gain + gain
        return transition, gain

    @cached_property
    def terms(self) -> FloatArray:
        """Terms of the exponential over `reach`, of shape (terms, 2 n, 3 n)."""
        n = len(self.acceleration_rows)
        generator = np.zeros((3 * n, 3 * n))
        generator[:n, n : 2 * n] = np.eye(n)
        generator[n : 2 * n] = self.acceleration_rows
        term, terms = np.eye(3 * n), []
        for order in range(1, TAYLOR_ORDER + 1):
            terms.append(term[: 2 * n])
            term = generator @ term * (self.reach / order)
        return np.array(terms)


_SPEEDS = (JUST_MOVING, *(0.7 * 10.0**power for power in range(-12, 5)))
"""Speeds and displacements at which a law is evaluated to find out whether it is affine."""


@dataclass(frozen=True)
class AffineForce:
    """A force level + stiffness q + damping v, SI."""

    level: float
    stiffness: float
    damping: float


@dataclass(frozen=True, eq=False)
class StickSlipMode:
    """Motion of an axis while the joints in `signs` keep their direction, or stick where that is 0."""

    flow: Flow  # the motion with the joints that stick, and with the slopes of affine laws
    signs: tuple[float, ...]  # for each law; 0 if its joint sticks, or if the law can never hold the joint
    sliding: tuple[int, ...]  # laws that could hold their joints but do not in this mode
    constant: FloatArray  # constant forces of the plant and of the affine laws, shape (n,)
    varying: tuple[int, ...]  # all other laws of joints that do not stick
    # shape (n_sliding, 2 n): rows whose products with the state are the speeds of the sliding joints, positive while
    # they keep their direction
    speeds: FloatArray


class StickSlipModes:
    """All stick-slip modes of a plant, each computed when it first occurs.

    >>> from symid.axis import load_axis
    >>> from symid.simulation.plants.forward_dynamics import plant_of
    >>> modes = StickSlipModes(plant_of(load_axis("rigid_1m"), {"M": 2.0, "Fv": 0.0, "Fs": 4.0}))
    >>> [modes.of((sign,)).constant.tolist() for sign in (1.0, -1.0, 0.0)]
    [[-4.0], [4.0], [0.0]]
    """

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.can_hold = tuple(law.can_hold for law in plant.laws)
        self._line = lru_cache(maxsize=None)(lambda j, sign: _line(plant.laws[j], sign))
        shapes = [np.linalg.solve(plant.mass, law.direction) for law in plant.laws]
        self.impulses = [s / (law.direction @ s) for s, law in zip(shapes, plant.laws, strict=True)]
        self.of = lru_cache(maxsize=256)(self._of)
        self._flow = lru_cache(maxsize=64)(self._make_flow)

    def start(self, state: FloatArray) -> tuple[float, ...]:
        """Signs of a state; a joint at rest sticks until its law cannot hold it."""
        velocities = state[len(self.plant.bodies) :]
        return tuple(
            float(np.sign(law.direction @ velocities)) if held else 0.0
            for law, held in zip(self.plant.laws, self.can_hold, strict=True)
        )

    def _of(self, signs: tuple[float, ...]) -> StickSlipMode:
        plant, n = self.plant, len(self.plant.bodies)
        stuck = tuple(j for j, held in enumerate(self.can_hold) if held and signs[j] == 0)
        sliding = tuple(j for j, held in enumerate(self.can_hold) if held and j not in stuck)
        lines = {j: self._line(j, sign) for j, sign in enumerate(signs) if j not in stuck}
        affine = {j: line for j, line in lines.items() if line}
        slopes = tuple((j, line.stiffness, line.damping) for j, line in affine.items())
        levels = sum((plant.laws[j].direction * line.level for j, line in affine.items()), start=np.zeros(n))
        rows = np.array([signs[j] * plant.laws[j].direction for j in sliding]).reshape(-1, n)
        return StickSlipMode(
            self._flow(stuck, slopes),
            signs,
            sliding,
            constant=np.asarray(plant.constant - levels),
            varying=tuple(j for j in lines if j not in affine),
            speeds=np.hstack([np.zeros_like(rows), rows]),
        )

    def _make_flow(self, stuck: tuple[int, ...], slopes: tuple[tuple[int, float, float], ...]) -> Flow:
        stiffness, damping = self.plant.stiffness, self.plant.damping
        for j, spring, damper in slopes:
            square = np.outer(self.plant.laws[j].direction, self.plant.laws[j].direction)
            stiffness, damping = stiffness + spring * square, damping + damper * square
        return Flow(replace(self.plant, stiffness=stiffness, damping=damping), stuck)


def _line(law: JointLaw, sign: float) -> AffineForce | None:
    """The law as an affine force for motion in a direction (both if `sign` is 0); None if it is not affine."""
    if law.timed:
        return None
    directions = (sign,) if sign else (-1.0, 1.0)
    speeds = [side * speed for side in directions for speed in _SPEEDS]
    # Three points determine the affine force. Many more, over all magnitudes, test it: a law is a formula of a few
    # terms, so one that agrees at all of these points is affine.
    points = [(0.0, speeds[0]), (1.0, speeds[0]), (0.0, speeds[-1])]
    points += [(q, v) for q in (-1.3, 0.0, 0.4) for v in speeds]
    points += [(side * q, v) for side in (-1.0, 1.0) for q in _SPEEDS for v in (speeds[0], speeds[-1])]
    q, v = np.array(points).T
    with np.errstate(over="ignore", invalid="ignore"):
        force = np.broadcast_to(law.force(q, v), q.shape)
        level, at_displacement, at_speed = force[:3].tolist()
        line = AffineForce(level, at_displacement - level, (at_speed - level) / speeds[-1])
        parts = np.array([np.full(q.shape, line.level), line.stiffness * q, line.damping * v])
        agrees = np.abs(force - parts.sum(axis=0)) <= 1e-13 * np.abs(parts).sum(axis=0)
    return line if np.all(np.isfinite(parts)) and np.all(agrees) else None
