"""A diagnosis of two drives: a balance each, on logs of a gantry written by hand (tests/axes/driven_gantry.py)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from axes import gantry
from axes.driven_gantry import (
    BEAM,
    COGGING,
    DELAY,
    GAIN,
    HASTE,
    LOAD,
    LOADED,
    PITCH,
    RIPPLE,
    SLOW,
    STRIBECK,
    TRUE,
    axis,
    log,
)

from symid import (
    Axis,
    Body,
    Diagnosis,
    Drive,
    ForceConstantRipple,
    Geared,
    Log,
    PayloadChange,
    Position,
    ViscousFriction,
    diagnose,
)
from symid.diagnosis import explained_axis, next_experiment_of
from symid.diagnosis.experiment import discrimination
from symid.diagnosis.experiment.discrimination import drive_ratios
from symid.errors import LogError, SettingError
from symid.report.pages.diagnosis_page import write_diagnosis_html
from symid.report.tables.diagnosis import diagnosis_record, print_diagnosis
from symid.simulation import Cascade

R = 0.0127 / 2
"""Half the radius of the pulleys of crossed belts, m/rad."""


@cache
def found(hidden: str = "", *, friction_on_the_right: bool = True) -> Diagnosis:
    """The diagnosis of a hidden effect by values that are 15 % off, with a held-out log."""
    declared = axis(friction_on_the_right=friction_on_the_right)
    off = {name: value * (1.15 if i % 2 else 0.85) for i, (name, value) in enumerate(TRUE.items())}
    nominal = {name: value for name, value in off.items() if name in declared.physical_parameters}
    return diagnose(declared, log(hidden), validation=log(hidden, 3.0, 2), nominal=nominal, held=False)


def test_without_an_effect_values_were_off_and_each_force_is_at_its_noise() -> None:
    plain = found()
    assert plain.verdict == "parameters"
    assert [own.gap.signal for own in plain.drives] == ["F1", "F2"]
    for own in plain.drives:
        assert own.gap.reidentified.rms == pytest.approx(own.gap.noise_floor.rms, rel=0.1)
        assert own.gap.nominal is not None
        assert own.gap.nominal.rms > 20 * own.gap.noise_floor.rms
    for change in plain.parameters:
        assert change.reidentified == pytest.approx(TRUE[change.name], rel=0.02), change.name


@pytest.mark.parametrize(
    ("hidden", "effect", "at", "drive", "values"),
    [
        ("stribeck", "stribeck_friction", "right", "F2", {"dF": STRIBECK, "vs": SLOW}),
        ("delay", "delay", "F1", "F1", {"T": DELAY}),
        ("cogging", "cogging", "left", "F1", {"pitch": PITCH}),
    ],
)
def test_an_effect_is_named_with_its_drive(
    hidden: str, effect: str, at: str, drive: str, values: dict[str, float]
) -> None:
    named = found(hidden)
    assert named.verdict == "effect"
    assert [(e.effect, e.at, e.signal) for e in named.effects] == [(effect, at, drive)]
    assert named.gap.signal == drive
    for name, value in values.items():
        assert named.effects[0].parameters[name].value == pytest.approx(value, rel=0.05)
    assert named.effects[0].removes.low > 0.9
    for own in named.drives:
        assert own.gap.explained.rms < 1.15 * own.gap.noise_floor.rms


def test_the_amplitude_of_a_ripple() -> None:
    ripple = found("cogging").effects[0].parameters
    assert np.hypot(ripple["As"].value, ripple["Ac"].value) == pytest.approx(COGGING, rel=0.03)


def test_friction_that_the_axis_lacks_at_one_drive() -> None:
    lacking = found(friction_on_the_right=False)
    assert [(e.effect, e.at, e.signal) for e in lacking.effects] == [("coulomb_friction", "right", "F2")]
    assert lacking.effects[0].parameters["Fs"].value == pytest.approx(TRUE["Fs2"], rel=0.01)
    left, right = (own.gap for own in lacking.drives)
    assert right.reidentified.rms > 20 * right.noise_floor.rms
    assert left.reidentified.rms < 1.3 * left.noise_floor.rms
    assert lacking.sentence.startswith(
        "The model lacks Coulomb friction at right: with it, the force errors fall from"
    )


def test_effects_of_both_drives_are_found_together() -> None:
    declared = axis(friction_on_the_right=False)
    nominal = {name: 1.15 * value for name, value in TRUE.items() if name in declared.physical_parameters}
    both = diagnose(declared, log("cogging"), validation=log("cogging", 3.0, 2), nominal=nominal, held=False)
    assert [(e.effect, e.at, e.signal) for e in both.effects] == [
        ("coulomb_friction", "right", "F2"),
        ("cogging", "left", "F1"),
    ]
    for own in both.drives:
        assert own.gap.explained.rms < 1.15 * own.gap.noise_floor.rms


@pytest.mark.usefixtures("plain_pages")
def test_print_and_page_show_each_drive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    print_diagnosis(diagnosis_record(found("delay")))
    printed = capsys.readouterr().out
    write_diagnosis_html(found("delay"), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Force error of each drive" in printed
    assert "Force error of each drive" in page
    for own in found("delay").drives:
        assert f"{own.gap.explained.rms:.4g} N" in printed
        assert f"<td>{own.gap.explained.rms:.4g} N</td>" in page


def test_the_record_has_a_gap_for_each_drive_in_its_unit() -> None:
    record = diagnosis_record(found("delay"))
    assert [(gap["signal"], gap["unit"]) for gap in record["drives"]] == [("F1", "N"), ("F2", "N")]
    assert record["gap"] == record["drives"][0]
    assert [gap["motion"]["signal"] for gap in record["drives"]] == ["q1", "q2"]


def test_the_simulated_motion_of_each_drive_is_that_of_the_closed_loop() -> None:
    """The independent way: the equations by hand with the nominal values, under the same controllers."""
    held_out, nominal = log("", 3.0, 2), TRUE | {"Mb": 92.0, "Fv1": 120.0}
    loops = [Cascade(name, HASTE, GAIN, 0.0) for name in ("q1", "q2")]
    run = diagnose(
        axis(), log(), validation=held_out, nominal=nominal, held=False, library=(), controller=loops
    )
    other = log("", 3.0, 2, nominal["Mb"], nominal["Fv1"])
    for own, name in zip(run.drives, ("q1", "q2"), strict=True):
        motion = own.gap.motion
        assert (motion.signal, motion.driver) == (name, "given")
        error = np.sqrt(np.mean((held_out[name] - other[name]) ** 2))
        assert motion.nominal.position_rms == pytest.approx(error, rel=0.05)
        assert motion.explained.position_rms < 0.1 * error
        wanted = held_out[f"reference_F{name[1]}"]
        tracking = np.sqrt(np.mean((wanted - held_out[name]) ** 2))
        assert motion.tracking_rms == pytest.approx(tracking, rel=1e-6)


def test_with_the_effect_of_one_drive_its_simulated_motion_comes_nearer() -> None:
    named = found("cogging")
    for own in named.drives:
        assert own.gap.motion.driver == "identified"
        assert own.gap.motion.explained.position_rms < 0.5 * own.gap.motion.reidentified.position_rms
    assert "off the measured q1 instead of" in named.sentence


def test_two_drives_need_two_controllers() -> None:
    with pytest.raises(SettingError, match="there are 1 controllers and 2 drives"):
        diagnose(axis(), log(), nominal=TRUE, library=(), controller=[Cascade("q1", HASTE, GAIN, 0.0)])


@pytest.fixture
def two_motions(monkeypatch: pytest.MonkeyPatch) -> None:
    """The next experiment is chosen from two motions only."""
    every = discrimination.candidate_motions
    monkeypatch.setattr(discrimination, "candidate_motions", lambda envelope: every(envelope)[:2])


@pytest.mark.usefixtures("two_motions")
def test_the_next_experiment_moves_both_drives_as_the_log_did() -> None:
    planned = next_experiment_of(found("delay"))
    assert planned.causes == (("delay", "F1"), ("actuator_lag", "F1"))
    left, right = planned.paths
    assert planned.trajectory is not None
    assert np.array_equal(left.position, planned.trajectory.position)
    apart = np.ptp(right.position - left.position)
    assert apart < 1e-9  # no skew is commanded
    assert "All drives follow it as they did in the log, alike." in planned.text
    assert "cannot be an element of an axis" not in planned.message


@pytest.mark.usefixtures("two_motions")
def test_the_next_experiment_is_simulated_with_both_drives() -> None:
    named = found("cogging")
    planned = next_experiment_of(named)
    (cause, rival) = planned.causes
    assert cause == ("cogging", "left")
    assert rival in (("encoder_ripple", "q2"), ("force_constant_ripple", "F1"))
    assert planned.probability > 0.9
    assert planned.simulated is not None
    for name, force in planned.simulated.forces.items():
        assert 0.02 * force < force <= 1.03 * np.abs(named.record.log[name]).max()


def test_drives_that_run_against_each_other_go_on_so() -> None:
    """A mirrored axis: the second motor counts backwards, from another zero."""
    run = log()
    turned = {"q2": 0.3 - run["q2"], "F2": -run["F2"]}
    like = found().record
    mirrored = replace(like, log=replace(run, signals={**run.signals, **turned}))
    plain, share = drive_ratios(mirrored)
    assert (plain.factor, plain.offset, share.factor) == (1.0, 0.0, -1.0)
    assert share.offset == pytest.approx(0.3, abs=1e-3)


def test_each_drive_needs_a_position() -> None:
    run = log()
    lacking = replace(run, signals={name: x for name, x in run.signals.items() if name != "q2"})
    with pytest.raises(
        LogError, match="has independent positions q1: a diagnosis of 2 drives needs one for each"
    ):
        diagnose(axis(), lacking, nominal=TRUE)


def test_drives_that_push_the_same_body_are_refused() -> None:
    table = Body("table", mass="M")
    tandem = Axis(
        "tandem",
        (table, ViscousFriction(table, "Fv")),
        (Drive("F1", table), Drive("F2", table)),
        (Position("q", table),),
    )
    t = np.arange(2000) / 1000
    run = Log("by hand", 0.0, 1e-3, {"F1": np.sin(t), "F2": np.cos(t), "q": 0.1 * np.sin(t)})
    with pytest.raises(SettingError, match="drives F1, F2 of axis 'tandem' push the same way"):
        diagnose(tandem, run, nominal={"M": 1.0, "Fv": 1.0})


def test_least_squares_is_another_start_where_springs_between_the_drives_lead_astray() -> None:
    off = {name: value * (1.1 if i % 2 else 0.9) for i, (name, value) in enumerate(gantry.TRUE.items())}
    plain = diagnose(gantry.AXIS, gantry.log(), nominal=off, held=False, library=())
    for change in plain.parameters:
        assert change.reidentified == pytest.approx(gantry.TRUE[change.name], rel=0.01), change.name


def test_a_ripple_of_one_force_constant_is_that_of_its_drive() -> None:
    named = found("force constant")
    assert [(e.effect, e.at) for e in named.effects] == [("force_constant_ripple", "F1")], named.sentence
    (ripple,) = explained_axis(named).axis.imperfections
    assert isinstance(ripple, ForceConstantRipple)
    assert ripple.drive == "F1"
    assert ripple.sine == pytest.approx(RIPPLE, rel=0.05)
    assert ripple.pitch == pytest.approx(PITCH, rel=1e-3)


def test_a_load_of_a_body_that_two_drives_move_is_found_there() -> None:
    named = found("payload")
    assert [(e.effect, e.at) for e in named.effects] == [("payload_change", "beam")], named.sentence
    values = named.effects[0].parameters
    assert values["dm"].value == pytest.approx(LOAD, rel=0.03)
    assert values["t0"].value == pytest.approx(LOADED, abs=0.01)
    (change,) = explained_axis(named).axis.imperfections
    assert isinstance(change, PayloadChange)
    assert change.body == BEAM


def test_friction_of_a_body_that_two_drives_move_is_found_there() -> None:
    """The slide of crossed belts moves by the difference of two motors; its motion is that of no other body."""
    one, other = Body("one", inertia=2.3e-4), Body("other", inertia=2.3e-4)
    across = Body("across", mass="Mx", geared=(Geared(to=one, ratio=R), Geared(to=other, ratio=R)))
    along = Body("along", mass="My", geared=(Geared(to=one, ratio=R), Geared(to=other, ratio=-R)))
    slides = (one, other, across, along, ViscousFriction(across, "Fvx"), ViscousFriction(along, "Fvy"))
    sensors = (Position("q1", one), Position("q2", other))
    crossed = Axis("crossed", slides, (Drive("T1", one), Drive("T2", other)), sensors)
    t, rng = np.arange(12000) / 2000, np.random.default_rng(1)
    tones = np.array([[0.9, 3.3, 11.0], [0.7, 4.1, 13.0]]) * 2 * np.pi
    sizes = np.array([[0.08, 0.02, 0.002], [0.06, 0.02, 0.002]])
    phases = rng.uniform(0, 2 * np.pi, (2, 3))
    angles = tones[..., None] * t + phases[..., None]
    (x, y), (vx, vy), (ax, ay) = (
        np.einsum("ij,ijn->in", sizes * tones**order, wave)
        for order, wave in enumerate((np.sin(angles), np.cos(angles), -np.sin(angles)))
    )
    fx, fy = 3.1 * ax + 14.0 * vx, 1.9 * ay + 9.0 * vy + 4.0 * np.sign(vy)
    moved = {"q1": (x + y) / (2 * R), "q2": (x - y) / (2 * R)}
    inertial = {"T1": 2.3e-4 * (ax + ay) / (2 * R), "T2": 2.3e-4 * (ax - ay) / (2 * R)}
    torques = {"T1": inertial["T1"] + R * (fx + fy), "T2": inertial["T2"] + R * (fx - fy)}
    noisy = {name: force + 3e-3 * rng.standard_normal(t.size) for name, force in torques.items()}
    run = Log("crossed", 0.0, 1 / 2000, {**moved, **noisy})
    nominal = {"Mx": 3.1 * 1.15, "My": 1.9 * 0.85, "Fvx": 14.0 * 1.15, "Fvy": 9.0 * 0.85}
    named = diagnose(crossed, run, nominal=nominal, held=False)
    assert [(e.effect, e.at) for e in named.effects] == [("coulomb_friction", "along")], named.sentence
    assert named.effects[0].parameters["Fs"].value == pytest.approx(4.0, rel=0.02)
