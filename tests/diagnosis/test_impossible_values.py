"""Values that no machine has speak against the effects beside them."""

import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from hand_made import rigid_log

from benchmarks.effect_machines import ELASTIC, RIGID, SENSORS, VALUES as VALUES_OF_MACHINES, machine
from symid import Axis, Body, CoulombFriction, Drive, Velocity, ViscousFriction, load_axis
from symid.data import Log
from symid.diagnosis import LIBRARY, Diagnosis, diagnose
from symid.diagnosis.findings.found_effects import ParameterChange
from symid.diagnosis.findings.parameter_changes import lost
from symid.errors import SettingError
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s")
VALUES = {
    "Mm": 100.0,
    "Fvm": 100.0,
    "Fsm": 60.0,
    "Kt": 200 * (2 * np.pi * 30) ** 2,
    "Ft": 800.0,
    "Ml": 200.0,
    "Fvl": 100.0,
}


def late_by_a_sample(seed: int) -> Log:
    """A log of a ball screw whose load encoder is read one sample late."""
    axis = SCREW.with_signal("qm", noise=1e-7).with_signal("ql", noise=1e-7).with_signal("Fm", noise=1.0)
    levels = list(np.random.default_rng(seed).uniform(0.03, 0.15, 6))
    path = trapezoids(levels, 0.35, acceleration=3.0, jerk=60.0, dwell=0.05, sampling_period=1e-3)
    log = simulate(axis, VALUES, path, tuned_cascade(plant_of(SCREW, VALUES), "qm"), seed=seed).log
    columns = {name: log[name][1:] for name in ("qm", "Fm")} | {"ql": log["ql"][:-1]}
    return Log.from_arrays(columns, sampling_period=log.sampling_period)


@pytest.fixture(scope="module")
def before_and_after() -> tuple[Diagnosis, Diagnosis]:
    """The diagnosis with the reading as it is, from which the time is told, and that with the reading late."""
    asked: list[Diagnosis] = []
    module = sys.modules["symid.diagnosis.diagnose"]
    delay_of_load_reading = module.delay_of_load_reading

    def seen(axis: Axis, found: Diagnosis) -> dict[str, float]:
        asked.append(found)
        return delay_of_load_reading(axis, found)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "delay_of_load_reading", seen)
        late = diagnose(SCREW, late_by_a_sample(1), validation=late_by_a_sample(2), nominal=VALUES)
    return asked[0], late


def test_a_cause_beside_impossible_damping_is_not_probable(
    before_and_after: tuple[Diagnosis, Diagnosis],
) -> None:
    found, _ = before_and_after
    first = found.effects[0]
    assert first.effect == "sensor_delay" or first.probability <= 0.5
    assert first.effect == "sensor_delay" or found.probabilities["unexplained"] >= 0.45
    assert first.effect == "sensor_delay" or any(own.is_far_from_physical for own in found.parameters)


def test_the_reading_that_makes_it_impossible_is_named(before_and_after: tuple[Diagnosis, Diagnosis]) -> None:
    _, found = before_and_after
    late = re.match(r"ql is read ([\d.]+) ms late against qm", found.faults[0])
    assert late is not None
    assert float(late[1]) == pytest.approx(1.0, abs=0.01)
    assert {own.name: own.explained for own in found.parameters} == pytest.approx(VALUES, rel=0.03)


def test_a_negative_nominal_mass_is_named() -> None:
    """As least squares give it for a model that lacks much."""
    with pytest.raises(SettingError, match=r"not positive with M -5\.6: .* give others, or none"):
        diagnose(load_axis("rigid_1m"), rigid_log(), nominal={"M": -5.6, "Fv": 8.0, "Fs": 0.1})


@pytest.mark.parametrize("start", [0.2, 0.4])
def test_friction_that_explains_a_constant_force_is_no_model_of_the_machine(start: float) -> None:
    time = np.arange(0, 0.6, 1e-3)
    speed = -90.0 * -np.expm1(-np.maximum(time - start, 0.0) / 0.02)
    log = Log(
        "by hand", 0.0, 1e-3, {"F": np.where(time < start, 1.0, -3600.0), "dq": 4.0 * np.round(speed / 4.0)}
    )
    rotor = Body("rotor", mass="M")
    laws = (ViscousFriction(rotor, "Fv"), CoulombFriction(rotor, "Fs"))
    found = diagnose(Axis("motor", (rotor, *laws), Drive("F", rotor), (Velocity("dq", rotor),)), log)
    assert found.verdict == "recording"
    assert "F hardly changes while the axis moves" in found.sentence


def test_a_mode_beside_masses_that_are_lost_may_be_a_declared_one(monkeypatch: pytest.MonkeyPatch) -> None:
    known = ParameterChange("Mm", "kg", 9.0, 9.0, 0.1, 9.0, 0.1, absorbed=False)
    vague = replace(known, name="Ml", explained=3e65, explained_std=np.inf)
    least = replace(known, name="Kt", explained=8e6, explained_std=np.inf, at_bound=True)
    friction = replace(known, name="Fvm", explained=1.0, explained_std=50.0)
    assert lost(SCREW, (known, friction)) == []
    assert lost(SCREW, (known, vague, friction, least)) == [vague, least]

    alone = replace(ELASTIC, sensors=SENSORS)
    nominal = {"M": 65.0, "Fv": VALUES_OF_MACHINES["Fv"], "Fs": VALUES_OF_MACHINES["Fs"]}
    log = machine(alone, VALUES_OF_MACHINES | {"K": 2e5}, 1)
    library = [effect for effect in LIBRARY if effect.name == "flexible_mode"]
    sure = diagnose(RIGID, log, nominal=nominal, held=True, library=library)
    assert sure.effects[0].probability > 0.9
    assert "may be one that the axis declares" not in sure.sentence
    for module in ("conclusion", "wording"):
        monkeypatch.setattr(f"symid.diagnosis.findings.{module}.lost", lambda axis, parameters: [least])
    doubtful = diagnose(RIGID, log, nominal=nominal, held=True, library=library)
    assert doubtful.effects[0].probability <= 0.5
    assert doubtful.probabilities["unexplained"] >= 0.45
    assert doubtful.sentence.endswith(
        "The mode may be one that the axis declares: give nominal values near those of the machine."
    )
