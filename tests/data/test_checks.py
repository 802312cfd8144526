"""Constant, missing, stuck and clipped channels; no false notes on machines at rest."""

from pathlib import Path

import numpy as np
import pytest

from symid.data import read_log
from symid.data.quality.checks import inspect_values
from symid.data.quality.lost_samples import step_of
from symid.data.quality.stuck import inspect_spans
from symid.units import Unit

DATA = Path(__file__).parents[2] / "data"
M, RAD, N = Unit.of("m"), Unit.of("rad"), Unit.of("N")
TIME = 0.001 * np.arange(8000)


def machine(seed=0, encoder_step=1e-6):
    """Moves with dwells between, quantised position, noisy force."""
    rng = np.random.default_rng(seed)
    move = 0.5 - 0.5 * np.cos(np.pi * np.clip((TIME % 2.0) / 1.2, 0.0, 1.0))
    up = (TIME // 2.0) % 2 == 0
    reference = 0.2 * np.where(up, move, 1.0 - move)
    q = np.round(reference / encoder_step) * encoder_step
    F = 300.0 * np.gradient(np.gradient(reference, TIME), TIME) + 20.0 * np.tanh(
        1e3 * np.gradient(reference, TIME)
    )
    return {"reference": reference, "q": q, "F": F + rng.standard_normal(TIME.size)}


@pytest.mark.parametrize("encoder_step", [1e-7, 1e-5, 1e-3])
def test_dwells_raise_no_notes(encoder_step):
    signals = machine(encoder_step=encoder_step)
    assert inspect_spans(TIME, signals, ["q"]) == ()
    del signals["reference"]
    assert inspect_spans(TIME, signals, ["q"]) == ()


def test_a_stuck_position_is_noted_by_its_jump_or_by_the_reference():
    signals = machine()
    signals["q"][2300:2700] = signals["q"][2300]
    (note,) = inspect_spans(TIME, signals, ["q"])
    assert note.startswith("'q' keeps exactly one value")
    assert "from t = 2.3 s to 2.699 s, 400 samples" in note
    del signals["reference"]
    assert len(inspect_spans(TIME, signals, ["q"])) == 1


def test_a_position_that_dies_is_noted_by_the_reference():
    signals = machine()
    signals["q"][4500:] = signals["q"][4500]
    (note,) = inspect_spans(TIME, signals, ["q"])
    assert "from t = 4.5 s to 7.999 s" in note


def test_a_deflection_that_swings_while_the_motor_rests_is_no_stuck_motor():
    signals = machine()
    del signals["reference"]
    signals["d"] = 1e-3 * np.sin(40 * TIME)
    assert inspect_spans(TIME, signals, ["q", "d"]) == ()
    signals["q2"] = signals["q"] + signals["d"]  # an encoder of the load tells it
    signals["q"][2300:2700] = signals["q"][2300]
    assert inspect_spans(TIME, signals, ["q", "d", "q2"])[0].startswith("'q' keeps")


def test_a_stuck_force_is_noted_while_the_machine_moves():
    signals = machine()
    signals["F"][300:600] = signals["F"][300]
    (note,) = inspect_spans(TIME, signals, ["q"])
    assert "'F' keeps exactly one value while the machine moves from t = 0.3 s to 0.599 s" in note


def test_a_coarse_force_at_constant_speed_is_not_stuck():
    speed = np.interp(TIME, [0.0, 1.5, 2.5, 4.0, 8.0], [0.0, 0.5, 0.5, 1.0, -1.0])
    q, F = 1e-3 * np.cumsum(speed), np.round(40 * speed)
    assert inspect_spans(TIME, {"q": q, "F": F}, ["q"]) == ()
    F[1700:2200] = 12.0
    assert len(inspect_spans(TIME, {"q": q, "F": F}, ["q"])) == 1


def test_a_clipped_force_is_noted():
    signals = machine()
    signals["F"] = np.clip(signals["F"], -100.0, 100.0)
    (note,) = inspect_spans(TIME, signals, ["q"])
    assert "'F' is clipped at the end of its range" in note


def test_a_force_held_by_an_axis_at_rest_is_not_clipped():
    """A proportional controller gives one value as long as a coarse encoder reads one."""
    q = np.round(100 * np.exp(-np.arange(1000) / 250) * np.sin(np.arange(1000) / 90))
    assert inspect_spans(TIME[:1000], {"q": q, "F": -3.0 * q}, ["q"]) == ()


def test_a_clipped_position_is_noted():
    signals = machine(encoder_step=1e-7)
    signals["q"] = np.minimum(signals["q"], 0.12)
    (note,) = inspect_spans(TIME, signals, ["q"])
    assert "'q' is clipped" in note


def test_a_switching_force_is_no_fault_of_the_sensor():
    signals = machine()
    signals["F"] = np.where(TIME % 0.4 < 0.2, 5.0, -5.0)
    assert inspect_spans(TIME, signals, ["q"]) == ()


def test_missing_and_constant_values_are_faults():
    q = np.sin(TIME)
    q[[40, 41, 90]] = np.nan
    faults = inspect_values(TIME, {"q": q, "F": np.full(TIME.size, 2.5), "ddq1": np.cos(TIME)})
    assert len(faults) == 2
    assert "'q' has 3 values empty or not finite, the first at t = 0.04 s (row 41)" in faults[0]
    assert "'F' is constant (2.5)" in faults[1]


@pytest.mark.parametrize("name", ["DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"])
def test_emps_is_clean(name):
    log = read_log(
        DATA / "emps" / name,
        expected={"q": M, "F": N},
        alternatives={"F": ("vir", 35.15065188248547)},
        columns={"q": "qm", "reference": "qg"},
    )
    assert log.sampling_period == 0.001
    assert list(log.signals) == ["q", "F", "reference"]
    assert log.notes == ()


@pytest.mark.parametrize("name", ["MultisineTypeA.mat", "MultisineTypeB.mat"])
def test_the_flexible_bench_is_clean(name):
    log = read_log(
        DATA / "flex_motor_bench" / name,
        expected={"qm": RAD, "ql": RAD, "Fm": Unit.of("A")},
        columns={"qm": "theta_mx", "ql": "theta_my", "Fm": "iq_adx", "t": "time"},
        units={"t": "us"},
        gains={"ql": -1.0},
    )
    assert log.sampling_frequency == 2500.0
    assert log.notes == ()
    assert np.corrcoef(log["qm"], log["ql"])[0, 1] > 0.0


@pytest.mark.parametrize("method", ["ddp", "direct_collocation"])
def test_the_pendulum_has_a_jittering_clock_and_nothing_else(method):
    log = read_log(
        DATA / "dfki_simple_pendulum" / f"control_method_{method}__data_measured.csv",
        expected={"q": RAD, "T": Unit.of("N*m")},
        columns={"q": "position", "T": "torque", "t": "time"},
    )
    assert len(log.notes) == 1
    assert log.notes[0].startswith("t jitters by 0.0")


def test_steps_beside_the_least_numbers_are_no_counts() -> None:
    values = np.concatenate([[0.0, 5e-324], np.linspace(1.0, 2.0, 298)])
    assert step_of(values) == 0.0
