"""What a recorder does to channels costs no effect its name, and is reported."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import polars as pl
import pytest
import scipy
from command_line import run
from hand_made import RIGID, rigid_log

from symid import Log, load_axis
from symid.arrays import FloatArray
from symid.data.quality.lost_samples import restored
from symid.diagnosis import diagnose
from symid.diagnosis.effects import Placed, effects_named
from symid.diagnosis.effects.signals import RecordedLagEffect
from symid.diagnosis.prediction.preparation import repaired
from symid.diagnosis.prediction.quantisation import rounding_error
from symid.errors import LogError
from symid.identification.faults.smoothing import interpolated_from, updated_every


def with_drag(seconds: float = 6.0) -> Log:
    return rigid_log(lambda t, q, v, a, path: 300 * v * abs(v), seconds=seconds)


def recorded(log: Log, change: Callable[[FloatArray], FloatArray], *names: str) -> Log:
    return replace(log, signals={k: change(x) if k in names else x for k, x in log.signals.items()})


def held(x: FloatArray) -> FloatArray:
    return x[np.arange(x.size) // 4 * 4]


def between(x: FloatArray) -> FloatArray:
    at = np.arange(x.size)
    return np.interp(at, at[::4], x[::4])


def zeroed(x: FloatArray) -> FloatArray:
    return np.where(np.arange(x.size) % 211 == 57, 0.0, x)


@pytest.mark.parametrize(
    ("change", "names", "statement"),
    [
        (held, ("q",), "q is updated every 4th sample only"),
        (held, ("q", "F"), "q is updated every 4th sample only"),
        (between, ("q", "F"), "q is measured, and interpolated, every 4th sample only"),
        (zeroed, ("q", "F"), "'q' was exactly 0 in"),
    ],
)
def test_an_effect_is_found_in_spite_of_the_recorder(
    change: Callable[[FloatArray], FloatArray], names: tuple[str, ...], statement: str
) -> None:
    found = diagnose(load_axis("rigid_1m"), recorded(with_drag(), change, *names), nominal=RIGID)
    assert (found.verdict, found.effects[0].effect) == ("effect", "quadratic_drag")
    drag = found.effects[0].parameters["c"]
    assert abs(drag.value - 300) < 3 * drag.std < 0.1 * 300
    assert any(fault.startswith(statement) for fault in found.faults)


def test_rows_that_a_recorder_repeats_are_interpolated() -> None:
    log, rng = with_drag(), np.random.default_rng(4)
    row = np.arange(log.n_samples)
    row = np.maximum.accumulate(np.where(rng.random(row.size) < 0.08, 0, row))
    found = diagnose(load_axis("rigid_1m"), recorded(log, lambda x: x[row], "q", "F"), nominal=RIGID)
    assert (found.verdict, found.effects[0].effect) == ("effect", "quadratic_drag")
    assert any("rows repeated the one before" in fault for fault in found.faults)


def test_what_is_restored_of_a_coarse_channel_lies_on_its_steps() -> None:
    q = 5.0 + np.round(100 * np.sin(np.arange(4000) / 300)) / 100
    values, _ = restored({"q": zeroed(q)}, ["q"])
    assert np.isin(values["q"], q).all()
    assert np.abs(values["q"] - q).max() < 0.011


def test_a_coarse_encoder_is_no_machine() -> None:
    step = 5e-5
    coarse = recorded(rigid_log(), lambda x: np.round(x / step) * step, "q")
    assert diagnose(load_axis("rigid_1m"), coarse, nominal=RIGID).verdict in ("no_gap", "parameters")
    log = recorded(with_drag(), lambda x: np.round(x / step) * step, "q")
    found = diagnose(load_axis("rigid_1m"), log, nominal=RIGID)
    assert (found.verdict, found.effects[0].effect) == ("effect", "quadratic_drag")


@pytest.mark.parametrize(("hertz", "longest"), [(2000.0, 0.01), (250.0, 0.04)])
def test_no_record_passes_a_filter_of_tens_of_milliseconds_and_samples(hertz: float, longest: float) -> None:
    (recorded_lag,) = (x for x in effects_named(["actuator_lag"]) if isinstance(x, RecordedLagEffect))
    prediction = SimpleNamespace(record=SimpleNamespace(log=SimpleNamespace(sampling_period=1 / hertz)))
    slower = (Placed(recorded_lag, "actuator", (factor * -longest,), (1.0,)) for factor in (0.9, 1.1))
    assert [recorded_lag.is_possible(prediction, item) for item in slower] == [True, False]


def test_a_filtered_force_is_no_flexible_machine() -> None:
    b, a = scipy.signal.butter(1, 1 / (2 * np.pi * 0.0005), fs=2000)
    slow = recorded(with_drag(), lambda x: scipy.signal.lfilter(b, a, x), "F")
    found = diagnose(load_axis("rigid_1m"), slow, nominal=RIGID)
    effects = {one.effect: one for one in found.effects}
    assert set(effects) == {"quadratic_drag", "actuator_lag"}
    assert effects["actuator_lag"].parameters["T"].value == pytest.approx(-0.0005, rel=0.1)
    milliseconds = f"{-1e3 * effects['actuator_lag'].parameters['T'].value:.3g} ms"
    assert any(f"recorded through a first-order filter of {milliseconds}" in fault for fault in found.faults)


@pytest.mark.parametrize("name", ["q", "F"])
def test_no_effect_is_read_from_one_signal_that_is_averaged(name: str) -> None:
    averaged = recorded(with_drag(3.0), lambda x: scipy.ndimage.uniform_filter1d(x, 41), name)
    found = diagnose(load_axis("rigid_1m"), averaged, nominal=RIGID)
    assert found.verdict == "recording"
    assert f"{name} is a mean over 41 samples" in found.sentence


def test_a_gain_that_changes_within_the_log_is_pointed_at() -> None:
    log, later = rigid_log(), np.arange(rigid_log().n_samples) > 0.6 * rigid_log().n_samples
    changed = recorded(log, lambda x: np.where(later, x / 3, x), "F")
    for other, name in ((None, "the log"), (log, "the identification log")):
        found = diagnose(load_axis("rigid_1m"), changed, validation=other, nominal=RIGID)
        assert found.verdict == "unexplained"
        assert found.next_experiment.startswith(f"Look at what changed: in a part of {name} from")


def test_a_short_mean_costs_no_effect_its_name() -> None:
    averaged = recorded(with_drag(), lambda x: scipy.ndimage.uniform_filter1d(x, 9), "F")
    found = diagnose(load_axis("rigid_1m"), averaged, nominal=RIGID)
    assert found.verdict in ("effect", "partly")
    assert found.effects[0].effect == "quadratic_drag"


def test_a_sound_log_is_left_as_it_is() -> None:
    log = with_drag()
    found = repaired(load_axis("rigid_1m"), [log])
    assert found.logs[0] is log
    assert (found.notes, found.decimation) == ((), 1)


def test_a_slow_encoder_of_few_lines_is_updated_whenever_its_motion_says() -> None:
    coarse = np.round(40 * np.sin(np.arange(20_000) / 900)) / 40
    assert updated_every(coarse) == (1, 0)


def test_zeros_that_a_signal_passes_are_no_lost_samples() -> None:
    q = np.round(100 * np.sin(np.arange(2000) / 40)) / 100
    values, notes = restored({"q": q, "F": np.roll(q, 7)}, ["q"])
    assert notes == []
    assert values["q"] is q


def test_a_rough_command_passes_zero_by_chance() -> None:
    rng = np.random.default_rng(6)
    rough = np.round(np.repeat([0.0, 1.0], 1500) * (12 + 12 * rng.standard_normal(3000)))
    assert np.count_nonzero(rough[1500:] == 0) > 10
    assert restored({"F": rough}, [])[1] == []


def test_a_coarse_position_that_mostly_rests_was_interpolated_all_the_same() -> None:
    counts = np.round(40 * np.clip(np.sin(np.arange(6000) / 40), -0.4, 0.4))
    slow = np.interp(np.arange(1, 24_000) / 4, np.arange(6000), counts)
    assert interpolated_from(slow) == 4
    thin = repaired(
        load_axis("rigid_1m"), [Log.from_arrays({"q": slow, "F": np.sin(slow)}, sampling_period=1e-3)]
    )
    assert np.isin(thin.logs[0]["q"], counts).all()


def test_a_file_with_lost_samples_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    log = recorded(with_drag(), zeroed, "q", "F")
    pl.DataFrame({"t": log.time, "q": log["q"], "F": log["F"]}).write_csv("run.csv")
    Path("nominal.json").write_text(json.dumps(RIGID))
    assert run("diagnose", "rigid_1m", "run.csv", "--nominal", "nominal.json", "--json", "-") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["effects"][0]["effect"] == "quadratic_drag"


def test_noise_of_a_fine_encoder_that_turns_fast_is_no_rounding() -> None:
    rng, step = np.random.default_rng(1), 1e-6
    path = 0.3 * np.sin(2 * np.pi * 0.5 * np.arange(20000) / 4000)
    quiet, noisy = (step * np.round((path + std * rng.standard_normal(20000)) / step) for std in (1e-8, 1e-6))
    assert rounding_error(quiet) is not None
    assert rounding_error(noisy) is None


def test_a_short_log_shows_a_slow_channel_by_steps_that_no_encoder_makes() -> None:
    t, step = np.arange(120) / 1000, 1e-4
    spun_up = np.round(20 * t**2 / step) * step
    assert updated_every(held(spun_up)) == (4, 0)
    assert updated_every(spun_up) == updated_every(np.arange(120) // 4 * step) == (1, 0)
    log = Log.from_arrays({"F": np.sin(60 * t), "q": held(spun_up)}, sampling_period=1e-3)
    with pytest.raises(LogError, match="30 independent samples, as q is updated every 4th sample only"):
        repaired(load_axis("rigid_1m"), [log])
