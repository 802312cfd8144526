"""Logs written by hand with one effect: the verdict names it, its values are found, the gap closes.

The axis that a diagnosis writes is derived from its declaration; it leaves no more than the diagnosis left.
"""

from dataclasses import replace

import numpy as np
import pytest
from hand_made import RIGID, hung, plain_force, rigid_log

from symid import Log, load_axis
from symid.axis import ActuatorDelay, Between, Body, PayloadChange, Spring
from symid.diagnosis import LIBRARY, Diagnosis, diagnose, explained_axis
from symid.diagnosis.effects import Placed
from symid.diagnosis.in_motion.declared import axis_with_effects
from symid.simulation import chirp, plant_of, simulate, trapezoids, tuned_cascade
from symid.units import Unit

SHIFT = 1e-3


EFFECTS = {
    "stribeck_friction": (
        lambda t, q, v, a, path: 25 * np.sign(v) * np.exp(-((v / 0.02) ** 2)),
        {"dF": 25.0, "vs": 0.02},
    ),
    "quadratic_drag": (lambda t, q, v, a, path: 300 * v * np.abs(v), {"c": 300.0}),
    "position_stiffness": (lambda t, q, v, a, path: 500 * q, {"k": 500.0}),
    "position_dependent_friction": (lambda t, q, v, a, path: 9000 * q**2 * v, {"dFv2": 9000.0}),
    "cogging": (lambda t, q, v, a, path: 12 * np.sin(2 * np.pi * q / 0.024), {"As": 12.0, "pitch": 0.024}),
    "flexible_mode": (lambda t, q, v, a, path: hung(path, t), {"m": 30.0, "f": 12.0}),
    "delay": (lambda t, q, v, a, path: plain_force(path, t + SHIFT) - plain_force(path, t), {"T": SHIFT}),
}


@pytest.mark.parametrize("effect", EFFECTS)
def test_one_effect(effect: str) -> None:
    missing, values = EFFECTS[effect]
    log, other = rigid_log(missing), rigid_log(missing, seed=2)
    found = diagnose(load_axis("rigid_1m"), log, validation=other)
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
    if effect == "delay":
        (late,) = explained_axis(found).axis.imperfections
        assert isinstance(late, ActuatorDelay)
        assert late.seconds == pytest.approx(SHIFT, rel=0.06)
    elif not swings:
        assert nominal_multiple(found, log, other) < 1.1 * max(explained_multiple(found), 1.0)


def swinging() -> Log:
    """The motor with 30 kg of its mass on a spring of 12 Hz."""
    axis = load_axis("rigid_1m").with_signal("F", noise=2.0).with_signal("q", noise=2e-8)
    hung = Body("hung", mass="m")
    axis = axis.with_effect(
        hung, Spring("tower", Between(first=axis.bodies[0], second=hung), stiffness="k", damping="c")
    )
    w = 2 * np.pi * 12
    parameters = {"M": 70.0, "Fv": 150.0, "Fs": 8.0, "m": 30.0, "k": 30 * w**2, "c": 2 * 0.05 * w * 30}
    reference = chirp(1.0, 25.0, 6.0, 2.0, quantity="acceleration", sampling_period=1 / 2000)
    return simulate(
        axis, parameters, reference, tuned_cascade(plant_of(axis, parameters), "q", 10.0), seed=1
    ).log


def explained_multiple(found: Diagnosis) -> float:
    """Error with the effects, in multiples of the noise."""
    return found.gap.explained.rms / found.gap.noise_floor.rms


def nominal_multiple(found: Diagnosis, log: Log, validation: Log | None = None, **recorded: bool) -> float:
    """The same of the axis that the diagnosis writes, with its values."""
    explained = explained_axis(found)
    assert set(explained.values) == set(explained.axis.physical_parameters)
    assert explained.left_out == ()
    again = diagnose(
        explained.axis, log, validation=validation, nominal=explained.values, library=(), **recorded
    )
    assert again.gap.nominal is not None
    return again.gap.nominal.rms / again.gap.noise_floor.rms


def test_a_mode_is_written_as_a_body_on_a_spring() -> None:
    log = swinging()
    found = diagnose(load_axis("rigid_1m"), log, held=True)
    assert found.effects[0].effect == "flexible_mode"
    assert nominal_multiple(found, log, held=True) < 1.1 * max(explained_multiple(found), 1.0)


