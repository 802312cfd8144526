"""What a log says between its samples, and its stretches, against signals known at all times."""

import numpy as np
import pytest

from symid import CoulombFriction, Log, load_axis
from symid.output_error.run import LogRun, run_of
from symid.simulation import forward_dynamics

PERIOD, N = 1e-3, 2000
TIME = PERIOD * np.arange(N)
TONES = [(3.0, 17.0, 0.3), (2.0, 91.0, 1.1), (1.0, 150.0, 2.0)]
"""Amplitude, Hz and phase of a force whose band ends well below the Nyquist frequency."""
INNER = slice(100, -100)


def force_at(t):
    return sum(a * np.sin(2 * np.pi * f * t + phase) for a, f, phase in TONES)


def rigid_run(q, force=None, course="smooth", period=PERIOD, **settings) -> LogRun:
    log = Log.from_arrays({"q": q, "F": force_at(TIME) if force is None else force}, sampling_period=period)
    return run_of(forward_dynamics(load_axis("rigid_1m")), log, ["q"], course, cutoff_hz=100.0, **settings)


def middles(parts: int) -> np.ndarray:
    return TIME[:, None] + PERIOD * (np.arange(parts) + 0.5) / parts


@pytest.mark.parametrize("late", [0.0, 0.3e-3, -0.4e-3, 1.7e-3])
def test_a_smooth_force_is_known_at_all_times(late: float) -> None:
    """What is recorded late by `late` at a time acted before: the true force is the recorded one later on."""
    run = rigid_run(TIME, late=late, standstill=0.0)
    assert run.parts == 8
    np.testing.assert_allclose(run.drive[INNER, :, 0], force_at(middles(8) + late)[INNER], atol=2e-3)
    np.testing.assert_allclose(run.drive_at[INNER, 0], force_at(TIME + late)[INNER], atol=2e-3)


def test_the_interpolation_reaches_far_up_in_the_band() -> None:
    def tone(t):
        return np.sin(2 * np.pi * 400.0 * t)

    run = rigid_run(TIME, tone(TIME), standstill=0.0)
    np.testing.assert_allclose(run.drive[INNER, :, 0], tone(middles(8))[INNER], atol=2e-3)


def test_the_rate_is_the_change_with_lateness() -> None:
    run, step = rigid_run(TIME, standstill=0.0), 1e-3
    later, earlier = (run.recorded_later(side) for side in (step, -step))
    for name in ("drive", "drive_at"):
        change = (getattr(later, name) - getattr(earlier, name)) / (2 * step)
        rate = getattr(run, f"{name}_rate" if name == "drive" else "drive_rate_at")
        np.testing.assert_allclose(rate[INNER], change[INNER], atol=0.05 * change.std())


def test_lateness_adds_up() -> None:
    whole = rigid_run(TIME, late=0.5e-3, standstill=0.0)
    twice = rigid_run(TIME, late=0.2e-3, standstill=0.0).recorded_later(0.3)
    np.testing.assert_allclose(whole.drive, twice.drive, atol=1e-12)
    assert whole.late == pytest.approx(twice.late)


@pytest.mark.parametrize(("late", "shift"), [(0.0, 0), (1e-3, 1), (-2e-3, -2)])
def test_a_held_force_is_that_of_its_sample(late: float, shift: int) -> None:
    force = force_at(TIME)
    run = rigid_run(TIME, course="held", late=late, standstill=0.0)
    expected = np.roll(force, -shift)
    np.testing.assert_array_equal(run.drive[INNER, :, 0], np.repeat(expected[:, None], 8, axis=1)[INNER])
    np.testing.assert_array_equal(run.drive_at[INNER, 0], np.roll(expected, 1)[INNER])
    assert not run.drive_rate.any()


def test_a_held_force_that_is_half_a_sample_late_changes_within_the_interval() -> None:
    force = force_at(TIME)
    run = rigid_run(TIME, course="held", late=-0.5e-3, standstill=0.0)
    np.testing.assert_array_equal(
        run.drive[INNER, :4, 0], np.repeat(np.roll(force, 1)[:, None], 4, axis=1)[INNER]
    )
    np.testing.assert_array_equal(run.drive[INNER, 4:, 0], np.repeat(force[:, None], 4, axis=1)[INNER])
    np.testing.assert_array_equal(run.drive_at[INNER, 0], np.roll(force, 1)[INNER])


