"""Two joints that stick, slip and reverse in every few samples, beside an event-located solve_ivp."""

from itertools import pairwise

import numpy as np
import pytest
from driven import driven
from scipy.integrate import solve_ivp

from symid import CoulombFriction, StribeckFriction, load_axis
from symid.axis import Element
from symid.simulation import Plant, plant_of

VALUES = {
    "Ms": 900.0,
    "Fvs": 3000.0,
    "Ks": 4e7,
    "Mm": 200.0,
    "Fvm": 150.0,
    "Fsm": 80.0,
    "Fss": 60.0,
    "dF": 20.0,
}
PERIOD = 1 / 4000
DIRECT = load_axis("direct_2m1s")
STRUCTURE, MOTOR = DIRECT.bodies
DRY = CoulombFriction(STRUCTURE, "Fss")
TINY = 1e-300


class Located:
    """The axis integrated from event to event: a joint sticks at zero speed until its law cannot hold it."""

    def __init__(self, plant: Plant) -> None:
        self.plant, self.n = plant, len(plant.bodies)
        self.D = np.array([law.direction for law in plant.laws])
        self.state, self.signs = np.zeros(2 * self.n), np.zeros(len(plant.laws))
        self.inverse = np.linalg.inv(plant.mass)

    def force(self, state: np.ndarray) -> np.ndarray:
        """All forces but those of stuck joints."""
        x, v = np.split(state, 2)
        total = self.pull - self.plant.damping @ v - self.plant.stiffness @ x
        for law, d, sign in zip(self.plant.laws, self.D, self.signs, strict=True):
            if sign:
                total = total - d * law.force(d @ x, sign * max(sign * (d @ v), TINY))
        return total

    def holding(self, state: np.ndarray) -> np.ndarray:
        """Forces that keep the stuck joints at rest."""
        D = self.D[self.signs == 0]
        return np.linalg.solve(D @ self.inverse @ D.T, D @ self.inverse @ self.force(state))

    def excess(self, state: np.ndarray) -> np.ndarray:
        """By how much they exceed what the laws can hold, for all joints; 0 for one that slides."""
        found = np.zeros(self.signs.size)
        stuck = np.flatnonzero(self.signs == 0)
        for j, needed in zip(stuck, self.holding(state) if stuck.size else (), strict=True):
            low, high = self.plant.laws[j].limits(self.D[j] @ state[: self.n])
            found[j] = max(needed - high, 0.0) + min(needed - low, 0.0)
        return found

    def change(self, _: float, state: np.ndarray) -> np.ndarray:
        """Derivative of the state."""
        held = self.D[self.signs == 0].T @ self.holding(state) if (self.signs == 0).any() else 0.0
        return np.concatenate([state[self.n :], self.inverse @ (self.force(state) - held)])

    def advance(self, force: float) -> None:
        """One sample under a drive force."""
        self.pull, left = self.plant.drive * force + self.plant.constant, PERIOD
        while left > 1e-16:
            while (excess := self.excess(self.state)).any():
                worst = int(np.argmax(np.abs(excess)))
                self.signs[worst] = np.sign(excess[worst])
            events = [self.event(j) for j in range(self.signs.size)]
            run = solve_ivp(
                self.change, (0, left), self.state, "DOP853", rtol=1e-12, atol=1e-15, events=events
            )
            self.state, left = run.y[:, -1].copy(), left - run.t[-1]
            for j, times in enumerate(run.t_events):
                if times.size and self.signs[j]:
                    response = self.inverse @ self.D[j]
                    speed = self.D[j] @ self.state[self.n :]
                    self.state[self.n :] -= response * speed / (self.D[j] @ response)
                    self.signs[j] = 0.0

    def event(self, j: int):
        """Speed of a sliding joint, or excess of a stuck one, whose zero ends the mode."""
        sign = self.signs[j]

        def speed(_: float, state: np.ndarray) -> float:
            return float(sign * (self.D[j] @ state[self.n :])) + 1e-18

        def margin(_: float, state: np.ndarray) -> float:
            return 1e-9 - abs(self.excess(state)[j])

        found = speed if sign else margin
        found.terminal, found.direction = True, -1
        return found


@pytest.mark.parametrize(
    ("elements", "steps", "tolerance"),
    [((DRY,), 1, 1e-12), ((DRY, StribeckFriction(MOTOR, "dF", velocity=0.02)), 40, 1e-7)],
    ids=["dry", "varying"],
)
def test_a_run_is_that_of_an_event_located_integration(
    elements: tuple[Element, ...], steps: int, tolerance: float
) -> None:
    axis = DIRECT
    for element in elements:
        axis = axis.with_effect(element)
    k = np.arange(200)
    forces = 150.0 * np.sin(0.3 * k) + 120.0 * np.random.default_rng(2).standard_normal(k.size)
    found = driven(axis, VALUES, np.repeat(forces, steps), PERIOD / steps)[::steps]
    located, states, modes = Located(plant_of(axis, VALUES)), [], []
    for force in forces:
        states.append(located.state)
        modes.append(tuple(located.signs))
        located.advance(float(force))
    assert sum(before != after for before, after in pairwise(modes)) > 30
    assert len(set(modes)) > 4
    error = np.abs(np.array(states) - found[:-1]).max(axis=0) / np.abs(found).max(axis=0)
    assert np.all(error < tolerance)
