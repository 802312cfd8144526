"""A model without a law of the machine: the law is named, and nothing that only sets astray values right."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.diagnosis.lacking import Case, drawn, is_close
from benchmarks.effect_machines import ELASTIC, FRICTION, UNDAMPED
from symid import Log
from symid.diagnosis import Diagnosis, diagnose


def found_in(case: Case) -> Diagnosis:
    return diagnose(case.model, case.logs[0], validation=case.logs[1], nominal=case.nominal)


@pytest.mark.parametrize("seed", [6013, 6056])
def test_coulomb_friction_of_an_elastic_machine_is_no_stribeck_friction(seed: int) -> None:
    case = drawn(seed, worldly=False)
    assert case is not None
    assert case.lacks == "coulomb_friction"
    found = found_in(case)
    assert found.effects[0].effect == "coulomb_friction"
    assert is_close(case, found.effects)


def test_friction_that_leaves_noise_alone_is_no_late_reading() -> None:
    case = drawn(7016, worldly=False)
    assert case is not None
    found = found_in(case)
    assert [effect.effect for effect in found.effects] == [case.lacks] == ["viscous_friction"]
    assert is_close(case, found.effects)


def test_values_that_went_astray_are_no_effect() -> None:
    case = drawn(6043, worldly=False)
    assert case is not None
    found = found_in(case)
    assert found.gap.reidentified.rms < 2 * found.gap.noise_floor.rms
    values = {change.name: change.reidentified for change in found.parameters}
    assert values["K"] == pytest.approx(case.machine.values["K"], rel=0.02)
    assert "cogging" not in {effect.effect for effect in found.effects}


def test_damping_of_a_spring_is_not_a_late_reading() -> None:
    """By a modal solution: load and motor on a spring whose damping ratio is 2 %, under forces of three sines."""
    axis, t = replace(ELASTIC, elements=UNDAMPED.elements), np.arange(4000) / 1000
    motor, load, k, c, fv = 40.0, 25.0, 6e5, 300.0, 120.0
    force, q, ql = np.zeros(t.size), np.zeros(t.size), np.zeros(t.size)
    for hertz, size in ((0.7, 300.0), (9.0, 150.0), (21.0, 80.0), (33.0, 60.0)):
        s = 2j * np.pi * hertz
        link = c * s + k
        matrix = np.array([[motor * s**2 + fv * s + link, -link], [-link, load * s**2 + link]])
        moved = np.linalg.solve(matrix, [size, 0.0])
        for signal, amplitude in ((force, size), (q, moved[0]), (ql, moved[1])):
            signal[:] += np.real(amplitude * np.exp(s * t))
    rng = np.random.default_rng(3)
    readings = {"F": (force, 0.3), "q": (q, 1e-7), "ql": (ql, 1e-7)}
    log = Log.from_arrays(
        {name: x + noise * rng.standard_normal(t.size) for name, (x, noise) in readings.items()},
        sampling_period=1e-3,
    )
    model = axis.without(FRICTION[1])
    found = diagnose(model, log, nominal={"M": motor, "Ml": load, "K": k, "Fv": fv}, held=False)
    assert [(effect.effect, effect.at) for effect in found.effects] == [("spring_damping", "coupling")]
    assert found.effects[0].parameters["Fd"].value == pytest.approx(c, rel=0.05)
