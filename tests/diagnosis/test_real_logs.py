"""The real logs of benchmarks/diagnosis/real: readers beside symid's, plain scripts beside what SOURCE.md files say."""

from itertools import pairwise, permutations, product
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.diagnosis.real import recordings
from benchmarks.diagnosis.real.case import log_of
from benchmarks.diagnosis.real.judge import absurdities, rightness
from benchmarks.diagnosis.real.machines import MACHINES, cases
from benchmarks.diagnosis.real.plain import LOAD, Motion, Plain, Script, fitted, matrix, plain
from benchmarks.diagnosis.real.recordings import Recording
from benchmarks.diagnosis.real.repeated import repeated
from benchmarks.emps import read as read_emps
from benchmarks.motor_bench import read as read_bench

RECORDINGS = {
    "emps": (recordings.emps(), 24841, 1e-3),
    "bench": (recordings.bench("B"), 50000, 4e-4),
    "pendulum": (recordings.pendulum("ddp"), 3000, 2e-3),
    "robot": (recordings.robot("A"), 2501, 4e-3),
    "servo": (recordings.servo("10h28m32"), 1126, 5.314e-3),
    "motor": (recordings.motor("nocomp_0"), 4432, 2.256e-3),
    "shoulder": (recordings.double_pendulum("143906"), 5000, 2e-3),
    "lift": (recordings.tiago("torso_lift_joint"), 8028, 9.997e-3),
}


@pytest.mark.parametrize("name", RECORDINGS)
def test_a_reader_gives_finite_signals_on_the_clock_that_is_published(name):
    recording, samples, period = RECORDINGS[name]
    assert {values.size for values in recording.signals.values()} == {
        next(iter(recording.signals.values())).size
    }
    assert recording[next(iter(recording.signals))].size == pytest.approx(samples, abs=8)
    assert recording.period == pytest.approx(period, rel=1e-3)
    assert all(np.all(np.isfinite(values)) for values in recording.signals.values())
    assert all(np.ptp(values) > 0 for values in recording.signals.values())


def test_logs_are_those_that_symid_reads():
    for recording, log in (
        (recordings.emps(), read_emps("emps", "DATA_EMPS.mat")),
        (recordings.bench("A"), read_bench("A")),
    ):
        assert log.sampling_period == pytest.approx(recording.period, rel=1e-9)
        for name, values in recording.signals.items():
            assert np.allclose(log[name], values, rtol=1e-12, atol=0.0)


def test_forces_are_in_the_units_of_the_source():
    robot, servo = recordings.robot("A"), recordings.servo("10h29m04")
    assert 800 < np.std(robot["tau"]) < 1000  # N m behind the gear
    assert 4.0 < np.max(np.abs(servo["u"])) < 7.4 * 1.15  # V, never above the supply
    assert np.max(np.abs(recordings.double_pendulum("143906")["elbow"])) < 0.003  # it stands still


def test_jitter_is_interpolated_and_nothing_else():
    time = np.array([0.0, 0.9, 2.0, 3.1, 4.0])
    recording = recordings.on_grid("jitter", time, x=3.0 * time)
    assert recording.period == pytest.approx(1.0, abs=0.11)
    assert np.allclose(recording["x"], 3.0 * recording.period * np.arange(recording["x"].size))


def test_parts_of_a_run_follow_each_other():
    run = recordings.motor("nocomp_1")
    parts = [run.between(a, b) for a, b in pairwise((0.0, 1.0, 4.0, 99.0))]
    assert np.array_equal(np.concatenate([part["q"] for part in parts]), run["q"])
    assert parts[1].start == pytest.approx(run.start + 1.0, abs=run.period)


def relative(script: Script, runs: list[Recording], names: tuple[str, ...], band: float) -> float:
    """Error of a fit on the runs that it was fitted to, jointly."""
    motions = [Motion(run, script, band) for run in runs]
    model = fitted(motions, names)
    left = sum(float(np.sum(model.error(m)[m.rows] ** 2)) for m in motions)
    return float(np.sqrt(left / sum(float(np.sum(m.force[m.rows] ** 2)) for m in motions)))


def test_servo_leaves_the_published_shares_of_the_voltage():
    runs = [recordings.servo(run) for run in ("10h28m32", "10h28m10", "10h28m24")]  # kp 100
    script = Script("u", "q", ("inertia", "weight", "viscous"), ("coulomb",))
    assert relative(script, runs, script.base, 15.0) == pytest.approx(0.287, abs=0.01)
    assert relative(script, runs, (*script.base, *script.added), 15.0) == pytest.approx(0.222, abs=0.01)


