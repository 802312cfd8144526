"""A force whose record ends before the force does is a damaged recording; one that a drive limits is not."""

from __future__ import annotations

import numpy as np
import pytest

import symid
from symid import ForceLimit, OffsetForce, load_axis
from symid.diagnosis import LIBRARY
from symid.simulation import Cascade, plant_of, simulate, trapezoids, tuned_cascade

RIGID = load_axis("rigid_1m")


def moved() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, position and force of 100 kg with friction, by hand."""
    t = np.arange(6000) * 1e-3
    q = v = a = np.zeros(t.size)
    for amplitude, rate in ((0.2, 3.0), (0.05, 8.1), (0.01, 21.0)):
        q = q + amplitude * np.sin(rate * t)
        v = v + amplitude * rate * np.cos(rate * t)
        a = a - amplitude * rate**2 * np.sin(rate * t)
    noise = np.random.default_rng(0).standard_normal((2, t.size))
    return t, q + 1e-7 * noise[0], 100 * a + 80 * v + 40 * np.sign(v) + noise[1]


@pytest.mark.parametrize(("low", "high", "noise"), [(-0.4, 0.4, 0.0), (-0.7, 0.7, 2.0), (-1.0, 0.6, 0.0)])
def test_a_clipped_record_is_no_physics(low: float, high: float, noise: float) -> None:
    t, q, force = moved()
    top = float(np.abs(force).max())
    clipped = np.clip(force, low * top, high * top)
    clipped += noise * np.random.default_rng(1).standard_normal(t.size)
    found = symid.diagnose(RIGID, {"t": t, "q": q, "F": clipped})
    assert found.verdict == "recording"
    assert "its record is clipped" in found.sentence
    asked = float(found.faults[0].split("up to ")[1].split()[0])
    assert asked == pytest.approx(float(force.max()), rel=0.02)


def test_a_drive_at_its_limit_is_none() -> None:
    axis = RIGID.with_signal("F", noise=1.0).with_signal("q", noise=1e-7)
    loop = Cascade("q", 40.0, 8000.0, 40.0, force_limit=450.0)
    path = trapezoids([0.2, 0.1] * 2, 0.9, acceleration=5.0, jerk=300.0, dwell=0.1, sampling_period=1e-3)
    values = {"M": 100.0, "Fv": 80.0, "Fs": 40.0, "F0": 60.0}
    log = simulate(axis.with_effect(OffsetForce(axis.bodies[0], "F0")), values, path, loop).log
    assert np.mean(np.abs(log["F"]) > 440.0) > 0.05
    found = symid.diagnose(axis, log)
    assert found.verdict == "effect"
    assert found.effects[0].effect == "offset_force"


def test_a_limit_that_only_the_validation_log_reaches_is_found_beside_another_effect() -> None:
    axis = RIGID.with_signal("F", noise=1.0).with_signal("q", noise=1e-7)
    values = {"M": 100.0, "Fv": 80.0, "Fs": 40.0, "F0": 60.0}
    loop = tuned_cascade(plant_of(RIGID, values), "q")
    machine = axis.with_effect(OffsetForce(axis.bodies[0], "F0"), ForceLimit(420.0))

    def moved_with(acceleration: float, seed: int) -> symid.Log:
        path = trapezoids(
            [0.2, 0.1, 0.3], 0.9, acceleration=acceleration, jerk=300.0, dwell=0.1, sampling_period=1e-3
        )
        return simulate(machine, values, path, loop, seed=seed).log

    slow, fast = moved_with(2.0, 1), moved_with(2.6, 2)
    assert np.abs(slow["F"]).max() < 420.0 < np.abs(fast["F"]).max()
    library = [effect for effect in LIBRARY if effect.name in ("offset_force", "saturation")]
    found = symid.diagnose(axis, slow, validation=fast, nominal=values, held=True, library=library)
    assert {effect.effect for effect in found.effects} == {"offset_force", "saturation"}
    assert "shows in the validation log" in found.assumptions[0]
    (limit,) = (effect for effect in found.effects if effect.effect == "saturation")
    assert limit.parameters["limit"].value == pytest.approx(420.0, rel=0.02)


def test_a_limit_far_below_a_command_that_an_integrator_winds_up() -> None:
    """A tenth and more of the samples ask for more than the drive gives, some for ten times as much."""
    axis = RIGID.with_signal("F", noise=1.0).with_signal("q", noise=1e-7)
    values = {"M": 12.0, "Fv": 18.0, "Fs": 24.0}
    path = trapezoids(
        [0.12, 0.04], [0.1, 0.3, 0.6], acceleration=7.0, jerk=400.0, dwell=0.1, sampling_period=1e-3
    )
    loop = tuned_cascade(plant_of(RIGID, values), "q")
    log = simulate(axis.with_effect(ForceLimit(100.0)), values, path, loop, seed=1).log
    size = np.abs(log["F"])
    assert size.max() > 10 * 100.0
    assert np.mean(size > 100.0) > 0.1
    names = ("saturation", "delay", "quadratic_drag", "presliding_friction", "flexible_mode")
    library = [effect for effect in LIBRARY if effect.name in names]
    found = symid.diagnose(axis, log, nominal=values, library=library)
    assert [effect.effect for effect in found.effects] == ["saturation"]
    assert found.effects[0].parameters["limit"].value == pytest.approx(100.0, rel=0.02)
