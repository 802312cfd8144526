"""Events in the compiled loop: a run, sample by sample beside the engine that makes one sample at a time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from symid import Axis, CoulombFriction, StribeckFriction, load_axis
from symid.axis import Element
from symid.simulation import Engine, plant_of, simulate, trapezoids, tuned_cascade

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


def axis_with(*elements: Element) -> Axis:
    axis = DIRECT.with_signal("q2", noise=2e-7)  # chatters: a joint turns in every few samples
    for element in elements:
        axis = axis.with_effect(element)
    return axis


@pytest.mark.parametrize(
    "elements", [(DRY,), (DRY, StribeckFriction(MOTOR, "dF", velocity=0.02))], ids=["dry", "varying"]
)
def test_a_run_is_that_of_the_engine(elements: tuple[Element, ...]) -> None:
    axis = axis_with(*elements)
    plant = plant_of(axis, VALUES)
    path = trapezoids([0.01], 0.2, acceleration=4.0, jerk=200.0, dwell=0.02, sampling_period=PERIOD)
    run = simulate(axis, VALUES, path, tuned_cascade(plant, "q2", bandwidth_hz=10.0), seed=1)
    engine, states, modes = Engine(plant), [], []
    for force in run.forces:
        states.append(engine.state)
        modes.append(engine.mode.signs)
        engine.advance(force, PERIOD)
    turns = sum(before != after for before, after in pairwise(modes))
    assert turns > 15
    scale = np.abs(run.states).max(axis=0)
    assert np.all(np.abs(np.array(states) - run.states) < 1e-9 * scale)
    assert len(set(modes)) > 4
