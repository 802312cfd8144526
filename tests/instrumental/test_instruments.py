"""Instrumental variables: the formula, its covariance by Monte Carlo, and axes whose encoders are noisy."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import polars as pl
import pytest
from command_line import run

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Log,
    Preparation,
    Velocity,
    ViscousFriction,
    compiled,
    derive,
    identify,
    load_axis,
    load_generated,
)
from symid.errors import SettingError
from symid.estimation import ObservationBlock, corrected_covariance_of_blocks, estimate, triangular_factors
from symid.identification import Identification, Observation
from symid.identification.deviations.explained import explained_by_instruments
from symid.identification.deviations.stability import greatest_change, scatter
from symid.identification.deviations.whitened import segments
from symid.instrumental import identify_by_instruments
from symid.instrumental.instrumental_fit import estimate_by_instruments
from symid.simulation import ClosedLoop, multisine, plant_of, simulate, trapezoids, tuned_cascade

RIGID = {"M": 95.0, "Fv": 200.0, "Fs": 20.0}
VALUES = {
    "rigid_1m": RIGID,
    "ballscrew_2m1s": {
        "Mm": 80.0, "Fvm": 120.0, "Fsm": 0.0, "Kt": 6e5, "Ft": 700.0, "Ml": 100.0, "Fvl": 150.0
    },
}  # fmt: skip
LINES = {"rigid_1m": (0.5, 1.0, 3.0), "ballscrew_2m1s": (1.0, 2.0, 5.0, 9.0, 14.0)}
RATE = 1000.0
BANDWIDTH = 12.0  # Hz, not that of the cascade that identification would tune


def observation(W: np.ndarray, y: np.ndarray) -> Observation:
    return Observation(W[None], y[None], np.ones((1, y.size), dtype=bool), np.arange(y.size), Preparation())


def test_the_estimate_is_that_of_the_formula() -> None:
    random = np.random.default_rng(2)
    W, Z, y = random.standard_normal((50, 3)), random.standard_normal((50, 3)), random.standard_normal(50)
    Z += W
    start = estimate(triangular_factors(W[None], y[None]))
    found = estimate_by_instruments([observation(W, y)], [Z[None]], start)
    assert found.fit.parameters == pytest.approx(np.linalg.solve(Z.T @ W, Z.T @ y), rel=1e-9)
    inverse = np.linalg.inv(Z.T @ W)
    rest = y - W @ found.fit.parameters
    expected = rest @ rest / 47 * inverse @ Z.T @ Z @ inverse.T
    assert found.fit.covariance == pytest.approx(expected, rel=1e-9)
    same = estimate_by_instruments([observation(W, y)], [W[None]], start)
    assert same.fit.parameters == pytest.approx(start.parameters, rel=1e-9)
    assert same.correlation == pytest.approx(1.0, abs=1e-9)


def test_instruments_that_repeat_each_other_are_weak() -> None:
    random = np.random.default_rng(6)
    W, y = random.standard_normal((50, 3)), random.standard_normal(50)
    for copied in (W[:, [0, 1, 1]], W @ np.diag([1.0, 1.0, 0.0])):
        start = estimate(triangular_factors(W[None], y[None]))
        found = estimate_by_instruments([observation(W, y)], [copied[None]], start)
        assert found.correlation < 1e-6


def test_the_corrected_covariance_of_instruments_is_the_spread_of_estimates() -> None:
    """One parameter, a regressor with noise, a residual that is correlated over time."""
    random = np.random.default_rng(4)
    z = np.sin(0.03 * np.arange(4000))[:, None]
    estimates, claimed = [], []
    for _ in range(150):
        noise = np.convolve(random.standard_normal(4009), np.ones(10), mode="valid")
        W = z + 0.5 * random.standard_normal(z.shape)
        y = 2.0 * z[:, 0] + noise
        start = estimate(triangular_factors(W[None], y[None]))
        fit = estimate_by_instruments([observation(W, y)], [z[None]], start).fit
        block = ObservationBlock(W[None], y[None], instruments=z[None])
        covariance = corrected_covariance_of_blocks(lambda block=block: [block], fit)
        estimates.append(fit.parameters[0])
        claimed.append(covariance.standard_deviations[0])
    assert np.mean(estimates) == pytest.approx(2.0, abs=0.05)
    assert np.mean(claimed) == pytest.approx(np.std(estimates, ddof=1), rel=0.2)


def test_noise_in_the_columns_is_no_change_within_a_log() -> None:
    """One column is small in some fifths of the log: there noise makes most of it.

    Compared by W, its second parameter was 0.98 in one part and 4.05 elsewhere, by eight deviations.
    """
    random, t = np.random.default_rng(8), np.arange(6000) / 100
    z = np.stack([np.sin(2.1 * t), np.cos(3.7 * t) * np.repeat([1.0, 0.2, 1.0, 0.2, 1.0], 1200)], axis=1)
    estimates, claimed = [], []
    for _ in range(60):
        W = z + 0.3 * random.standard_normal(z.shape)
        y = z @ [2.0, 5.0] + 0.1 * random.standard_normal(t.size)
        seen = replace(observation(W, y), time=t)
        start = estimate(triangular_factors(W[None], y[None]))
        fit = estimate_by_instruments([seen], [z[None]], start).fit
        (explained,), own = explained_by_instruments([seen], [z[None]], fit)
        assert explained.y - explained.W @ fit.solution == pytest.approx(y[None] - W @ fit.solution, abs=1e-9)
        rows = SimpleNamespace(read=lambda one=explained: (one,), n_rows=t.size)
        sums = segments([rows], own)
        change = greatest_change(sums, own.solution, own.rank.inverse_root)
        assert change is not None
        assert np.max(np.abs(change.inside - change.outside) / change.deviations) < 5
        estimates.append(fit.parameters)
        claimed.append(np.diag(scatter(sums, own)))
    spread = np.std(estimates, axis=0, ddof=1)
    assert np.sqrt(np.mean(claimed, axis=0)) == pytest.approx(spread, rel=0.25)


def test_a_wheel_with_a_tachometer_is_identified_by_instruments() -> None:
    """It has no position; the simulated loop is one of the velocity, as that of the machine."""
    wheel = Body("wheel", inertia="J")
    friction = ViscousFriction(wheel, "Fv"), CoulombFriction(wheel, "Fs")
    sensor = Velocity("w", wheel, noise=2e-3)
    axis = Axis("wheel", (wheel, *friction), Drive("T", wheel, noise=1e-4), (sensor,))
    values = {"J": 0.08, "Fv": 2e-3, "Fs": 0.02}
    reference = trapezoids([20.0], [10.0, 4.0], acceleration=20.0, jerk=2e3, dwell=0.1, sampling_period=1e-3)
    log = simulate(axis, values, reference, tuned_cascade(plant_of(axis, values), "w", 5.0), seed=3).log
    settings = Preparation(held=True)
    found = identify_by_instruments(compiled(derive(axis)), log, ClosedLoop(axis), preparation=settings)
    assert found.status == "ok"
    errors = np.array(list(found.physical_parameters.values())) - list(values.values())
    assert np.max(np.abs(errors) / found.physical_deviations) < 3


@cache
def closed_loop_log(axis: str) -> Log:
    """Log without noise, of 4 s."""
    declared, values, lines = load_axis(axis), VALUES[axis], np.array(LINES[axis])
    controller = tuned_cascade(plant_of(declared, values), declared.sensors[0].signal, BANDWIDTH)
    reference = multisine(lines, 0.004, sampling_period=1 / RATE, quantity="position", seconds=2.0)
    return simulate(declared, values, reference, controller).log.window(0, 4000)


def with_noise(log: Log, noise: dict[str, float], seed: int) -> Log:
    random = np.random.default_rng(seed)
    noisy = {
        name: x + noise.get(name, 0.0) * random.standard_normal(log.n_samples)
        for name, x in log.signals.items()
    }
    return Log.from_arrays(noisy, sampling_period=log.sampling_period)


@pytest.mark.parametrize(
    ("axis", "measured", "noise", "biased"),
    [
        ("rigid_1m", ("q",), {"q": 5e-6, "F": 0.2}, 0),
        ("ballscrew_2m1s", ("qm", "ql"), {"qm": 6e-5, "ql": 6e-5, "Fm": 1.0}, 0),
    ],
)
def test_noise_of_encoders_biases_least_squares_and_not_instruments(
    axis: str, measured: tuple[str, ...], noise: dict[str, float], biased: int
) -> None:
    """Errors of the mean of five draws in its deviations, beyond what differences cause; nothing is taken off."""
    model, loop = load_generated(axis, measured), ClosedLoop(load_axis(axis))
    settings = Preparation(cutoff_hz=60.0, standstill=0.005, late={model.force: -0.5 / RATE})
    truth = model.minimal_parameters(*VALUES[axis].values())
    results: dict[str, list[Identification]] = {"wls": [], "iv": []}
    for seed in range(5):
        log = with_noise(closed_loop_log(axis), noise, seed)
        results["wls"].append(identify(model, log, preparation=settings))
        results["iv"].append(
            identify_by_instruments(model, log, loop, preparation=settings, nominal=VALUES[axis])
        )
    assert {found.fit.method for found in results["iv"]} == {"iv"}
    wls, iv = (mean_error(results[name], truth)[biased] for name in ("wls", "iv"))
    assert abs(wls) > 5 > 3 > abs(iv)


def mean_error(results: list[Identification], truth: np.ndarray) -> np.ndarray:
    errors = [
        found.fit.parameters
        + (0.0 if found.bias.removed is None else found.bias.removed)
        - truth
        - found.bias.preparation
        for found in results
        if found.bias
    ]
    deviation = np.mean([found.sampling_deviations for found in results], axis=0) / np.sqrt(len(results))
    assert len(errors) == len(results)
    return np.asarray(np.mean(errors, axis=0) / deviation)


def test_the_controller_is_read_from_the_log_and_reported() -> None:
    log = with_noise(closed_loop_log("rigid_1m"), {"q": 1e-6}, 0)
    found = identify_by_instruments(
        load_generated("rigid_1m"), log, ClosedLoop(load_axis("rigid_1m")), examine=False
    )
    used = tuned_cascade(plant_of(load_axis("rigid_1m"), RIGID), "q", BANDWIDTH)
    (note,) = (note for note in found.notes if "instruments" in note)
    assert "read from the log" in note
    assert float(note.split("Kpv ")[1].split(",")[0]) == pytest.approx(used.velocity_gain, rel=0.05)


def test_a_reference_that_is_not_that_of_the_log_makes_weak_instruments() -> None:
    log = with_noise(closed_loop_log("rigid_1m"), {"q": 1e-6}, 0)
    other = trapezoids([0.01], [0.05], acceleration=1.0, jerk=50.0, sampling_period=1 / RATE)
    wrong = np.resize(other.position[::-1], log.n_samples)
    signals = {"q": log["q"], "F": log["F"], "reference": np.random.default_rng(0).permutation(wrong) * 1e-3}
    loop = ClosedLoop(
        load_axis("rigid_1m"), controller=tuned_cascade(plant_of(load_axis("rigid_1m"), RIGID), "q")
    )
    found: Identification = identify_by_instruments(
        load_generated("rigid_1m"), Log.from_arrays(signals, sampling_period=1 / RATE), loop, nominal=RIGID
    )
    assert found.status == "weak_instruments"
    assert "`controller`" in found.message


def test_mistakes_are_refused() -> None:
    model, loop = load_generated("rigid_1m"), ClosedLoop(load_axis("rigid_1m"))
    log = closed_loop_log("rigid_1m")
    bare = Log.from_arrays({"q": log["q"], "F": log["F"]}, sampling_period=1 / RATE)
    with pytest.raises(SettingError, match="reference"):
        identify_by_instruments(model, bare, loop)
    with pytest.raises(SettingError, match="not a multiple"):
        identify_by_instruments(model, log, ClosedLoop(load_axis("rigid_1m"), rate_hz=1500.0))
    with pytest.raises(SettingError, match="positive"):
        ClosedLoop(load_axis("rigid_1m"), rate_hz=-1.0)


def test_the_command_takes_the_method(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = with_noise(closed_loop_log("rigid_1m"), {"q": 1e-6}, 0)
    pl.DataFrame({"t": log.time, **log.signals}).write_csv("run.csv")
    common = ("identify", "rigid_1m", "run.csv", "--held", "F", "--method", "iv")
    assert run(*common, "--json", "run.json") == 0
    record = json.loads(Path("run.json").read_text())
    assert record["method"] == "iv"
    assert record["physical"]["M"]["value"] == pytest.approx(95.0, rel=0.01)
    assert (
        run(*common, "--controller-gain", "Kpp=25", "--controller-gain", "Kpv=12000", "--rate", "1000") == 0
    )
    assert "given controller" in " ".join(capsys.readouterr().out.split())
    assert run(*common, "--controller-gain", "Kpp=25") == 2
    assert "Kpv" in capsys.readouterr().err
    pl.DataFrame({"t": log.time, "q": log["q"], "F": log["F"]}).write_csv("bare.csv")
    assert run("identify", "rigid_1m", "bare.csv", "--method", "iv") == 2
    assert "--column reference=NAME" in capsys.readouterr().err


@pytest.mark.parametrize("measured", [("qm",), ("qm", "ql")])
def test_encoders_of_different_zeros_leave_instruments_strong(measured: tuple[str, ...]) -> None:
    """The simulated axis begins at rest, with a zero that only the second encoder shows."""
    values = {"Jm": 8e-3, "Fvm": 0.05, "Kt": 60.0, "Ft": 0.02, "Pt": 20.0, "Jl": 9e-3, "Fvl": 0.03}
    axis = load_axis("motor_bench")
    controller = tuned_cascade(plant_of(axis, values), "qm", BANDWIDTH)
    lines = np.array([0.5, 1.0, 2.0, 5.0, 9.0, 14.0, 22.0])
    reference = multisine(lines, 0.2, sampling_period=1 / RATE, quantity="position", seconds=2.0)
    log = simulate(axis, values, reference, controller, start="equilibrium").log.window(0, 4000)
    kept = [*measured, "iq", "reference"]
    log = Log.from_arrays({name: log[name] for name in kept}, sampling_period=1 / RATE)
    found = identify_by_instruments(
        load_generated("motor_bench", measured), with_noise(log, {"qm": 1e-6}, 3), ClosedLoop(axis),
        preparation=Preparation(held=True),
    )  # fmt: skip
    assert found.status == "ok", found.message
    assert found.physical_parameters["Jl"] == pytest.approx(9e-3, rel=0.02)


def test_a_force_of_the_wrong_sign_is_named() -> None:
    log = with_noise(closed_loop_log("rigid_1m"), {"q": 1e-6}, 0)
    turned = replace(log, signals={**log.signals, "F": -log["F"]})
    found = identify_by_instruments(load_generated("rigid_1m"), turned, ClosedLoop(load_axis("rigid_1m")))
    assert found.status == "weak_instruments"
    assert "the sign of F or of a position is wrong" in found.message
