"""Bias by noise and by differences: against closed forms, Monte Carlo, and the noise of rows themselves."""

from dataclasses import replace

import numpy as np
import pytest

from symid import Log, Preparation, identify, load_generated
from symid.identification import observe
from symid.identification.deviations.bias import _rest_of_sharper_rows
from symid.identification.rows.noise import noise_levels, noise_limited_widening, noise_of_rows
from symid.identification.rows.observation import rows_by
from symid.identification.rows.settings import DIFFERENCE_ORDER, sharper

SHARP = sharper(DIFFERENCE_ORDER)

RATE = 1000.0


def sine_log(frequency: float, mass: float, viscous: float) -> Log:
    t = np.arange(6000) / RATE
    w = 2 * np.pi * frequency
    v, a = 0.01 * w * np.cos(w * t), -0.01 * w**2 * np.sin(w * t)
    # friction of 1 N keeps the column of the sign in the model
    force = mass * a + viscous * v + np.sign(v)
    return Log.from_arrays({"q": 0.01 * np.sin(w * t), "F": force}, sampling_period=1 / RATE)


@pytest.mark.parametrize("frequency", [5.0, 20.0])
def test_the_loss_of_central_differences_is_that_of_a_sine(frequency: float) -> None:
    """At w the first difference gives sin(wT)/(wT) of the derivative: M comes out as M / that^2."""
    found = identify(
        load_generated("rigid_1m"),
        sine_log(frequency, 95.0, 200.0),
        preparation=Preparation(cutoff_hz=100.0, standstill=0.0, difference_order=2),
    )
    assert found.bias is not None
    x = 2 * np.pi * frequency / RATE
    expected = 95.0 * ((x / np.sin(x)) ** 2 - 1)
    assert found.bias.preparation[0] == pytest.approx(expected, rel=0.05)
    assert found.physical_parameters["M"] - 95.0 == pytest.approx(expected, rel=0.05)
    assert "M" in found.dominated_by_bias


@pytest.mark.parametrize(
    ("axis", "measured", "signals"),
    [
        ("rigid_1m", ("q",), {"q": 2e-6, "F": 3.0}),
        ("direct_2m1s", ("q2", "ddq1"), {"q2": 1e-6, "ddq1": 0.1, "Fm": 5.0}),
        ("direct_2m1s", ("q2",), {"q2": 1e-6, "Fm": 5.0}),
    ],
)
@pytest.mark.parametrize("settings", [{}, {"decimation": 4}, {"filter_force": False, "decimation": 3}])
def test_the_noise_of_rows_is_that_of_rows_of_noise(
    axis: str, measured: tuple[str, ...], signals: dict[str, float], settings: dict[str, int]
) -> None:
    model, random = load_generated(axis, measured), np.random.default_rng(5)
    log = Log.from_arrays(
        {name: size * random.standard_normal(60_000) for name, size in signals.items()},
        sampling_period=1 / RATE,
    )
    seen = observe(model, log, Preparation(cutoff_hz=80.0, standstill=0.0, **settings))
    expected = noise_of_rows(model, log, seen.preparation, noise_levels(model, log))
    for j, (W, y) in enumerate(zip(seen.W, seen.y, strict=True)):
        rows = np.column_stack([W, y])
        linear = [
            k for k in range(rows.shape[1]) if (j, k) not in model.law_columns and np.ptp(rows[:, k]) > 0
        ]
        sample = np.cov(rows[:, linear].T)
        scale = np.sqrt(np.diag(sample))
        ours = expected[j][np.ix_(linear, linear)]
        assert np.abs(ours / np.outer(scale, scale) - sample / np.outer(scale, scale)).max() < 0.1


def rich_log(seed: int, encoder: float) -> Log:
    t, random = np.arange(5000) / RATE, np.random.default_rng(seed)
    q, v, a = np.zeros((3, t.size))
    for amplitude, frequency in ((0.08, 0.37), (0.03, 1.1), (0.006, 2.9)):
        w = 2 * np.pi * frequency
        q += amplitude * np.sin(w * t)
        v += amplitude * w * np.cos(w * t)
        a -= amplitude * w**2 * np.sin(w * t)
    noise = random.standard_normal((2, t.size))
    force = 95.0 * a + 200.0 * v + 20.0 * np.sign(v) + noise[0]
    return Log.from_arrays({"q": q + encoder * noise[1], "F": force}, sampling_period=1 / RATE)


@pytest.mark.parametrize("encoder", [1e-5, 3e-5])
def test_the_bias_by_noise_of_an_encoder_is_taken_off(encoder: float) -> None:
    """Its size is that of least squares without examination; what is left is less than printed deviations hold."""
    model, settings = load_generated("rigid_1m"), Preparation(cutoff_hz=60.0)
    logs = [rich_log(seed, encoder) for seed in range(20)]
    plain = [identify(model, log, preparation=settings, examine=False) for log in logs]
    found = [identify(model, log, preparation=settings) for log in logs]
    before, after = (
        np.array([one.physical_parameters["M"] - 95.0 for one in results]) for results in (plain, found)
    )
    removed = [one.bias.removed[0] for one in found if one.bias is not None and one.bias.removed is not None]
    assert before.mean() < -0.5
    assert np.mean(removed) == pytest.approx(before.mean(), rel=0.1)
    assert abs(after.mean()) < 0.1 * abs(before.mean())
    deviations = np.array([one.physical_deviations[0] for one in found])
    assert np.all(np.abs(after) < 3 * deviations)
    assert np.median(deviations) < 3.0 * np.sqrt(np.mean(after**2))
    assert all("M" in one.dominated_by_bias and one.status == "ok" for one in found)