def test_robot_leaves_the_published_shares_of_the_torque():
    script = Script("tau", "qm", ("inertia", "viscous"), ("coulomb",))
    run, other = (Motion(recordings.robot(which), script, 40.0) for which in "AB")
    shares = []
    for names in (script.base, (*script.base, *script.added)):
        columns, unseen = matrix(run, names, None)[1][10:-10], matrix(other, names, None)[1][10:-10]
        values = np.linalg.lstsq(columns, run.force[10:-10])[0]  # standstills too, as the source has it
        left = other.force[10:-10] - unseen @ values
        shares.append(np.sqrt(np.mean(left**2) / np.mean(other.force[10:-10] ** 2)))
    assert shares == pytest.approx([0.51, 0.36], abs=0.03)


def test_second_encoder_of_the_robot_is_late():
    run = Motion(recordings.robot("B"), Script("tau", "qm", ()), 20.0)
    apart = run.low_passed(run.recording["qm"] - run.recording["ql"])
    v = run.derivatives[1]
    delay, _ = np.linalg.lstsq(np.stack([v, np.ones_like(v)], axis=1), apart)[0]
    assert delay == pytest.approx(2.8e-3, abs=0.4e-3)  # with what the joint yields to friction
    assert 1.0 - np.std(apart - 2.8e-3 * v) / np.std(apart) == pytest.approx(0.91, abs=0.06)


def test_slow_motor_leaves_the_published_shares_of_the_current():
    script = Script("i", "q", ())
    run, orders = [recordings.motor("nocomp_0")], [f"cogging {n}" for n in (7, 14, 28, 36, 12)]
    rigid = ("inertia", "viscous")
    assert relative(script, run, rigid, 30.0) == pytest.approx(0.85, abs=0.02)
    assert relative(script, run, (*rigid, "coulomb", orders[0]), 30.0) == pytest.approx(0.35, abs=0.02)
    assert relative(script, run, (*rigid, "coulomb", *orders), 30.0) == pytest.approx(0.15, abs=0.04)


def script_of(name: str) -> Plain:
    """What the plain script of a case finds."""
    return next(case for case in cases([name]) if case.name == name).plain()


def test_scripts_find_the_published_values():
    emps, pendulum = script_of("emps-symmetric"), script_of("pendulum-frictionless")
    assert emps.base.values["inertia"] == pytest.approx(95.11, rel=0.01)
    assert emps.base.values["viscous"] == pytest.approx(203.5, rel=0.03)
    assert emps.base.values["coulomb"] == pytest.approx(20.39, rel=0.03)
    assert emps.best.values["asymmetry"] == pytest.approx(-36.9, rel=0.03)
    assert pendulum.best.values["coulomb"] == pytest.approx(0.184, abs=0.02)
    assert min(emps.removed, pendulum.removed) > 0.3
    shoulder, robot = script_of("shoulder-viscous"), script_of("robot-viscous")
    assert shoulder.best.values["coulomb"] == pytest.approx(0.18, abs=0.03)
    assert robot.best.values["coulomb"] == pytest.approx(355.0, rel=0.1)
    assert min(shoulder.removed, robot.removed) > 0.3


def test_script_finds_the_mode_of_the_bench():
    runs = [recordings.bench(which) for which in "AB"]
    base = Script("iq", "qm", ("inertia", "viscous", "coulomb"), ("mode",))
    found = plain(base, [runs[0].between(0.0, 5.0)], runs[1].between(0.0, 5.0), 250.0)
    assert found.best.shape is not None
    assert found.best.shape[0] == pytest.approx(53.7, abs=0.5)
    assert found.before.relative == pytest.approx(0.92, abs=0.04)
    assert found.after.relative < 0.2


def test_load_dependent_friction_is_solved_for():
    time = 1e-3 * np.arange(6000)
    q = np.sin(3.0 * time) + 0.3 * np.sin(11.0 * time)
    v = 3.0 * np.cos(3.0 * time) + 3.3 * np.cos(11.0 * time)
    load = 0.2 * (-9.0 * np.sin(3.0 * time) - 36.3 * np.sin(11.0 * time)) + 0.5 * 9.80665 * np.sin(q)
    force = load + 0.1 * v + 0.15 * np.abs(load) * np.sign(v)
    run = Recording("made", 0.0, 1e-3, {"q": q, "u": force})
    script = Script("u", "q", ("inertia", "weight", "viscous"), (LOAD,))
    values = plain(script, [run], run, 400.0).best.values
    assert values == pytest.approx({"inertia": 0.2, "weight": 0.5, "viscous": 0.1, LOAD: 0.15}, rel=0.02)


