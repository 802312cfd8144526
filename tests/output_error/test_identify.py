"""From simulated logs back to the parameters: the simulation integrates the axis by other code, event by event."""

import math
from dataclasses import replace

import numpy as np
import pytest

from symid import (
    Axis,
    CoulombFriction,
    Log,
    Preparation,
    Velocity,
    compiled,
    derive,
    identify,
    load_axis,
    load_generated,
)
from symid.errors import LogError, SettingError
from symid.output_error import OutputErrorIdentification, identify_output_error
from symid.simulation import chirp, plant_of, simulate, trapezoids, tuned_cascade

HELD = Preparation(held=True)

RIGID = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}
PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
SCREW = {"Mm": 250.0, "Fvm": 400.0, "Fsm": 60.0, "Kt": 4e7, "Ft": 9000.0, "Ml": 420.0, "Fvl": 700.0}
HUNG = PAPER | {"Fvs": 39491.7, "Fvm": 886.0, "Kl": 5e7, "Fl": 9000.0, "Ml": 150.0}
NOISE = {
    "q": 1e-8,
    "q2": 1e-8,
    "qm": 1e-8,
    "ql": 1e-8,
    "vl": 1e-5,
    "ddq1": 2e-3,
    "F": 0.3,
    "Fm": 0.3,
    "iq": 0.02,
}


def logged(axis: Axis, values, sensor: str, *, rate: float = 500.0, seed: int | None = None) -> Log:
    """Trapezoids with dwells under a cascade that runs at the log's rate and holds its force."""
    reference = trapezoids(
        [0.2], [0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / rate
    )
    run = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), sensor, bandwidth_hz=8.0))
    return run.log if seed is None else noisy(run.log, seed)


def noisy(log: Log, seed: int, scale: float = 1.0) -> Log:
    random = np.random.default_rng(seed)
    added = {
        name: scale * NOISE.get(name, 0.0) * random.standard_normal(log.n_samples) for name in log.signals
    }
    return replace(log, signals={name: log[name] + added[name] for name in log.signals})


def deviations(found: OutputErrorIdentification, truth) -> dict[str, float]:
    """Errors of the parameters in their own standard deviations."""
    spread = np.sqrt(np.diag(found.physical_covariance(corrected=True)))
    rows = zip(found.physical_parameters.items(), spread, strict=True)
    return {name: (value - truth[name]) / std for (name, value), std in rows}


@pytest.mark.parametrize(
    ("name", "truth", "measured"),
    [
        ("rigid_1m", RIGID, ("q",)),
        ("direct_2m1s", PAPER | {"Fsm": 0.0}, ("q2",)),
        ("direct_2m1s", PAPER | {"Fsm": 0.0}, ("q2", "ddq1")),
        ("ballscrew_2m1s", SCREW | {"Fsm": 0.0}, ("qm",)),
    ],
)
def test_a_log_almost_without_noise_gives_its_parameters_back(name, truth, measured) -> None:
    """1e-11 m and 3e-4 N, begun 2 % off: a likelihood so sharp leads nowhere from afar."""
    log = noisy(logged(load_axis(name), truth, measured[0]), 1, scale=1e-3)
    nominal = {key: value * (1.02 if k % 2 else 0.98) for k, (key, value) in enumerate(truth.items())}
    found = identify_output_error(
        load_axis(name), load_generated(name, measured), log, preparation=HELD, nominal=nominal
    )
    assert found.status == "ok"
    for parameter, value in found.physical_parameters.items():
        assert value == pytest.approx(truth[parameter], rel=2e-3, abs=1e-3), parameter


def test_without_noise_and_start_the_paper_s_axis_comes_back_exactly() -> None:
    """Jerky moves at 250 Hz, where method 1 finds nothing."""
    axis, truth = load_axis("direct_2m1s"), PAPER | {"Fsm": 0.0}
    reference = trapezoids(
        [0.3], [0.1, 0.25, 0.5], acceleration=10.0, jerk=2000.0, dwell=0.2, sampling_period=1 / 250.0
    )
    run = simulate(axis, truth, reference, tuned_cascade(plant_of(axis, truth), "q2", bandwidth_hz=6.0))
    model = load_generated("direct_2m1s", ("q2",))
    method_1 = identify(model, run.log, preparation=Preparation(late={"Fm": -0.5 / 250.0}))
    assert abs(method_1.physical_parameters["Ks"] / truth["Ks"] - 1) > 0.5
    found = identify_output_error(axis, model, run.log, preparation=HELD)
    for parameter, value in found.physical_parameters.items():
        assert value == pytest.approx(truth[parameter], rel=1e-7, abs=1e-6), parameter


