"""Stribeck friction that falls over many speeds takes what a drag causes: Coulomb friction is tried in its place."""

from dataclasses import replace

import numpy as np
import pytest

from symid import CoulombFriction, Log, load_axis
from symid.diagnosis import LIBRARY
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.forward import forward_selection
from symid.diagnosis.selection.step import SelectionStep, accepted_of

TIME = np.arange(6000) * 1e-3
WAVES = ((0.1, 2.1, 4.0), (0.05, 5.3, 1.7), (0.02, 11.7, 0.3), (0.005, 29.0, 5.1))
NAMES = ("coulomb_friction", "stribeck_friction", "quadratic_drag", "position_stiffness")


def slide() -> Log:
    """58 kg with dry friction, drag and a weak spring, whose recorded force wanders by several times its noise."""
    q = sum(x * np.sin(rate * TIME + phase) for x, rate, phase in WAVES)
    v = sum(x * rate * np.cos(rate * TIME + phase) for x, rate, phase in WAVES)
    a = -sum(x * rate**2 * np.sin(rate * TIME + phase) for x, rate, phase in WAVES)
    force = 58.0 * a + 100.0 * v + 35.0 * np.sign(v) + 250.0 * v * np.abs(v) + 60.0 * q
    noise = np.random.default_rng(0).standard_normal((3, TIME.size))
    wander = 0.3 * np.cumsum(noise[2])
    signals = {"q": q + 1e-7 * noise[0], "F": force + noise[1] + wander - wander.mean()}
    return Log("by hand", 0.0, 1e-3, signals)


def found() -> list[str]:
    """Effects of the slide by a model without dry friction, in the order of the search."""
    declared = load_axis("rigid_1m")
    smooth = replace(
        declared, elements=tuple(e for e in declared.elements if not isinstance(e, CoulombFriction))
    )
    data = data_of(smooth, (joined([slide()]), None), Recording({}, True))
    fit = fitted_axis(*first_state(data.record, {"M": 58.0, "Fv": 100.0}))
    library = [effect for effect in LIBRARY if effect.name in NAMES]
    return [step.best.key[0] for step in accepted_of(forward_selection(fit, library, None))]


def test_coulomb_friction_and_drag_are_no_stribeck_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    assert found() == ["coulomb_friction", "quadratic_drag"]
    monkeypatch.setattr(SelectionStep, "plain_before_refined", lambda _: ())
    assert found() == ["stribeck_friction"]  # the drag is no longer clear beside it
