"""Friction by load takes the force that acts, without the noise of the position in the modelled one."""

import pytest

from symid import LoadDependentFriction, load_axis
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.effects import LIBRARY
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("rigid_1m")
VALUES = {"M": 100.0, "Fv": 20.0, "Fs": 10.0}


def slide(seed: int) -> Log:
    """A slide that cruises for most of the time, with hardly any force, read by a noisy encoder."""
    axis = AXIS.with_signal("q", noise=1e-6).with_signal("F", noise=0.3)
    axis = axis.with_effect(LoadDependentFriction(AXIS.bodies[0], 0.25))
    reference = trapezoids(0.4, [0.2, 0.4], acceleration=2.0, jerk=60.0, dwell=0.1, sampling_period=5e-4)
    return simulate(axis, VALUES, reference, tuned_cascade(plant_of(AXIS, VALUES), "q"), seed=seed).log


def test_noise_of_the_position_is_no_load() -> None:
    library = [effect for effect in LIBRARY if effect.name in ("load_dependent_friction", "cogging")]
    found = diagnose(AXIS, slide(1), validation=slide(2), nominal=VALUES, library=library)
    (friction,) = found.effects
    assert friction.effect == "load_dependent_friction"
    assert friction.parameters["mu"].value == pytest.approx(0.25, rel=0.01)  # 6 % less with the noise
    assert found.gap.explained.rms < 4.5 * found.gap.noise_floor.rms  # 8 with the noise
