"""Every effect: a machine that has it is diagnosed, the axis written, read again and simulated under the controller."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.effect_machines import (
    ELASTIC,
    KINDS,
    LOAD,
    LOOP,
    MOTOR,
    RIGID,
    SENSORS,
    VALUES,
    Kind,
    machine,
    path,
)
from symid import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Imperfection,
    PayloadChange,
    PeriodicForce,
    PeriodicFriction,
    Position,
    PreslidingFriction,
    Unbalance,
    ViscousFriction,
    Weight,
    derive,
    load_axis,
    write_axis,
)
from symid.diagnosis import LIBRARY, diagnose, explained_axis
from symid.diagnosis.in_motion.declared import impossible_values
from symid.export import c_source, mjcf
from symid.report.tables.derivation import derivation_record
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
from symid.simulation.reference_loop import without_noise

CLOSELY = Kind(
    "position_dependent_friction", PeriodicFriction(MOTOR, "dS", "dC", pitch=0.0173), {"dS": 5.0, "dC": 3.0}
)
"""Friction that repeats more closely than the pitches that are tried."""


def improved(
    axis: Axis,
    has: Axis,
    values: dict[str, float],
    kind: str,
    folder: Path,
    nominal: dict[str, float] = VALUES,
) -> tuple[float, float]:
    """Error of the position on another run, before and after: the re-identified and the written axis under `LOOP`.

    The written axis is read from its file and simulated along the reference: nothing of the log drives it.
    """
    library = [effect for effect in LIBRARY if effect.name == kind]
    nominal = {name: nominal[name] for name in axis.physical_parameters}
    found = diagnose(
        axis, machine(has, values, 1), nominal=nominal, held=True, library=library, controller=LOOP
    )
    assert [effect.effect for effect in found.effects][:1] == [kind]
    explained = explained_axis(found)
    assert not explained.left_out
    write_axis(explained.axis, folder / "written.py")
    written = load_axis(str(folder / "written.py"))
    log = machine(has, values, 2)
    before, after = (
        simulate(without_noise(model), parameters, path(2), LOOP).log
        for model, parameters in (
            (axis, {change.name: change.reidentified for change in found.parameters}),
            (written, explained.values),
        )
    )
    assert found.gap.motion.explained.position_rms < found.gap.motion.reidentified.position_rms
    return tuple(float(np.sqrt(np.mean((log["q"] - run["q"]) ** 2))) for run in (before, after))


@pytest.mark.parametrize(  # the last one, a weight, has a test of its own
    "kind", [*KINDS[:-1], CLOSELY], ids=lambda kind: f"{kind.effect}-{type(kind.element).__name__}"
)
def test_a_written_effect_brings_the_simulated_position_nearer(kind: Kind, tmp_path: Path) -> None:
    before, after = improved(kind.plain, kind.axis, {**VALUES, **kind.values}, kind.effect, tmp_path)
    assert after < (0.8 if kind.lacking is ELASTIC else 0.5) * before


def test_a_flexible_mode_too(tmp_path: Path) -> None:
    alone = replace(ELASTIC, sensors=SENSORS)
    values = VALUES | {"M": 65.0, "K": 2e5}
    before, after = improved(RIGID, alone, VALUES | {"K": 2e5}, "flexible_mode", tmp_path, nominal=values)
    assert after < 0.5 * before


def test_a_part_of_a_hoisted_body_on_a_spring_keeps_its_weight(tmp_path: Path) -> None:
    alone = replace(ELASTIC, sensors=SENSORS).with_effect(Weight(MOTOR), Weight(LOAD))
    values = VALUES | {"M": 65.0, "K": 2e5}
    hung = RIGID.with_effect(Weight(MOTOR))
    before, after = improved(hung, alone, VALUES | {"K": 2e5}, "flexible_mode", tmp_path, nominal=values)
    assert after < 0.5 * before


@pytest.mark.parametrize(
    ("kind", "here", "there"),
    [
        ("payload_change", PayloadChange(MOTOR, 8.0, time=9.0), PayloadChange(MOTOR, 8.0, time=4.0)),
        ("periodic_disturbance", PeriodicForce(MOTOR, 6.0, 3.0, 7.3), PeriodicForce(MOTOR, 3.0, -6.0, 7.3)),
    ],
)
def test_moments_and_phases_are_written_as_the_validation_log_has_them(
    kind: str, here: Imperfection, there: Imperfection
) -> None:
    logs = [machine(RIGID.with_effect(one), VALUES, seed) for seed, one in enumerate((here, there), start=1)]
    library = [effect for effect in LIBRARY if effect.name == kind]
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    found = diagnose(RIGID, logs[0], validation=logs[1], nominal=nominal, held=True, library=library)
    explained = explained_axis(found)
    without, written = (
        np.std(logs[1]["q"] - simulate(without_noise(model), explained.values, path(2), LOOP).log["q"])
        for model in (RIGID, explained.axis)
    )
    assert written < 0.02 * without


def test_a_written_axis_leaves_no_gap_on_another_log(tmp_path: Path) -> None:
    has = RIGID.with_effect(ActuatorDelay(8e-4))
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    explained = explained_axis(diagnose(RIGID, machine(has, VALUES, 1), nominal=nominal, held=True))
    write_axis(explained.axis, tmp_path / "written.py")
    written = load_axis(str(tmp_path / "written.py"))
    again = diagnose(written, machine(has, VALUES, 2), nominal=explained.values, held=True)
    assert again.verdict in ("no_gap", "parameters")
    settled = explained_axis(again)  # no effect: the axis as it is, its values identified again
    assert settled.axis.without(*settled.axis.imperfections) == written.without(*written.imperfections)
    (delay,) = settled.axis.imperfections
    assert delay.seconds == pytest.approx(8e-4, abs=2e-5)
    assert settled.values == pytest.approx(explained.values, rel=0.02)


def test_a_late_reading_is_written_with_its_sensor(tmp_path: Path) -> None:
    late = ELASTIC.with_signal("ql", noise=1e-7, delay=0.0025)
    library = [effect for effect in LIBRARY if effect.name == "sensor_delay"]
    found = diagnose(
        ELASTIC, machine(late, VALUES, 1), nominal=VALUES, held=True, library=library, controller=LOOP
    )
    explained = explained_axis(found)
    write_axis(explained.axis, tmp_path / "written.py")
    written = load_axis(str(tmp_path / "written.py"))
    assert written.sensors[1].delay == pytest.approx(0.0025, abs=5e-5)
    log = machine(late, VALUES, 2)
    again = diagnose(written, log, nominal=explained.values, held=True, library=library, controller=LOOP)
    assert not again.effects
    before, after = (
        np.std(log["ql"] - simulate(without_noise(model), explained.values, path(2), LOOP).log["ql"])
        for model in (ELASTIC, written)
    )
    assert after < 0.1 * before


def test_a_weight_of_unknown_angle_is_written(tmp_path: Path) -> None:
    table = Body("table", inertia="J")
    laws = ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs")
    light = Axis("table", (table, *laws), Drive("F", table), (Position("q", table),))
    light = light.with_signal("q", noise=1e-6).with_signal("F", noise=0.02)
    values = {"J": 0.6, "Fv": 1.5, "Fs": 1.0}
    heavy, weighs = light.with_effect(Unbalance(table, "Gs", "Gc")), values | {"Gs": 4.0, "Gc": -2.0}
    loop = tuned_cascade(plant_of(light, values), "q")
    course = trapezoids([2.0, 0.7], [0.5, 2.0], acceleration=8.0, jerk=200.0, dwell=0.1, sampling_period=1e-3)
    log = simulate(heavy, weighs, course, loop).log
    found = diagnose(light, log, nominal=values, held=True)
    assert (found.effects[0].effect, found.effects[0].at) == ("weight", "table")
    explained = explained_axis(found)
    write_axis(explained.axis, tmp_path / "written.py")
    (weight,) = (law for law in load_axis(str(tmp_path / "written.py")).laws if isinstance(law, Unbalance))
    assert explained.values[weight.sine] == pytest.approx(4.0, rel=0.01)
    assert explained.values[weight.cosine] == pytest.approx(-2.0, rel=0.01)


def test_exports_say_what_they_lack_and_the_regressor_passes_it_over() -> None:
    axis = RIGID.with_effect(ActuatorLag(0.004), PreslidingFriction(MOTOR, 12.0, reach=3e-4))
    model = derive(axis, ("q",))
    assert str(model) == str(derive(RIGID, ("q",)))
    assumptions = derivation_record(model)["assumptions"]
    assert "ActuatorLag is not in the regressor, simulated only: 0.004 s f(1) + f = F" in assumptions
    (lost,) = [loss for loss in mjcf(axis, VALUES).losses if "left out: " in loss]
    assert lost.startswith("PreslidingFriction: MuJoCo has no such element; left out: 12 (z - sign(v))")
    assert not any("left out: " in loss for loss in c_source(model, VALUES).losses)


def test_no_effect_of_the_library_is_left_out_here() -> None:
    here = {*(kind.effect for kind in KINDS), "flexible_mode", "sensor_delay"}
    assert {effect.name for effect in LIBRARY} == here


def test_a_value_that_no_axis_has_is_named() -> None:
    assert impossible_values(ELASTIC, VALUES) == ()
    sentences = impossible_values(ELASTIC, VALUES | {"K": -6e5, "Ml": -1.0, "Fv": -3.0})
    assert [sentence.split(" is impossible")[0] for sentence in sentences] == ["Ml = -1", "K = -6e+05"]