@pytest.mark.parametrize(
    ("name", "truth", "measured"),
    [
        ("direct_2m1s", PAPER, ("q2",)),
        ("direct_2m1s", PAPER, ("q2", "ddq1")),
        ("ballscrew_2m1s", SCREW, ("qm",)),
        ("ballscrew_2m1s", SCREW, ("qm", "ql")),
    ],
)
def test_with_friction_and_noise_the_truth_lies_within_the_deviations(name, truth, measured) -> None:
    log = logged(load_axis(name), truth, measured[0], seed=1)
    found = identify_output_error(load_axis(name), load_generated(name, measured), log, preparation=HELD)
    assert found.status == "ok"
    assert all(abs(z) < 4 for z in deviations(found, truth).values()), deviations(found, truth)
    for signal, std in found.noise.items():
        assert std == pytest.approx(NOISE[signal], rel=0.15)
    assert np.all(np.linalg.eigvalsh(_scaled(found.minimal_covariance(corrected=True))) > -1e-9)


def _scaled(covariance: np.ndarray) -> np.ndarray:
    size = np.sqrt(np.diag(covariance))
    return covariance / np.outer(size, size)


def test_three_masses_from_nominal_values() -> None:
    axis = load_axis("direct_3m2s")
    log = logged(axis, HUNG, "q2", seed=2)
    nominal = {name: value * (1.1 if k % 2 else 0.9) for k, (name, value) in enumerate(HUNG.items())}
    found = identify_output_error(
        axis, load_generated("direct_3m2s", ("q2", "ddq1")), log, preparation=HELD, nominal=nominal
    )
    assert all(abs(z) < 4 for z in deviations(found, HUNG).values()), deviations(found, HUNG)


def test_the_course_of_the_force_is_found_from_the_log() -> None:
    axis, model = load_axis("direct_2m1s"), load_generated("direct_2m1s", ("q2",))
    log = logged(axis, PAPER, "q2", seed=3)
    found = identify_output_error(axis, model, log, nominal=PAPER)
    assert found.comparison.force == "held"
    assert not found.comparison.free_timing
    assert found.physical_parameters["Mm"] == pytest.approx(PAPER["Mm"], rel=1e-3)


def test_a_force_that_is_recorded_late_is_noticed() -> None:
    """A smooth force, recorded by its exact values but 0.3 of a sample late."""
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    values, rate, late = RIGID | {"Fs": 0.0}, 500.0, 0.6e-3
    reference = chirp(1.0, 40.0, 6.0, 0.01, sampling_period=1e-4)
    run = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "q", bandwidth_hz=8.0))
    fine = run.forces
    times = np.arange(50, fine.size - 50, 20)
    shifted = np.interp((times - 0.5) * 1e-4 - late, np.arange(fine.size) * 1e-4, fine)
    log = noisy(Log.from_arrays({"q": run.log["q"][times], "F": shifted}, sampling_period=1 / rate), 4)
    found = identify_output_error(axis, model, log)
    assert found.comparison.force == "smooth"
    assert found.comparison.free_timing
    assert found.late == pytest.approx(late, abs=0.03 / rate)
    assert found.physical_parameters["M"] == pytest.approx(RIGID["M"], rel=5e-3)
    fixed = identify_output_error(axis, model, log, preparation=Preparation(late={"F": late}))
    assert not fixed.comparison.free_timing
    assert fixed.physical_parameters["M"] == pytest.approx(RIGID["M"], rel=5e-3)


def test_two_logs_tell_more_than_one() -> None:
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    logs = [logged(axis, RIGID, "q", seed=seed) for seed in (5, 6)]
    single, both = (
        identify_output_error(axis, model, chosen, preparation=HELD, nominal=RIGID)
        for chosen in (logs[0], logs)
    )
    assert all(abs(z) < 4 for z in deviations(both, RIGID).values())
    one, two = (np.sqrt(np.diag(f.physical_covariance(corrected=False))) for f in (single, both))
    np.testing.assert_allclose(two / one, math.sqrt(0.5), rtol=0.2)