def test_effects_of_a_joint_that_share_a_name_are_written_apart() -> None:
    found = diagnose(load_axis("rigid_1m"), rigid_log(), validation=rigid_log(seed=2), nominal=RIGID)
    asymmetry, waves = (
        next(e for e in LIBRARY if e.amplitudes == names) for names in (("dFs", "dFv"), ("dFs", "dFc"))
    )
    pair = Placed(asymmetry, "motor", (), (3.0, 1.0)), Placed(waves, "motor", (0.1,), (4.0, 5.0))
    written = axis_with_effects(replace(found.search[0].before.state, placed=pair))
    added = {name: value for name, value in written.values.items() if name not in RIGID}
    assert sorted(added.values()) == [1.0, 3.0, 4.0, 5.0]


def test_an_effect_that_makes_the_error_grow_on_the_validation_log_is_left_out() -> None:
    stribeck, late = EFFECTS["stribeck_friction"][0], EFFECTS["delay"][0]
    log = rigid_log(lambda *motion: stribeck(*motion) + late(*motion))
    alone = diagnose(load_axis("rigid_1m"), log, validation=log, nominal=RIGID)
    names = {effect.effect for effect in alone.effects}
    assert "stribeck_friction" in names
    assert names & {"delay", "actuator_lag"}
    found = diagnose(load_axis("rigid_1m"), log, validation=rigid_log(stribeck, seed=2), nominal=RIGID)
    assert [effect.effect for effect in found.effects] == ["stribeck_friction"]
    assert found.effects[0].parameters["dF"].value == pytest.approx(25.0, rel=0.2)


def test_a_clean_log_has_no_gap() -> None:
    found = diagnose(load_axis("rigid_1m"), rigid_log(), validation=rigid_log(seed=2), nominal=RIGID)
    assert found.verdict == "no_gap"
    assert not found.location  # of an error below the floor
    assert found.effects == ()
    assert found.gap.nominal is not None
    assert found.gap.nominal.rms == pytest.approx(found.gap.noise_floor.rms, rel=0.25)


def test_wrong_values_are_parameters_and_no_effect() -> None:
    wrong = {"M": 110.0, "Fv": 120.0, "Fs": 9.5}
    found = diagnose(load_axis("rigid_1m"), rigid_log(), nominal=wrong)
    assert found.verdict == "parameters"
    assert found.effects == ()
    for change in found.parameters:
        assert abs(change.reidentified - RIGID[change.name]) < 5 * change.reidentified_std


def test_a_force_that_nothing_in_the_library_stands_for_is_unexplained() -> None:
    rng = np.random.default_rng(3)

    def walk(t, q, v, a, path):
        course = np.cumsum(rng.standard_normal(t.size)) * 0.6
        return course - course.mean()  # its mean would be an offset, and rightly found as one

    found = diagnose(load_axis("rigid_1m"), rigid_log(walk), validation=rigid_log(walk, seed=2))
    assert found.verdict == "unexplained"
    assert found.effects == ()


@pytest.mark.parametrize("rates", [{"dFs/dt": 2.0}, {"dFs/dt": 1.5, "dFv/dt": 8.0}], ids=len)
def test_friction_that_rises_throughout_the_log_is_a_drift_with_its_rate(rates: dict[str, float]) -> None:
    def rising(t, q, v, a, path):
        return t * (rates["dFs/dt"] * np.sign(v) + rates.get("dFv/dt", 0.0) * v)

    found = diagnose(load_axis("rigid_1m"), rigid_log(rising), validation=rigid_log(rising, seed=2))
    assert (found.verdict, found.effects[0].effect) == ("effect", "friction_drift")
    for name, value in rates.items():
        rate = found.effects[0].parameters[name]
        assert rate.value == pytest.approx(value, rel=0.05, abs=3 * rate.std)
    assert found.effects[0].parameters["dFs/dt"].unit == str(Unit.of("N") / Unit.of("s"))
    assert found.gap.closed_fraction > 0.9


def test_what_the_validation_log_alone_shows_is_found_beside_the_rest() -> None:
    stribeck, cogging = EFFECTS["stribeck_friction"][0], EFFECTS["cogging"][0]
    other = rigid_log(lambda *motion: stribeck(*motion) + 2.5 * cogging(*motion), seed=2)
    found = diagnose(load_axis("rigid_1m"), rigid_log(stribeck), validation=other, nominal=RIGID)
    assert {"stribeck_friction", "cogging"} <= {effect.effect for effect in found.effects}
    assert "validation" in found.assumptions[0]