def test_no_name_of_a_case_begins_another():
    names = [case.name for machine in ("emps", "pendulum", "robot", "motor") for case in MACHINES[machine]()]
    assert not [(a, b) for a, b in permutations(names, 2) if b.startswith(a)]


def test_each_case_has_logs_of_its_axis_and_values_for_it():
    for machine in ("robot", "servo", "shoulder"):
        for case in MACHINES[machine]():
            assert set(case.nominal) == set(case.axis.physical_parameters)
            assert {*case.validation.signals} == {*log_of(case.axis, case.training[0]).signals}
            assert {at for _, at in case.right} <= {
                part for b, s in product(case.axis.bodies, case.axis.sensors) for part in (b.name, s.signal)
            }


def answer(*effects: tuple[str, str]) -> SimpleNamespace:
    """An answer whose first effect is indistinguishable from the others."""
    if not effects:
        return SimpleNamespace(effects=())
    (name, place), *others = effects
    return SimpleNamespace(effects=(SimpleNamespace(effect=name, at=place, indistinguishable_from=others),))


def test_an_answer_is_right_if_published_tied_or_confirmed():
    case = next(iter(cases(["emps-symmetric"])))
    published, other = ("asymmetric_friction", "motor"), ("cogging", "motor")
    assert rightness(case, answer(published)) == "yes"
    assert rightness(case, answer(other, published)) == "tie"
    assert rightness(case, answer(("delay", "actuator"))) == "script"
    assert rightness(case, answer(other)) == "no"
    assert rightness(case, answer()) == "no"


def test_values_beyond_physics_are_absurd():
    def effect(name: str, **values: tuple[float, float]) -> SimpleNamespace:
        parameters = {key: SimpleNamespace(value=v, std=std) for key, (v, std) in values.items()}
        return SimpleNamespace(effect=name, parameters=parameters)

    def found(M: float, *effects: SimpleNamespace) -> SimpleNamespace:
        change = SimpleNamespace(name="M", reidentified=95.0, explained=M)
        return SimpleNamespace(axis=case.axis, parameters=(change,), effects=effects)

    case = next(iter(cases(["emps-viscous"])))
    script, nan = case.plain(), float("nan")
    offset = effect("offset_force", F0=(20.0, 1.0))
    assert absurdities(case, found(96.0, offset), script) == ()
    assert absurdities(case, found(40.0, offset), script) == ("M 95 -> 40",)
    assert absurdities(case, found(40.0, effect("payload_change", dm=(4.0, 1.0))), script) == ()
    assert absurdities(case, found(-1.0), script) == ("M 95 -> -1",)
    loaded = effect("load_dependent_friction", mu=(0.97, 0.01))
    assert absurdities(case, found(96.0, loaded), script) == ("load_dependent_friction mu 0.97",)
    unknown = effect("stribeck_friction", dF=(1.0, 3.0), vs=(0.1, 0.2))
    assert absurdities(case, found(96.0, unknown), script) == ("stribeck_friction less than its deviation",)
    late = effect("delay", share=(1.0, nan), T=(7e-4, 1e-5))
    assert absurdities(case, found(96.0, late), script) == ()


def test_an_inertia_at_its_bound_is_no_estimate():
    """The motor turns so slowly that its inertia hardly shows."""
    (case,) = (case for case in cases(["motor"]) if case.name == "motor-viscous")
    found = case.found()
    J, Fv = found.parameters
    assert J.at_bound
    assert not Fv.at_bound
    assert J.explained == pytest.approx(J.reidentified / 2)
    assert f"J = {J.explained:.3g} A*s^2/rad is at its bound" in found.sentence


@pytest.mark.parametrize("way", ["first-half", "second-half"])
def test_half_a_log_of_a_robot_shows_coulomb_friction(way):
    """Its level varies along the half stroke, and a friction of another shape leaves less: both are for later steps."""
    (case,) = cases(["robot-viscous"])
    found = next(again for again in repeated(case) if again.name.endswith(way)).found()
    (first, *_) = found.effects
    assert (first.effect, first.at) == ("coulomb_friction", "body")
    assert first.probability > 0.7
    assert found.parameters[1].explained == pytest.approx(2050, rel=0.1)  # viscous, published
