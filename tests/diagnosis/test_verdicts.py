"""Logs written by hand with one effect: the verdict names it, its values are found, the gap closes."""

import numpy as np
import pytest
from hand_made import RIGID, hung, plain_force, rigid_log

from symid import load_axis
from symid.diagnosis import diagnose

SHIFT = 1e-3


EFFECTS = {
    "stribeck_friction": (
        lambda t, q, v, a, path: 25 * np.sign(v) * np.exp(-((v / 0.02) ** 2)),
        {"dF": 25.0, "vs": 0.02},
    ),
    "quadratic_drag": (lambda t, q, v, a, path: 300 * v * np.abs(v), {"c": 300.0}),
    "position_stiffness": (lambda t, q, v, a, path: 500 * q, {"k": 500.0}),
    "cogging": (lambda t, q, v, a, path: 12 * np.sin(2 * np.pi * q / 0.024), {"As": 12.0, "pitch": 0.024}),
    "flexible_mode": (lambda t, q, v, a, path: hung(path, t), {"m": 30.0, "f": 12.0}),
    "delay": (lambda t, q, v, a, path: plain_force(path, t + SHIFT) - plain_force(path, t), {"T": SHIFT}),
}


@pytest.mark.parametrize("effect", EFFECTS)
def test_one_effect(effect: str) -> None:
    missing, values = EFFECTS[effect]
    found = diagnose(load_axis("rigid_1m"), rigid_log(missing), validation=rigid_log(missing, seed=2))
    assert found.verdict == "effect"
    assert (found.effects[0].effect, found.alternatives[0].effect) == (effect, effect)
    assert found.effects[0].at == ("actuator" if effect == "delay" else "motor")
    for name, value in values.items():
        assert found.effects[0].parameters[name].value == pytest.approx(value, rel=0.06)
    swings = effect == "flexible_mode"  # already where the log begins, which the mass takes up
    assert found.gap.closed_fraction > (0.8 if swings else 0.9)
    for change in found.parameters:
        if not swings:
            assert change.explained == pytest.approx(RIGID[change.name], rel=0.05)


def test_a_clean_log_has_no_gap() -> None:
    found = diagnose(load_axis("rigid_1m"), rigid_log(), validation=rigid_log(seed=2), nominal=RIGID)
    assert found.verdict == "no_gap"
    assert found.effects == ()
    assert found.gap.nominal is not None
    assert found.gap.nominal.rms == pytest.approx(found.gap.noise_floor.rms, rel=0.15)


def test_wrong_values_are_parameters_and_no_effect() -> None:
    wrong = {"M": 110.0, "Fv": 120.0, "Fs": 9.5}
    found = diagnose(load_axis("rigid_1m"), rigid_log(), nominal=wrong)
    assert found.verdict == "parameters"
    assert found.effects == ()
    for change in found.parameters:
        assert abs(change.reidentified - RIGID[change.name]) < 5 * change.reidentified_std


def test_a_force_that_nothing_in_the_library_stands_for_is_unexplained() -> None:
    rng = np.random.default_rng(3)
    found = diagnose(
        load_axis("rigid_1m"),
        rigid_log(lambda t, q, v, a, path: np.cumsum(rng.standard_normal(t.size)) * 0.6),
        validation=rigid_log(lambda t, q, v, a, path: np.cumsum(rng.standard_normal(t.size)) * 0.6, seed=2),
    )
    assert found.verdict == "unexplained"
    assert found.effects == ()