def test_a_bias_that_is_too_large_to_be_taken_off_is_a_status_with_cause_and_cure() -> None:
    log = rich_log(0, 1e-4)
    found = identify(load_generated("rigid_1m"), log, preparation=Preparation(cutoff_hz=60.0))
    assert found.bias is not None
    assert found.bias.removed is not None
    assert abs(found.bias.removed[0]) < 1e-3
    assert found.physical_parameters["M"] < 70.0
    assert found.status != "ok"


def test_a_force_that_is_not_filtered_is_named_as_the_cause() -> None:
    log = rich_log(0, 0.0)
    settings = Preparation(cutoff_hz=6.0, decimation=1, filter_force=False)
    model = load_generated("rigid_1m")
    with_bias = identify(model, log, preparation=settings)
    without = identify(model, log, preparation=replace(settings, filter_force=True))
    assert with_bias.bias is not None
    shift = with_bias.physical_parameters["M"] - without.physical_parameters["M"]
    assert with_bias.bias.preparation[0] == pytest.approx(shift, rel=0.2)
    assert any("`filter_force=True`" in text for text in (with_bias.message, *with_bias.notes))


def test_examination_can_be_left_out() -> None:
    found = identify(load_generated("rigid_1m"), rich_log(0, 0.0), examine=False)
    assert found.bias is None
    assert found.timing is None
    assert found.dominated_by_bias == ()


@pytest.mark.parametrize("wide", [True, False])
def test_the_rest_of_sharper_rows_is_what_all_their_columns_leave(wide: bool) -> None:
    """Filtered as one row an equation it is the same, however much wider the motion in laws is filtered."""
    model, log = load_generated("rigid_1m"), sine_log(5.0, 95.0, 200.0)
    seen = observe(model, log, Preparation(cutoff_hz=40.0, decimation=3, widening=1.0))
    levels = {"q": 0.0, "F": 0.0} if wide else {"q": 1e-3, "F": 0.0}
    X = np.array([90.0, 180.0, 2.0])
    widening = noise_limited_widening(model, log, 40.0, levels, SHARP.widening)
    assert widening == (SHARP.widening if wide else 2.0)
    W, y = rows_by(model, log, seen.preparation, replace(SHARP, widening=widening))
    expected = np.where(seen.valid, y - W @ X, 0.0)
    rest = _rest_of_sharper_rows(model, log, seen, X, levels)
    assert rest == pytest.approx(expected, abs=1e-9 * np.abs(y).max())
    assert np.abs(rest).max() > 1.0


def reversing_log(seconds: float) -> Log:
    """An exact log of a mass with much Coulomb friction, that reverses often."""
    t = np.arange(int(seconds * RATE)) / RATE
    q, v, a = np.zeros((3, t.size))
    for amplitude, frequency, phase in ((0.05, 1.3, 0.4), (0.02, 4.1, 1.9), (0.008, 9.7, 3.3)):
        w = 2 * np.pi * frequency
        q += amplitude * np.sin(w * t + phase)
        v += amplitude * w * np.cos(w * t + phase)
        a -= amplitude * w**2 * np.sin(w * t + phase)
    force = 20.0 * a + 60.0 * v + 200.0 * np.sign(v)
    return Log.from_arrays({"q": q, "F": force}, sampling_period=1 / RATE)


def test_laws_of_motion_that_is_filtered_less_keep_their_reversals() -> None:
    model, log = load_generated("rigid_1m"), reversing_log(12.0)
    alike, wide = (
        identify(model, log, preparation=Preparation(cutoff_hz=14.0, widening=widening))
        for widening in (1.0, None)
    )
    before, after = (abs(found.physical_parameters["Fv"] / 60.0 - 1) for found in (alike, wide))
    assert before > 0.01
    assert after < before / 5
    assert wide.physical_deviations[1] < alike.physical_deviations[1] / 3


def test_the_bias_of_a_long_log_is_not_that_of_its_excerpts() -> None:
    """Above 65 536 samples parts of a log are examined, to whose rows alone the residual is not orthogonal."""
    model, log = load_generated("rigid_1m"), reversing_log(90.0)
    noise = 20.0 * np.random.default_rng(3).standard_normal(log.n_samples)
    log = Log.from_arrays({"q": log["q"], "F": log["F"] + noise}, sampling_period=1 / RATE)
    found = identify(model, log, preparation=Preparation(cutoff_hz=60.0))
    assert found.bias is not None
    assert np.all(np.abs(found.bias.preparation) < 0.02 * found.sampling_deviations)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_lacking_effect_is_seen_beside_the_bias_by_noise(seed: int) -> None:
    """A cable of 400 N/m, whose column holds no noise of the encoder; the mass is biased by more than its deviation."""
    log, position = rich_log(seed, 3e-5), rich_log(seed, 0.0)["q"]
    pulled = Log.from_arrays({"q": log["q"], "F": log["F"] + 400.0 * position}, sampling_period=1 / RATE)
    found = identify(load_generated("rigid_1m"), pulled, preparation=Preparation(cutoff_hz=60.0))
    assert found.status == "ok"
    assert "a force with the position" in [one.effect for one in found.discrepancies if one.moves()]
    error = np.abs(np.array(list(found.physical_parameters.values())) - [95.0, 200.0, 20.0])
    assert np.all(error < 2 * found.physical_deviations)
