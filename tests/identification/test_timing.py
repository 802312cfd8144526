"""Delays of the force: known ones are found and taken out, clean logs raise nothing, real logs show what is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symid import (
    ActuatorDelay,
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Log,
    Position,
    Preparation,
    ViscousFriction,
    identify,
    load_axis,
    load_generated,
    read_axis_log,
)
from symid.identification import Identification, observe
from symid.identification.delays.timing import Timing
from symid.identification.rows.signal_rows import SignalRows
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

RATE = 1000.0
TRUTH = {"M": 95.0, "Fv": 200.0, "Fs": 20.0}
DATA = Path(__file__).parents[2] / "data"


def rigid_log(
    *,
    late: float = 0.0,
    force: float = 2.0,
    encoder: float = 0.0,
    seed: int = 0,
    seconds: int = 8,
    ripple: float = 0.001,
) -> Log:
    """Exact motion; its force is that of `late` samples before, so that it is recorded so much too late."""
    t = np.arange(int(seconds * RATE)) / RATE

    def motion(time: np.ndarray) -> np.ndarray:
        rows = np.zeros((3, time.size))
        for amplitude, frequency in ((0.05, 0.6), (0.01, 1.9), (ripple, 7.0)):
            w = 2 * np.pi * frequency
            rows += amplitude * np.array([np.sin(w * time), w * np.cos(w * time), -(w**2) * np.sin(w * time)])
        return rows

    random = np.random.default_rng(seed)
    _, v, a = motion(t - late / RATE)
    F = TRUTH["M"] * a + TRUTH["Fv"] * v + TRUTH["Fs"] * np.sign(v) + force * random.standard_normal(t.size)
    q = motion(t)[0]
    if encoder:
        q = encoder * np.round(q / encoder + random.uniform(-0.5, 0.5))
    return Log.from_arrays({"q": q, "F": F}, sampling_period=1 / RATE)


def identified(log: Log, **settings: object) -> Identification:
    return identify(load_generated("rigid_1m"), log, preparation=Preparation(**settings))


def test_friction_that_builds_up_is_not_called_a_late_clock() -> None:
    log, slid, seen = rigid_log(ripple=0.0), 0.005, 0.0  # m
    course = np.gradient(log["q"])
    built = np.zeros(course.size)
    for k, step in enumerate(course):  # P. Dahl's law
        seen += step / slid * (1.0 - np.sign(step) * seen)
        built[k] = seen
    force = log["F"] - 20.0 * np.sign(course) + 60.0 * built
    pre = identify(load_generated("rigid_1m"), replace(log, signals={**log.signals, "F": force}))
    late = identify(load_generated("rigid_1m"), rigid_log(late=6.0))
    for found, is_clock in ((pre, False), (late, True)):
        assert found.timing is not None
        assert abs(found.timing.samples) > 2.0
        assert found.timing.may_be_clock == is_clock == ("give `late` F" in found.timing.statement)


@pytest.mark.parametrize(
    ("late", "remaining", "is_clock"), [(-0.078, 0.48, False), (-0.078, 0.2, True), (-0.02, 0.48, True)]
)
def test_a_clock_that_is_far_off_leaves_noise_alone(late: float, remaining: float, is_clock: bool) -> None:
    timing = Timing("i", late, 1e-3, 2e-3, 0.0, remaining, np.zeros(1), ("i",))
    assert timing.may_be_clock is is_clock


@pytest.mark.parametrize("late", [1.0, -1.0, 0.4, -1.7, 3.0])
@pytest.mark.parametrize("cutoff", [None, 40.0])
def test_a_delay_is_named_and_measured(late: float, cutoff: float | None) -> None:
    found = identified(rigid_log(late=late), cutoff_hz=cutoff)
    assert found.status == "timing"
    assert found.timing is not None
    assert found.timing.samples == pytest.approx(late, abs=0.1)
    assert abs(found.timing.samples - late) < 4 * found.timing.deviation * RATE
    assert f"F acts as if {abs(found.timing.samples):.2f} samples" in found.message
    assert ("before" if late > 0 else "after") in found.message


@pytest.mark.parametrize("late", [1.0, -2.5])
def test_the_remedy_in_the_message_takes_whole_and_half_samples_out(late: float) -> None:
    found = identified(rigid_log(late=late), cutoff_hz=40.0)
    assert f"`late` F={1000 * late:.0f}us" in found.message
    again = identified(rigid_log(late=late), cutoff_hz=40.0, late={"F": late / RATE})
    assert again.status == "ok"
    wrong, right = (
        abs(result.physical_parameters["Fv"] - TRUTH["Fv"]) / result.standard_deviations[1]
        for result in (found, again)
    )
    assert wrong > 2.5 > right


def test_a_held_force_is_a_note_with_its_option() -> None:
    found = identified(rigid_log(late=-0.5, force=0.5, ripple=0.0), cutoff_hz=40.0)
    assert found.status == "ok"
    assert any("`held` F" in note for note in found.notes)


@pytest.mark.parametrize(("ripple", "status"), [(0.0, "ok"), (0.003, "timing")])
def test_a_lag_of_a_drive_is_a_note_unless_it_moves_a_parameter_out_of_its_interval(
    ripple: float, status: str
) -> None:
    """Fast motion makes friction of a mass that acts late: Fv is 4 or 32 % too small."""
    found = identified(rigid_log(late=-0.8, force=0.5, ripple=ripple), cutoff_hz=40.0)
    assert found.status == status
    assert any("F acts as if 0." in statement for statement in (found.message, *found.notes))


@pytest.mark.parametrize(("ripple", "status"), [(0.0, "ok"), (0.01, "timing")])
def test_a_tenth_of_a_sample_is_a_fault_where_it_moves_a_parameter_out_of_its_interval(
    ripple: float, status: str
) -> None:
    """Fast motion makes friction of a mass: Fv is off by 1 or 50 %."""
    found = identified(rigid_log(late=0.1, force=0.2, ripple=ripple), cutoff_hz=40.0)
    assert found.status == status
    assert ("F acts as if 0.10 samples" in found.message) == (status == "timing")


@pytest.mark.parametrize("force", [0.0, 0.5, 10.0])
@pytest.mark.parametrize("encoder", [0.0, 1e-6, 2e-5])
@pytest.mark.parametrize("cutoff", [None, 10.0, 60.0])
def test_clean_logs_raise_nothing(force: float, encoder: float, cutoff: float | None) -> None:
    for seed in range(3):
        found = identified(rigid_log(force=force, encoder=encoder, seed=seed), cutoff_hz=cutoff)
        assert found.timing is None or not found.timing.is_significant
        assert found.status != "timing"


def test_the_delay_of_long_logs_is_found_on_excerpts() -> None:
    log = rigid_log(late=1.0, seconds=200)
    found = identified(log, cutoff_hz=40.0)
    assert found.timing is not None
    assert found.timing.samples == pytest.approx(1.0, abs=0.1)


def test_the_bench_and_emps_show_their_known_lags() -> None:
    """The current of the bench acts 0.11 ms after it is recorded; the lag of EMPS is less than a sample, a note."""
    bench = read_axis_log(
        load_axis("motor_bench"),
        DATA / "flex_motor_bench" / "MultisineTypeA.mat",
        columns={"iq": "iq_adx", "qm": "theta_mx", "ql": "theta_my", "t": "time"},
        units={"t": "us"},
        gains={"ql": -1.0},
    )
    found = identify(load_generated("motor_bench", ("qm", "ql")), bench)
    assert found.timing is not None
    assert found.timing.late == pytest.approx(-1.1e-4, abs=1.5e-5)
    assert any("iq acts as if 0." in note for note in (found.message, *found.notes))
    emps = read_axis_log(load_axis("emps"), DATA / "emps" / "DATA_EMPS.mat", columns={"q": "qm"})
    lagging = identify(load_generated("emps"), emps)
    assert lagging.status == "ok"
    assert any("F acts as if 0." in note for note in lagging.notes)
    moved = Log.from_arrays({"q": emps["q"][2:], "F": emps["F"][:-2]}, sampling_period=1e-3)
    assert identify(load_generated("emps"), moved).status == "timing"


@pytest.mark.parametrize(
    ("axis", "signals"), [("emps", ("q", "F")), ("direct_2m1s", ("q2", "Fm")), ("rigid_1m", ("q", "F"))]
)
@pytest.mark.parametrize("settings", [{}, {"decimation": 5}, {"filter_force": False}])
def test_rows_change_as_those_of_a_moved_force(
    axis: str, signals: tuple[str, str], settings: dict[str, int]
) -> None:
    """The change of rows is that between two whole observations; its slope is that of the change."""
    made, model = rigid_log(), load_generated(axis)
    columns = dict(zip(signals, (made["q"], made["F"]), strict=True))
    log = Log.from_arrays(columns, sampling_period=1 / RATE)
    still = observe(model, log, Preparation(cutoff_hz=30.0, **settings))
    late = 0.4 / RATE
    moved = observe(model, log, replace(still.preparation, late={signals[1]: late}))
    rows = SignalRows.of(model, log, still.preparation, signals[1])
    above = rows.change(late)
    assert above[1] == pytest.approx(moved.y - still.y, abs=1e-9 * np.abs(still.y).max())
    assert above[0] == pytest.approx(moved.W - still.W, abs=1e-9 * np.abs(still.W).max())
    step = 0.25 / RATE
    by_second = (rows.change(step)[1] - rows.change(-step)[1]) / (2 * step)
    assert rows.slope[1] == pytest.approx(by_second, abs=1e-9 * np.abs(by_second).max())


@pytest.mark.parametrize("late", [0.0, 7e-4])
def test_noise_that_a_controller_makes_force_of_is_no_delay(late: float) -> None:
    table, values = Body("table", mass="M"), {"M": 95.0, "Fv": 200.0, "Fc": 20.0}
    elements = (table, ViscousFriction(table, "Fv"), CoulombFriction(table, "Fc"))
    axis = Axis("fed", elements, Drive("F", table, held=True), (Position("q", table, noise=1e-6),))
    moves = trapezoids(0.2, [0.5, 0.25, 0.1], acceleration=5.0, jerk=500.0, dwell=0.2, sampling_period=2.5e-4)
    machine = axis.with_effect(ActuatorDelay(late)) if late else axis
    log = simulate(machine, values, moves, tuned_cascade(plant_of(axis, values), "q"), seed=1).log
    found = identify(axis, log)
    assert found.status == ("timing" if late else "ok"), found.message
    assert found.timing is not None
    assert found.timing.late == pytest.approx(-late, abs=1e-5)
