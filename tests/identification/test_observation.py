"""Preparation of logs: filter, timing, standstill, edges, on signals whose truth is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from symid import Log, Preparation, compiled, derive, identify, load_axis, load_generated
from symid.errors import SettingError
from symid.identification import observe
from symid.identification.rows.usable_rows import leave_out_spoiled
from symid.signal_processing import LowPass

MASS, VISCOUS, COULOMB = 5.0, 3.0, 2.0
RATE = 4000.0


def rigid_log(*, late: float = 0.0, noise: float = 0.0, seconds: float = 4.0, shift: float = 0.0) -> Log:
    """Exact motion of a rigid axis; its force is recorded `late` seconds later than its position."""
    t = np.arange(int(seconds * RATE)) / RATE

    def motion(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        first, second = 2 * np.pi * 1.3, 2 * np.pi * 3.1
        q = 0.2 * np.sin(first * time) + 0.03 * np.sin(second * time)
        v = 0.2 * first * np.cos(first * time) + 0.03 * second * np.cos(second * time)
        a = -0.2 * first**2 * np.sin(first * time) - 0.03 * second**2 * np.sin(second * time)
        return q, v, a

    _, v, a = motion(t - late)
    force = MASS * a + VISCOUS * v + COULOMB * np.sign(v)
    force += noise * np.random.default_rng(7).standard_normal(t.size)
    return Log.from_arrays({"q": motion(t)[0] + shift, "F": force}, sampling_period=1 / RATE)


def relative_errors(log: Log, preparation: Preparation) -> np.ndarray:
    found = identify(load_generated("rigid_1m"), log, preparation=preparation)
    assert found.status in ("ok", "timing")
    return np.abs(np.array(list(found.physical_parameters.values())) / [MASS, VISCOUS, COULOMB] - 1)


@pytest.mark.parametrize(
    "preparation",
    [Preparation(), Preparation(standstill=0.0), Preparation(cutoff_hz=30.0), Preparation(decimation=1)],
)
def test_exact_signals_give_exact_parameters(preparation: Preparation) -> None:
    assert relative_errors(rigid_log(), preparation).max() < 2e-3


@pytest.mark.parametrize("late", [1 / RATE, 2.5 / RATE, -0.37 / RATE])
def test_a_declared_lateness_is_taken_out(late: float) -> None:
    log = rigid_log(late=late)
    assert relative_errors(log, Preparation())[1] > 5e-3
    assert relative_errors(log, Preparation(late={"F": late})).max() < 2e-3


def test_a_declared_hold_is_half_a_sample_unless_the_settings_say_otherwise() -> None:
    """The log is that of a force which acts half a sample after it is recorded."""
    axis = load_axis("rigid_1m")
    holding = compiled(derive(replace(axis, drive=replace(axis.drive, held=True))))
    log, silent = rigid_log(late=-0.5 / RATE), load_generated("rigid_1m")
    friction = {
        (model.held, held): identify(model, log, preparation=Preparation(held=held)).physical_parameters["Fv"]
        for model in (holding, silent)
        for held in (None, True, False)
    }
    right = {(True, None), (True, True), (False, True)}
    for key, found in friction.items():
        assert (abs(found / VISCOUS - 1) < 2e-3) == (key in right), key
    moved = Preparation(late={"F": -0.25 / RATE}, held=True)
    chosen = observe(silent, log, moved).preparation
    assert (chosen.late, chosen.held) == ({"F": -0.75 / RATE}, False)


def test_filtering_motion_alone_biases_what_the_force_shares_with_it() -> None:
    log = rigid_log()
    both = relative_errors(log, Preparation(cutoff_hz=6.0, decimation=1, standstill=0.0))
    motion = relative_errors(
        log, Preparation(cutoff_hz=6.0, decimation=1, standstill=0.0, filter_force=False)
    )
    assert motion[0] > 10 * both[0]


def test_rows_near_standstill_are_left_out_of_equations_with_friction_or_without_its_derivative() -> None:
    model, log = load_generated("direct_2m1s", ("q2", "ddq1")), rigid_log()
    signals = {"q2": log["q"], "Fm": log["F"], "ddq1": np.gradient(np.gradient(log["q"]))}
    run = Log.from_arrays(signals, sampling_period=1 / RATE)
    observation = observe(model, run, Preparation(cutoff_hz=100.0, decimation=1, standstill=0.05))
    velocity = observation.W[0, :, 1]
    assert not observation.valid[0][np.abs(velocity) < 0.05].any()
    assert observation.valid[0].mean() > 0.8
    assert not observation.valid[1][np.abs(velocity) < 0.05].any()


def test_edges_are_trimmed_and_rows_keep_their_time() -> None:
    log = rigid_log()
    observation = observe(
        load_generated("rigid_1m"), log, Preparation(cutoff_hz=50.0, decimation=4, trim=(100, 300))
    )
    assert observation.time[-1] == pytest.approx(log.time[-301])
    assert np.allclose(np.diff(observation.time), 4 / RATE)
    assert observation.W.shape == (1, observation.time.size, 3)


def test_the_chosen_cutoff_scales_with_the_sampling_rate_and_is_reported() -> None:
    log = rigid_log(noise=0.2)
    chosen = observe(load_generated("rigid_1m"), log, Preparation()).preparation
    assert chosen.cutoff_hz is not None
    assert 3.1 < chosen.cutoff_hz < RATE / 4
    assert chosen.decimation is not None
    assert chosen.cutoff_hz <= 0.8 * RATE / (2 * chosen.decimation)


@pytest.mark.parametrize(
    ("setting", "word"),
    [
        ({"cutoff_hz": RATE}, "cutoff"),
        ({"cutoff_hz": -1.0}, "cutoff"),
        ({"decimation": 0}, "decimation"),
        ({"standstill": -1.0}, "standstill"),
        ({"trim": (-1, 0)}, "trim"),
        ({"trim": (9000, 9000)}, "trimming"),
    ],
)
def test_impossible_settings_are_refused_by_name(setting: dict[str, float], word: str) -> None:
    with pytest.raises(SettingError, match=word):
        observe(load_generated("rigid_1m"), rigid_log(), Preparation(**setting))


@pytest.mark.parametrize("rate", [6.0, 11.0, 13.5, 15.4])
def test_a_sine_that_begins_in_motion_is_ok(rate: float) -> None:
    """Transients of the filter, 180 times the noise in the first row, were taken for delays, drift and changes."""
    t = np.arange(4000) / 1000
    q, v, a = np.sin(rate * t), rate * np.cos(rate * t), -(rate**2) * np.sin(rate * t)
    force = MASS * a + VISCOUS * v + COULOMB * np.sign(v)
    force += 0.05 * np.random.default_rng(0).standard_normal(t.size)
    found = identify(load_generated("rigid_1m"), Log.from_arrays({"q": q, "F": force}, sampling_period=1e-3))
    assert found.status == "ok"
    errors = np.array([*found.physical_parameters.values()]) - [MASS, VISCOUS, COULOMB]
    assert np.all(np.abs(errors) < 4 * found.physical_deviations)


@pytest.mark.parametrize(("size", "left_out"), [(0.0, 0), (2.0, 0), (1e3, 20)])
def test_rows_with_a_transient_of_the_filter_are_left_out(size: float, left_out: int) -> None:
    """Size is that of the transient in the first row, over the noise."""
    low_pass, rng = LowPass(20.0), np.random.default_rng(1)
    places = np.arange(100.0, 4000.0, 10.0)
    W, noise = rng.standard_normal((1, places.size, 3)), rng.standard_normal((1, places.size))
    poles = low_pass.zero_phase(1000.0).transients(places - places[0])
    usable = np.ones_like(noise, dtype=bool)
    y = W @ np.ones(3) + noise + size * poles[:, 1]
    leave_out_spoiled(low_pass, 1000.0, (W, y, usable), (100, 10), step=10)
    assert np.argmax(usable) == pytest.approx(left_out, abs=3)
    assert usable[0, left_out + 3 :].all()