@pytest.mark.parametrize(("period", "parts"), [(1e-3, 8), (2.5e-4, 2), (1e-4, 1)])
def test_intervals_are_cut_no_finer_than_a_force_needs(period: float, parts: int) -> None:
    assert rigid_run(np.arange(N) * period, period=period).parts == parts


def moves_and_rests() -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Positions of an axis that rests from 500 to 800 and from 1400 to 1500, and reverses quickly at 1000."""
    v = np.ones(N)
    v[500:800] = v[1400:1500] = 0.0
    v[1000:1400] = -1.0
    return np.cumsum(v) * PERIOD, [(500, 800), (1400, 1500)]


def test_standstills_are_cut_and_a_reversal_costs_a_few_samples() -> None:
    q, rests = moves_and_rests()
    run = rigid_run(q)
    for begin, end in rests:  # the filter smears their edges
        assert not run.kept[begin + 10 : end - 10].any()
    assert 0.7 * N < run.kept.sum() < N - 360
    lost = 900 + np.flatnonzero(~run.kept[900:1100])
    assert 2 <= lost.size <= 12
    assert abs(lost.mean() - 1000) <= 1.5
    assert len(run.starts) == 4
    edges = np.flatnonzero(np.diff(run.kept.astype(int), prepend=0) == 1)
    np.testing.assert_array_equal(np.flatnonzero(run.kept)[list(run.starts)], edges)
    np.testing.assert_array_equal(run.readings[:, 0], q[run.kept])
    assert run.motions[0] is not None
    assert np.abs(run.motions[0].v_at).min() < 0.5 < np.median(np.abs(run.motions[0].v_at))


def test_reversals_that_follow_each_other_quickly_cut_nothing() -> None:
    assert rigid_run(np.sin(2 * np.pi * 20 * TIME)).kept.all()
    seldom = rigid_run(np.sin(2 * np.pi * 4 * TIME))
    assert len(seldom.starts) > 10


def test_nothing_is_cut_where_asked_or_where_nothing_can_hold() -> None:
    q, _ = moves_and_rests()
    assert rigid_run(q, standstill=0.0).kept.all()
    dynamics = forward_dynamics(load_axis("motor_bench"))
    log = Log.from_arrays({"qm": q, "iq": force_at(TIME)}, sampling_period=PERIOD)
    assert run_of(dynamics, log, ["qm"], "smooth", cutoff_hz=100.0).kept.all()


def test_an_excerpt_covers_beginning_and_end_and_keeps_its_stretches_apart() -> None:
    q, _ = moves_and_rests()
    run = rigid_run(q)
    part = run.excerpt(1200)
    assert len(part.readings) == part.drive.shape[0] == part.kept.sum() == 1200
    assert part.readings[0] == run.readings[0]
    assert part.readings[-1] == run.readings[-1]
    np.testing.assert_array_equal(part.readings[:, 0], q[part.kept])
    samples = np.flatnonzero(part.kept)
    jumps = set(np.flatnonzero(np.diff(samples) > 1) + 1)
    assert jumps <= set(part.starts)
    assert part.starts[0] == 0
    assert run.excerpt(N) is run
    later = part.recorded_later(0.5)
    assert later.drive.shape == part.drive.shape


def test_the_motion_of_a_joint_is_measured_only_if_sensors_tell_it() -> None:
    axis = load_axis("direct_2m1s")
    rough = axis.with_effect(CoulombFriction(axis.elements[0], "Fss"))
    log = Log.from_arrays({"q2": np.sin(TIME), "Fm": force_at(TIME)}, sampling_period=PERIOD)
    dynamics = forward_dynamics(rough)
    run = run_of(dynamics, log, ["q2"], "smooth", cutoff_hz=100.0, standstill=0.0)
    known = {
        tuple(direction): motion is not None
        for (direction, _), motion in zip(dynamics.laws, run.motions, strict=True)
    }
    assert known == {(-1.0, 1.0): True, (1.0, 0.0): False}
    motion = next(m for m in run.motions if m is not None)
    inner = slice(200, -200)
    np.testing.assert_allclose(motion.q_at[inner], np.sin(TIME)[inner], atol=1e-6)
    np.testing.assert_allclose(motion.v[inner], np.cos(middles(8))[inner], atol=1e-4)