def test_a_weight_that_the_model_lacks_is_neither_an_absolute_value_nor_friction() -> None:
    heavy = rigid_log(lambda t, q, v, a, path: np.full_like(t, 900.0))
    assert heavy["F"].min() > 0
    found = diagnose(load_axis("rigid_1m"), heavy, nominal=RIGID)
    assert found.verdict == "effect"
    assert (found.effects[0].effect, found.effects[0].indistinguishable_from) == ("offset_force", ())
    assert found.effects[0].parameters["F0"].value == pytest.approx(900.0, rel=0.01)
    light = rigid_log(lambda t, q, v, a, path: np.zeros_like(t))
    absolute = replace(light, signals={**light.signals, "F": np.abs(light["F"])})
    assert diagnose(load_axis("rigid_1m"), absolute, nominal=RIGID).verdict == "recording"


@pytest.mark.parametrize("value", [0.0, None])
def test_a_force_whose_samples_were_lost_in_bursts_is_no_physics(value: float | None) -> None:
    log = rigid_log(lambda t, q, v, a, path: np.zeros_like(t))
    force = log["F"].copy()
    for k in range(400, force.size - 400, 400):
        force[k : k + 60] = force[k] if value is None else value
    found = diagnose(load_axis("rigid_1m"), replace(log, signals={**log.signals, "F": force}), nominal=RIGID)
    assert found.verdict == "recording"
    assert "F keeps exactly one value" in found.sentence


def test_an_axis_that_coasts_while_its_drive_is_off_has_no_absolute_force() -> None:
    rng, t, step = np.random.default_rng(1), np.arange(4000) / 1000, 1e-3
    F = np.where((t > 0.5) & (t < 1.5), 400.0, 0.0)
    v = np.zeros(t.size)
    for k in range(t.size - 1):  # friction that falls while the drive is off
        drag = 300.0 if F[k] > 0.0 else 120.0
        v[k + 1] = v[k] + step * (F[k] - drag * v[k]) / RIGID["M"]
    coasting = Log(
        "coasting", 0.0, step, {"q": step * np.cumsum(v) + 1e-5 * rng.standard_normal(t.size), "F": F}
    )
    assert diagnose(load_axis("rigid_1m"), coasting).verdict != "recording"


def test_a_force_that_would_be_friction_pushing_the_axis_is_none_of_its_friction() -> None:
    # -6000 q v beside 150 v, where q reaches 0.1 m
    coupled = rigid_log(lambda t, q, v, a, path: -6000.0 * q * v)
    found = diagnose(load_axis("rigid_1m"), coupled, nominal=RIGID)
    assert "position_dependent_friction" not in {effect.effect for effect in found.effects}
    mild = rigid_log(lambda t, q, v, a, path: -900.0 * q * v)
    found = diagnose(load_axis("rigid_1m"), mild, nominal=RIGID)
    assert found.effects[0].effect == "position_dependent_friction"


def test_a_payload_that_changes_at_rest_may_have_changed_anywhere_in_the_log() -> None:
    axis = load_axis("rigid_1m").with_signal("q", noise=1e-7).with_signal("F", noise=1.0)
    values = {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    moves = trapezoids([0.1], [0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=1.0, sampling_period=1e-3)
    gains = tuned_cascade(plant_of(axis, values), "q")
    still = simulate(axis, values, moves, gains).log
    speed = np.abs(np.gradient(still["q"], still.sampling_period))
    rests = still.time[(speed < 1e-5) & (still.time > 0.4 * still.time[-1])]
    loaded = axis.with_effect(PayloadChange(axis.bodies[0], 30.0, time=float(np.median(rests[:800]))))
    log = simulate(loaded, values, moves, gains).log
    found = diagnose(axis, log, validation=log, nominal=values, held=True)
    assert found.effects[0].effect == "payload_change"
    assert found.effects[0].parameters["dm"].value == pytest.approx(30.0, rel=0.05)
    assert found.effects[0].parameters["t0"].std <= log.time[-1] / np.sqrt(12) * 1.01
