"""Signals that passed a filter of their own, and gains that differ in a part of a log."""

import numpy as np
import pytest
import scipy

from benchmarks.promise.faults import damaged
from benchmarks.promise.machines import Case, draw_case
from symid import Log, load_generated
from symid.identification import Identification, identify_by_least_squares
from symid.identification.faults import examined_faults
from symid.identification.faults.modes import mode_above

SEED = 80611


def identified(case: Case, **signals: np.ndarray) -> Identification:
    log = Log.from_arrays({**case.signals, **signals}, sampling_period=1 / case.rate)
    return identify_by_least_squares(load_generated(case.axis, case.measured), log)


def ac_coupled(x: np.ndarray, corner_hz: float, rate: float) -> np.ndarray:
    return scipy.signal.sosfilt(scipy.signal.butter(1, corner_hz, "highpass", fs=rate, output="sos"), x)


@pytest.mark.parametrize(("axis", "number", "name"), [("rigid_1m", 0, "F"), ("direct_2m1s", 12, "ddq2")])
def test_an_ac_coupled_sensor_is_named_with_its_corner(axis: str, number: int, name: str) -> None:
    case = draw_case(np.random.default_rng([SEED, number]), axis)
    assert identified(case).status == "ok"
    found = identified(case, **{name: ac_coupled(case.signals[name], 0.2, case.rate)})
    assert found.status == "recording"
    statement = found.message.split("with a corner of ")
    assert statement[0].startswith(name)
    assert float(statement[1].split()[0]) == pytest.approx(0.2, rel=0.1)


def test_a_gain_that_differs_in_a_small_part_of_a_long_log_is_seen() -> None:
    case = draw_case(np.random.default_rng([731010, 75, 1]))
    F = case.signals["F"].copy()
    assert F.size > 65_536  # excerpts leave out most of the part below
    part = slice(int(0.45 * F.size), int(0.65 * F.size))
    F[part] *= 0.5
    found = identified(case, F=F)
    assert found.status == "poor_fit"
    assert "parameters change within the logs" in found.message


@pytest.mark.parametrize(("gain", "status"), [(1.13, "poor_fit"), (1.0, "ok")])
def test_a_gain_that_changes_a_mass_by_more_than_a_tenth_is_a_fault(gain: float, status: str) -> None:
    t, random = np.arange(12000) / 1000, np.random.default_rng(1)
    w, size = np.array([[9.0], [13.0]]), np.array([[0.01], [0.004]])
    q, v = np.sum(size * np.sin(w * t), axis=0), np.sum(size * w * np.cos(w * t), axis=0)
    F = 5.0 * np.sum(-size * w**2 * np.sin(w * t), axis=0) + 4 * v + 0.5 * np.sign(v)
    F = np.where(np.abs(t - 7.0) < 3.0, gain, 1.0) * F + 0.01 * random.standard_normal(t.size)
    log = Log.from_arrays({"q": q + 1e-8 * random.standard_normal(t.size), "F": F}, sampling_period=1e-3)
    found = identify_by_least_squares(load_generated("rigid_1m"), log)
    assert found.status == status
    assert ("parameters change within the logs" in found.message) == (gain != 1.0)


def test_a_small_change_that_distorts_a_parameter_is_a_fault() -> None:
    case = draw_case(np.random.default_rng([612005, 21, 1]))
    Fm = case.signals["Fm"].copy()
    Fm[int(0.14 * Fm.size) : int(0.52 * Fm.size)] *= 0.5
    found = identified(case, Fm=Fm)
    assert found.status == "poor_fit"
    assert "parameters change within the logs" in found.message


def test_a_zero_phase_low_pass_of_one_signal_is_no_ok() -> None:
    case = draw_case(np.random.default_rng([731010, 37, 1]))
    sos = scipy.signal.butter(1, 25.0, "lowpass", fs=case.rate, output="sos")
    smoothed = scipy.signal.sosfiltfilt(sos, case.signals["ddq1"])
    assert identified(case).status == "ok"
    found = identified(case, ddq1=smoothed)
    assert found.status == "recording"
    assert "the fast part of ddq1 does not agree" in found.message


@pytest.mark.parametrize(
    ("number", "samples", "status", "said"),
    [(19, 101, "poor_fit", "without a mode"), (34, 51, "timing", "Fm lags with a time constant")],
)
def test_an_averaged_force_does_not_pass_for_an_overdamped_axis(
    number: int, samples: int, status: str, said: str
) -> None:
    case = draw_case(np.random.default_rng([731080, number, 1]))
    weights = np.full(samples, 1 / samples)
    averaged = np.convolve(np.pad(case.signals["Fm"], (samples - 1, 0), mode="edge"), weights, "valid")
    assert identified(case).status == "ok"
    found = identified(case, Fm=averaged)
    assert found.status == status
    assert said in found.message


def test_a_lag_behind_noise_that_moves_the_mass_is_named() -> None:
    """The noise of the derivative leaves 71 % of the residual, with a mass of 118 for 4.5 kg."""
    random = np.random.default_rng([260208, 20, 1])
    found = identified(damaged(draw_case(random), random, "lagged"))
    assert found.status == "timing"
    assert found.message.startswith("F lags with a time constant of")


def low_passed(number: int, seed: int = 731099) -> Case:
    random = np.random.default_rng([seed, number, 1])
    return damaged(draw_case(random), random, "low_passed")


@pytest.mark.parametrize(("number", "error"), [(39, 0.05), (18, 0.03)])
def test_a_zero_phase_low_pass_that_moves_a_parameter_a_little_is_no_ok(number: int, error: float) -> None:
    """One removes half of the residual of a rigid axis, one next to nothing on a flexible axis whose force is bare."""
    case = low_passed(number, 7018913)
    found = identified(case)
    assert found.status == "recording"
    assert "does not agree with the other signals" in found.message
    assert max(abs(found.physical_parameters[name] / true - 1) for name, true in case.truth.items()) > error


def test_a_mode_above_the_cutoff_of_a_model_that_leaves_much_is_no_ok(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(examined_faults, "smoothing_by_residual", lambda *_: "")  # it is named first
    found = identified(low_passed(34))
    assert found.status == "poor_fit"
    assert "lies above the cutoff" in found.message


@pytest.mark.parametrize(("cutoff", "is_said"), [(15.0, True), (20.0, False)])
def test_only_a_mode_above_the_cutoff_is_said(cutoff: float, is_said: bool) -> None:
    model = load_generated("direct_2m1s", ("q2",))
    X = np.asarray(model.minimal_parameters(30.0, 20.0, 4e5, 10.0, 5.0, 1.0))
    assert bool(mode_above(model, X, cutoff)) == is_said  # it is at 18.38 Hz


def test_a_delay_of_a_small_part_of_a_slow_sample_is_a_fault_where_it_moves_a_parameter() -> None:
    case = low_passed(14)
    found = identified(case)
    assert found.timing is not None
    assert abs(found.timing.samples) < 0.2
    assert found.status == "timing"
    cured = dict(zip(found.model.physical_units, found.timing.parameters, strict=True))
    assert cured["Fv"] == pytest.approx(case.truth["Fv"], rel=0.01)
