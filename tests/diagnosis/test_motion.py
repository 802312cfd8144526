"""The gap in the motion: the replayed loop beside the closed loop itself, an observer, another simulator, failures."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hand_made import RIGID, rigid_log

from benchmarks.diagnosis.motion import cases, emps_log, row_of
from symid import Axis, Body, CoulombFriction, Drive, Log, PendulumWeight, Position, load_axis
from symid.axis import STANDARD_GRAVITY
from symid.codegen import model_of
from symid.diagnosis import diagnose, diagnose_against
from symid.diagnosis.effects import effects_of
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted_on
from symid.diagnosis.fitting.state import evaluated
from symid.diagnosis.in_motion.declared import ExplainedAxis, axis_with_effects
from symid.diagnosis.in_motion.motion import is_contradicted
from symid.diagnosis.in_motion.replayed import (
    Part,
    driver_of,
    falling_stiffness,
    fastest,
    simulated_positions,
)
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError
from symid.report.tables.diagnosis import diagnosis_record
from symid.simulation import Cascade, ClosedLoop, plant_of, simulate, trapezoids, tuned_cascade

LOOP = Cascade("q", position_gain=40.0, velocity_gain=6000.0, integral_gain=8.0)
DECLARED = load_axis("rigid_1m")
FRICTIONLESS = replace(DECLARED.without(DECLARED.laws[1]), name="frictionless")
NOMINAL = {"M": 100.0, "Fv": 150.0}
COULOMB = effects_of(CoulombFriction)


def moves(levels: list[float], seed: int, missing: dict[str, float] | None = None, kind: str = "") -> Log:
    """The rigid axis with friction under `LOOP`, to and fro."""
    axis = load_axis("rigid_1m").with_signal("q", noise=2e-8).with_signal("F", noise=0.2)
    path = trapezoids(levels, 0.3, acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    return replace(simulate(axis, RIGID | (missing or {}), path, LOOP, seed=seed).log, source=f"moves {kind}")


@pytest.fixture(scope="module")
def logs() -> tuple[Log, Log]:
    """A log, and another along other strokes."""
    return moves([0.1, 0.02, 0.15, 0.05] * 2, 1), moves([0.12, 0.04, 0.09] * 2, 2)


@pytest.fixture(scope="module")
def found(logs: tuple[Log, Log]):
    """Coulomb friction missed, controller read from the log, gap on the other log."""
    return diagnose(FRICTIONLESS, logs[0], validation=logs[1], nominal=NOMINAL, held=True, library=COULOMB)


def test_the_controller_is_read_from_the_log(found) -> None:
    motion = found.gap.motion
    assert motion.driver == "identified"
    assert motion.share > 0.99
    assert motion.gains["Kpp"] == pytest.approx(40.0, rel=0.05)
    assert motion.gains["Kpv"] == pytest.approx(6000.0, rel=0.05)


@pytest.mark.parametrize("given", [False, True])
def test_errors_are_those_of_the_closed_loop_along_the_reference(found, logs, given: bool) -> None:
    """The independent way: the axis without friction under the true controller along the reference, no log replayed."""
    motion, log = found.gap.motion, logs[1]
    if given:
        own = {"validation": log, "nominal": NOMINAL, "held": True, "library": (), "controller": LOOP}
        motion = diagnose(FRICTIONLESS, logs[0], **own).gap.motion
        assert motion.driver == "given"
    loop = ClosedLoop(FRICTIONLESS, LOOP).run({"M": 100.0, "Fv": 150.0}, log)
    error = log["q"] - loop["q"]
    assert motion.nominal.position_rms == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.03)
    tracking = log["reference"] - log["q"]
    fit = 100 * (1 - np.linalg.norm(error) / np.linalg.norm(tracking - tracking.mean()))
    assert motion.nominal.tracking_fit == pytest.approx(fit, abs=0.5)
    assert motion.tracking_rms == pytest.approx(np.sqrt(np.mean(tracking**2)), rel=1e-6)


def test_with_the_missing_effect_the_simulated_axis_moves_as_the_machine_did(found, logs) -> None:
    motion = found.gap.motion
    assert [(e.effect, e.at) for e in found.effects] == [("coulomb_friction", "motor")]
    assert motion.explained == motion.steps[-1]
    assert motion.explained.position_rms < 0.05 * motion.reidentified.position_rms
    assert motion.explained.tracking_fit > 99 > motion.reidentified.tracking_fit
    assert motion.explained.reversal_rms < 0.1 * motion.reidentified.reversal_rms
    assert f"{1e6 * motion.explained.position_rms:.3g} um off the measured position" in found.sentence
    record = diagnosis_record(found)["gap"]["motion"]
    assert record["explained"]["tracking_fit"] == motion.explained.tracking_fit
    assert record["driver"] == "identified"


def test_effects_that_make_the_motion_worse_are_no_causes(logs, monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules[is_contradicted.__module__]
    monkeypatch.setattr(module, "THRESHOLDS", replace(THRESHOLDS, worse_motion=1e-3))
    given = {"validation": logs[1], "nominal": NOMINAL, "held": True, "library": COULOMB}
    found = diagnose(FRICTIONLESS, logs[0], **given)
    assert found.verdict == "unexplained"
    assert not found.effects
    assert found.gap.explained == found.gap.reidentified
    assert found.alternatives[0].effect == "coulomb_friction"
    assert found.alternatives[0].probability <= 0.1
    assert "Rejected: Coulomb friction at motor" in found.assumptions[-1]


@pytest.mark.parametrize(("off", "speaks"), [(0.2, True), (0.3, False)])
def test_motion_off_by_a_quarter_of_a_pitch_says_nothing_of_a_force_that_repeats(
    off: float, speaks: bool
) -> None:
    cogging = SimpleNamespace(effect="cogging", parameters={"pitch": SimpleNamespace(value=1.0)})
    before, after = SimpleNamespace(position_rms=off), SimpleNamespace(position_rms=2 * off)
    motion = SimpleNamespace(reidentified=before, steps=(after,))
    assert is_contradicted(SimpleNamespace(effects=(cogging,), gap=SimpleNamespace(motion=motion))) is speaks


@pytest.mark.parametrize(
    ("after", "last", "speaks"), [(np.nan, 4.0, True), (np.nan, 0.5, False), (4.0, 0.5, False)]
)
def test_the_last_model_speaks_for_one_that_cannot_be_simulated(
    after: float, last: float, speaks: bool
) -> None:
    effects = (SimpleNamespace(effect="cogging", parameters={}),) * 2
    before, *steps = (SimpleNamespace(position_rms=rms) for rms in (1.0, after, last))
    motion = SimpleNamespace(reidentified=before, steps=tuple(steps))
    assert is_contradicted(SimpleNamespace(effects=effects, gap=SimpleNamespace(motion=motion))) is speaks


@pytest.mark.parametrize(
    ("effect", "worse", "speaks"),
    [("flexible_mode", 1.2, True), ("spring_damping", 1.2, False), ("spring_damping", 1.6, True)],
)
def test_a_mode_must_not_make_the_motion_worse(effect: str, worse: float, speaks: bool) -> None:
    before, after = SimpleNamespace(position_rms=1.0), SimpleNamespace(position_rms=worse)
    motion = SimpleNamespace(reidentified=before, steps=(after,))
    effects = (SimpleNamespace(effect=effect, parameters={}),)
    assert is_contradicted(SimpleNamespace(effects=effects, gap=SimpleNamespace(motion=motion))) is speaks


def test_what_was_found_is_fitted_on_until_nothing_falls(found) -> None:
    fit = next(step for step in found.search if step.accepts).best.fit
    off = {name: 1.01 * value for name, value in fit.parameters.items()}
    begun = Fit(evaluated(fit.state, fit.weighting, off, fit.state.placed), fit.weighting)
    after = fitted_on(begun)
    assert after.mean_square < 0.5 * begun.mean_square
    written = axis_with_effects(after.state)
    for name, value in RIGID.items():
        assert next(v for n, v in written.values.items() if n.endswith(name)) == pytest.approx(
            value, rel=2e-3
        )


def test_without_a_reference_an_observer_drives() -> None:
    """A viscous coefficient known too low by 30 N s/m: a steady force error dF leaves dF/(Kpv Kpp) of position."""
    log = rigid_log(seconds=5.0)
    nominal = RIGID | {"Fv": 120.0}
    motion = diagnose(load_axis("rigid_1m"), log, nominal=nominal, library=()).gap.motion
    assert (motion.driver, np.isnan(motion.tracking_rms)) == ("observer", True)
    assert motion.gains["Kpv"] == pytest.approx(RIGID["M"] * 2 * np.pi * 2.0, rel=0.02)
    t, q = log.time, log["q"]
    v = np.gradient(q, t)
    kv, kp = motion.gains["Kpv"], motion.gains["Kpv"] * motion.gains["Kpp"]
    # e = measured - simulated: M e'' + (Fv + Kv) e' + Kp e = -(difference of forces), by explicit Euler
    e = de = 0.0
    course = np.zeros(t.size)
    for k in range(t.size - 1):
        force = -30.0 * v[k] - (120.0 + kv) * de - kp * e
        de += force / RIGID["M"] / 2000.0
        e += de / 2000.0
        course[k + 1] = e
    used = np.floor(t / 5.0 * 12) % 3 == 1
    assert motion.nominal.position_rms == pytest.approx(np.sqrt(np.mean(course[used] ** 2)), rel=0.1)
    assert motion.reidentified.position_rms < 0.2 * motion.nominal.position_rms


def test_a_simulation_that_fails_is_a_status(logs) -> None:
    wild = Cascade("q", position_gain=4e5, velocity_gain=9e9, integral_gain=0.0)
    motion = diagnose(
        FRICTIONLESS, logs[0], nominal=NOMINAL, held=True, library=(), controller=wild
    ).gap.motion
    assert motion.reidentified.status == "failed"
    assert "runs away" in motion.reidentified.message
    assert np.isnan(motion.reidentified.position_fit)


def test_the_users_own_simulator_is_the_nominal_motion(logs) -> None:
    log = logs[0]
    model_of(FRICTIONLESS, ("q",))  # derived, since it is not among those generated
    own = ClosedLoop(FRICTIONLESS, LOOP).run({"M": 97.0, "Fv": 150.0}, log)
    found = diagnose_against(FRICTIONLESS, log, own, held=True, library=COULOMB)
    used = np.floor(np.arange(log.n_samples) / log.n_samples * 12) % 3 == 1
    error = (log["q"] - own["q"])[used]
    assert found.gap.motion.nominal.position_rms == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.01)
    assert found.gap.motion.explained.position_rms < 0.1 * found.gap.motion.nominal.position_rms


def test_a_flexible_axis_begins_at_rest_where_the_sensor_reads() -> None:
    values = {"Ms": 3899.0, "Fvs": 4000.0, "Ks": 1e9, "Mm": 362.58, "Fvm": 90.0, "Fsm": 146.0}
    plant = plant_of(load_axis("direct_2m1s"), values)
    state = plant.follows({"q2": (0.2, 0.1)})
    row = plant.sensors["q2"].row
    assert row @ state[:2] == pytest.approx(0.2)
    assert row @ state[2:] == pytest.approx(0.1)
    assert plant.stiffness @ state[:2] == pytest.approx(np.zeros(2), abs=1e-3)


def test_the_real_pendulum_moves_more_like_its_simulation_with_what_was_found() -> None:
    (case,) = cases(["pendulum-frictionless-ddp"])
    found = diagnose(case.axis, case.training, validation=case.held_out, nominal=case.nominal)
    row = row_of(case, found)
    assert row["effects"] == ["coulomb_friction at pendulum"]
    assert row["+ coulomb_friction"]["position_rms"] < 0.5 * row["re-identified"]["position_rms"]
    assert row["+ coulomb_friction"]["tracking_fit"] > row["nominal"]["tracking_fit"]


def test_the_reference_of_emps_goes_with_its_log() -> None:
    log = emps_log(load_axis("emps"), "DATA_EMPS")
    error = log["reference"] - log["q"]
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.ptp(log["q"])


def test_an_observer_holds_a_pendulum_upright(logs) -> None:
    arm = Body("arm", inertia="J")
    axis = Axis("upright", (arm, PendulumWeight(arm, "ml")), Drive("F", arm), (Position("q", arm),))
    turned = Log.from_arrays({"q": np.linspace(-1.0, 4.0, 500), "F": np.zeros(500)}, sampling_period=1e-3)
    part = Part(turned, np.ones(500, dtype=bool), SimpleNamespace(driven=("q",), forces=("F",)))
    hanging = replace(part, log=Log.from_arrays({"q": np.linspace(-1, 1, 500)}, sampling_period=1e-3))
    pendulum = ExplainedAxis(axis, {"J": 0.01, "ml": 0.3}, ())
    falling = falling_stiffness(pendulum, part)
    assert falling == pytest.approx(STANDARD_GRAVITY * 0.3, rel=0.02)
    assert falling_stiffness(pendulum, hanging) == 0.0
    cascade = driver_of(part.record, [part], None, 0.01, falling).cascade
    assert cascade.position_gain * cascade.velocity_gain > 1.9 * falling


def test_an_axis_too_stiff_for_the_log_is_not_simulated(logs) -> None:
    axis, log = load_axis("direct_2m1s"), logs[0]
    values = {"Ms": 900.0, "Fvs": 0.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 0.0, "Fsm": 0.0}
    # nothing joins the motor to it
    assert fastest(plant_of(axis, values)) == pytest.approx(np.sqrt(4e7 / 900.0))
    stiff = ExplainedAxis(axis, values | {"Ks": 4e16}, ())
    with pytest.raises(SettingError, match="too fast for the log's samples"):
        simulated_positions(stiff, [SimpleNamespace(log=log)], [])


def test_an_effect_of_machine_and_simulator_is_no_difference() -> None:
    """The force of both is held from sample to sample, so that it acts half a sample late."""
    axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    noisy = axis.with_signal("q", noise=1e-7).with_signal("F", noise=1.0)
    reference = trapezoids(0.1, [0.1, 0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(axis, values), "q")
    machine, simulator = (
        simulate(noisy, values | {"Fs": level}, reference, loop, seed=seed).log
        for seed, level in enumerate((36.0, 30.0))
    )
    found = diagnose_against(axis, machine, simulator)
    assert found.verdict == "parameters"
    assert found.simulated is not None
    (late,) = found.simulated.effects
    assert late.effect in ("delay", "actuator_lag")
    assert late.machine is not None
    assert not late.differs
