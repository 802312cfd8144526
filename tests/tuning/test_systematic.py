"""Tuning by bounds, against what a sine makes of filter and differences in closed form."""

import math

import numpy as np
import pytest

from symid import load_axis, tune
from symid.errors import SettingError
from symid.simulation import OpenLoop, Trajectory, chirp, plant_of
from symid.tuning import exact_run, excited_band, without_jumps
from symid.tuning.bound import lowest_within
from symid.tuning.low_pass import LowPassErrors, standard_model
from symid.tuning.tune import first_sampling_frequency, noise_free_run

RIGID = {"M": 5.0, "Fv": 300.0, "Fs": 4.0}
PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
SINE_HZ = 8.0


def sine(rate: float = 10_000.0) -> Trajectory:
    return chirp(SINE_HZ, SINE_HZ, 3.0, 0.01, sampling_period=1 / rate, fade=0.5)


@pytest.fixture(scope="module")
def tuned():
    return tune(
        load_axis("rigid_1m"), RIGID, trajectory=sine(), max_lowpass_error=0.1, max_sampling_error=0.5
    )


def test_tuned_sampling_frequency_is_where_two_differences_of_a_sine_lose_the_bound(tuned):
    # M is found too large by 1 / (sin(wT) / wT)^2, about 1 + (w T)^2 / 3
    expected = 2 * math.pi * SINE_HZ / math.sqrt(3 * 0.5e-2)
    assert tuned.sampling.frequency_hz == pytest.approx(expected, rel=0.02)
    assert tuned.sampling.errors["M"] == pytest.approx(0.5, rel=0.02)
    assert tuned.sampling.errors["Fv"] == pytest.approx(0.25, rel=0.05)
    assert tuned.sampling_period == 1 / tuned.sampling.frequency_hz


def test_tuned_cutoff_is_where_the_filtered_sine_loses_the_bound(tuned):
    # the gain is 1 / (1 + (f / fc)^8), and the force is not filtered
    assert tuned.cutoff.frequency_hz == pytest.approx(SINE_HZ * (0.1e-2) ** (-1 / 8), rel=0.02)
    assert tuned.cutoff.errors["M"] == pytest.approx(0.1, rel=0.02)
    assert tuned.preparation.cutoff_hz == tuned.cutoff.frequency_hz


def test_a_filtered_force_leaves_a_linear_axis_without_error_at_any_cutoff():
    axis = without_jumps(load_axis("rigid_1m"))
    errors = LowPassErrors(
        standard_model(axis), noise_free_run(axis, RIGID, sine()), RIGID, 10_000.0, 4, True
    )
    assert max(map(abs, errors.errors(2 * SINE_HZ).values())) < 1e-8


def test_laws_that_jump_are_left_out_unless_kept(tuned):
    assert tuned.left_out == ("Fs",)
    kept = tune(load_axis("rigid_1m"), RIGID, trajectory=sine(), max_lowpass_error=5.0, keep_jumps=True)
    assert kept.left_out == ()
    assert kept.sampling.errors.keys() == RIGID.keys()


def test_bounds_that_cannot_be_met_or_are_met_by_all_are_a_status():
    axis, short = load_axis("rigid_1m"), sine(4000.0)
    impossible = tune(axis, RIGID, trajectory=short, max_sampling_error=1e-12)
    assert impossible.status == "bound_not_reached"
    assert "no sampling frequency" in impossible.message
    loose = tune(axis, RIGID, trajectory=short, max_lowpass_error=1e3, max_sampling_error=1e3)
    assert loose.status == "bound_met_everywhere"
    assert loose.cutoff.frequency_hz == loose.cutoff.scanned_hz[0]


def test_a_parameter_without_relative_error_is_reported():
    found = tune(load_axis("emps"), {"M": 95.0, "Fv": 203.0, "Fc": 20.0, "OF": 0.0}, trajectory=sine(4000.0))
    assert found.status == "not_determined"
    assert "OF" in found.message


def test_an_impossible_bound_is_a_mistake():
    with pytest.raises(SettingError, match="positive"):
        tune(load_axis("rigid_1m"), RIGID, max_sampling_error=0.0)


def test_first_sampling_frequency_is_that_of_the_paper():
    assert first_sampling_frequency(164.42, 4) == pytest.approx(8791.62, abs=0.6)
    assert first_sampling_frequency(164.42, 2) == pytest.approx(8289.06, abs=0.6)
    guesses = [first_sampling_frequency(100.0, m) for m in range(1, 8)]
    assert guesses == sorted(guesses)


def test_standard_model_is_that_of_the_paper():
    random = np.random.default_rng(0)
    motion = {
        f"q_{body}{order}": random.normal(size=50)
        for body in ("structure", "motor")
        for order in ("", "_d1", "_d2")
    }
    force = random.normal(size=50)
    model = standard_model(load_axis("direct_2m1s"))
    W, y = model.sample(motion | {"Fm": force})
    a1, v1, p1 = (motion[f"q_structure{order}"] for order in ("_d2", "_d1", ""))
    a2, v2 = motion["q_motor_d2"], motion["q_motor_d1"]
    zero = np.zeros(50)
    columns = {  # equations [4] and [3], written by hand
        "Ms": (a1, zero), "Fvs": (v1, zero), "Ks": (p1, zero),
        "Mm": (a1 + a2, a1 + a2), "Fvm": (zero, v2), "Fsm": (zero, np.sign(v2)),
    }  # fmt: skip
    assert np.allclose(W, np.stack([np.stack(columns[name]) for name in model.parameters], axis=-1))
    assert np.allclose(y, [zero, force])


@pytest.mark.parametrize("rate", [333.3, 1000.0, 1234.5])
def test_a_run_is_sampled_exactly_at_any_rate(rate):
    axis, still = without_jumps(load_axis("rigid_1m")), np.zeros(2001)
    reference = Trajectory(still, still, still, 1e-3, "nothing")
    run = exact_run(axis, RIGID, reference, OpenLoop(np.full(2001, 7.0)))
    log = run.log(rate)
    # M x'' + Fv x' = 7 from rest
    decay = RIGID["Fv"] / RIGID["M"]
    t = np.arange(log.n_samples) / rate
    expected = 7.0 / RIGID["Fv"] * (t - (1 - np.exp(-decay * t)) / decay)
    assert log["q"] == pytest.approx(expected, abs=2e-8)
    assert log["F"] == pytest.approx(np.full(t.size, 7.0))
    assert t[-1] <= 2.0 < t[-1] + 1 / rate + 1e-9


def test_modes_are_those_of_the_free_axis():
    # motor against structure without drive: the structure alone on its spring
    assert plant_of(load_axis("direct_2m1s"), PAPER).natural_frequencies == pytest.approx(
        [math.sqrt(1e9 / 3899) / (2 * math.pi)]
    )
    assert excited_band(plant_of(load_axis("rigid_1m"), RIGID)) == (0.1, 20.0)


def test_search_passes_over_a_dip_where_errors_cancel():
    def errors(f: float) -> dict[str, float]:
        return {"M": 0.001 if 9 < f < 11 else 1000 / f}

    found = lowest_within(errors, [1.0, 10.0, 100.0, 1000.0, 10_000.0], 2.0)
    assert found.frequency_hz == pytest.approx(500.0, rel=0.01)
    assert found.status == "ok"


def test_search_reports_the_best_where_nothing_meets_the_bound():
    found = lowest_within(lambda f: {"M": (f - 100.0) ** 2 + 5.0}, [10.0, 90.0, 1000.0], 1.0)
    assert (found.status, found.frequency_hz, found.largest_error) == ("bound_not_reached", 90.0, 105.0)