def test_friction_of_a_load_whose_position_no_sensor_tells() -> None:
    """Its sign follows from the predicted motion of the load."""
    screw = load_axis("ballscrew_2m1s")
    load = next(e for e in screw.elements if getattr(e, "name", "") == "load")
    axis = replace(screw, sensors=(screw.sensors[0], Velocity("vl", load)))
    rough, truth = axis.with_effect(CoulombFriction(load, "Fsl")), SCREW | {"Fsl": 90.0}
    model = compiled(derive(rough, ("qm", "vl")))
    log = logged(rough, truth, "qm", seed=7)
    found = identify_output_error(rough, model, log, preparation=HELD)
    assert found.fit is not None
    assert found.fit.search.errors[0].run.motions.count(None) == 1
    assert found.status == "undetermined"  # the frictions of motor and load are not told apart
    assert "Fsm, Fsl" in found.message
    assert all(abs(z) < 5 for z in deviations(found, truth).values()), deviations(found, truth)


def test_what_the_motor_encoder_does_not_see_is_not_a_number() -> None:
    axis, model = load_axis("motor_bench"), load_generated("motor_bench", ("qm",))
    truth = {"Jm": 5e-3, "Fvm": 0.02, "Kt": 550.0, "Ft": 0.05, "Pt": 3.0, "Jl": 4.5e-3, "Fvl": 0.02}
    reference = chirp(1.0, 120.0, 4.0, 0.02, sampling_period=1e-3)
    run = simulate(axis, truth, reference, tuned_cascade(plant_of(axis, truth), "qm", bandwidth_hz=8.0))
    found = identify_output_error(axis, model, noisy(run.log, 8), preparation=HELD, nominal=truth)
    assert math.isnan(found.physical_parameters["Pt"])
    covariance = found.physical_covariance(corrected=False)
    place = list(found.physical_parameters).index("Pt")
    assert np.isnan(covariance[place]).all()
    assert np.isfinite(found.minimal_covariance(corrected=False)).all()
    for name in ("Jm", "Jl", "Kt"):
        assert found.physical_parameters[name] == pytest.approx(truth[name], rel=2e-2)


def test_a_log_in_which_nothing_moves_has_no_start() -> None:
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    log = logged(axis, RIGID, "q")
    found = identify_output_error(axis, model, log, preparation=Preparation(held=True, standstill=10.0))
    assert found.status == "no_start"
    assert "motion" in found.message
    assert found.physical_parameters == found.minimal_parameters == found.noise == {}
    assert found.late == 0.0
    assert np.isnan(found.physical_covariance(corrected=True)).all()


def test_a_friction_that_pushes_is_not_physical() -> None:
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    log = logged(axis, RIGID, "q")
    pushing = log["F"] - 200.0 * np.gradient(log["q"], log.sampling_period)
    found = identify_output_error(
        axis, model, replace(log, signals={**log.signals, "F": pushing}), preparation=HELD
    )
    assert found.status == "not_physical"
    assert "Fv" in found.message


def test_a_wrong_sign_is_told_as_least_squares_find_it() -> None:
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    log = logged(axis, RIGID, "q")
    turned = replace(log, signals={**log.signals, "F": -log["F"]})
    found = identify_output_error(axis, model, turned, preparation=HELD)
    assert found.status != "ok"
    assert "the sign of F or of a position is wrong" in found.message


@pytest.mark.parametrize("nominal", [{"Fv": 80.0, "Fs": 40.0}, {"M": -1.0, "Fv": 80.0, "Fs": 40.0}])
def test_impossible_nominal_values_are_a_mistake(nominal: dict[str, float]) -> None:
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    with pytest.raises(SettingError):
        identify_output_error(axis, model, logged(axis, RIGID, "q"), preparation=HELD, nominal=nominal)


def test_no_log_and_missing_signals_are_a_mistake() -> None:
    axis, model = load_axis("rigid_1m"), load_generated("rigid_1m", ("q",))
    with pytest.raises(SettingError, match="no log"):
        identify_output_error(axis, model, [])
    with pytest.raises(LogError, match="F"):
        identify_output_error(axis, model, Log.from_arrays({"q": np.zeros(100)}, sampling_period=1e-3))
