"""A heavy mode of a hidden structure, which a light mode of the motor imitates."""

import math

from symid import Between, Body, Spring, load_axis
from symid.data import Log
from symid.diagnosis import LIBRARY, diagnose
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("direct_2m1s")
VALUES = {"Mm": 362.0, "Ms": 2816.0, "Ks": 1.47e8, "Fvs": 4.17e4, "Fvm": 126.0, "Fsm": 148.0}
SHARE, FREQUENCY, DAMPING = 0.6, 21.3, 0.011


def moved(speeds: list[float], seed: int) -> Log:
    hung, mass, w = Body("hung", mass="Mh"), SHARE * VALUES["Ms"], 2 * math.pi * FREQUENCY
    spring = Spring("hanger", Between(first=AXIS.bodies[0], second=hung), stiffness="Kh", damping="Dh")
    machine = AXIS.with_effect(hung, spring).with_signal("q2", noise=5e-8).with_signal("Fm", noise=1.0)
    values = VALUES | {"Mh": mass, "Kh": mass * w**2, "Dh": 2 * DAMPING * mass * w}
    reference = trapezoids(0.1, speeds, acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1e-3)
    run = simulate(machine, values, reference, tuned_cascade(plant_of(AXIS, VALUES), "q2"), seed=seed).log
    return Log.from_arrays({"q2": run["q2"], "Fm": run["Fm"]}, sampling_period=run.sampling_period)


def test_a_heavy_mode_of_the_structure_is_not_one_of_the_motor() -> None:
    nominal = VALUES | {"Mm": 340.0, "Ms": 2640.0, "Ks": 1.6e8}
    library = [effect for effect in LIBRARY if effect.name == "flexible_mode"]
    logs = {"log": moved([0.1, 0.2, 0.3], 1), "validation": moved([0.15, 0.25], 2)}
    found = diagnose(AXIS, **logs, nominal=nominal, library=library, held=True)
    (mode,) = found.effects
    places = {mode.at, *(place for _, place in mode.indistinguishable_from)}
    assert "structure" in places
