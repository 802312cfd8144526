"""A log that is identified in blocks gives what it gives in memory, and takes no memory of its own length."""

import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from symid import Identification, Log, Preparation, identify, load_generated
from symid.data import LongLog
from symid.errors import SettingError

RATE = 1000.0


def rigid(samples: int, seed: int = 0) -> Log:
    """An EMPS-like axis: inertia, viscous and dry friction, offset; two sines and noise on both signals."""
    rng, t = np.random.default_rng(seed), np.arange(samples) / RATE
    q, v, a = np.zeros((3, samples))
    for amplitude, frequency in ((0.1, 0.41), (2e-3, 5.3)):
        w = 2 * np.pi * frequency
        q, v = q + amplitude * np.sin(w * t), v + amplitude * w * np.cos(w * t)
        a = a - amplitude * w**2 * np.sin(w * t)
    force = 95.0 * a + 203.0 * v + 20.0 * np.sign(v) - 3.0 + 2.0 * rng.standard_normal(samples)
    return Log.from_arrays(
        {"q": q + 1e-7 * rng.standard_normal(samples), "F": force}, sampling_period=1 / RATE, start=2.0
    )


def flexible(samples: int) -> Log:
    """A motor on a hung mass, driven by 20 sines: M = 3000 and 100 kg, 4e7 N/m, 2e4 and 500 N s/m."""
    rng, t = np.random.default_rng(3), np.arange(samples) / RATE
    q, force = np.zeros((2, samples))
    for frequency in np.linspace(2.1, 38.0, 20):
        s = 2j * np.pi * frequency
        above = 3000 * s**2 + 2e4 * s + 4e7
        compliance = (above + 100 * s**2) / (100 * s**2 * above + 500 * s * (above + 100 * s**2))
        wave = 20.0 * np.exp(s * t + 1j * rng.uniform(0, 2 * np.pi))
        force += wave.real
        q += (compliance * wave).real
    noise = rng.standard_normal((2, samples))
    return Log.from_arrays(
        {"q2": q + 1e-9 * noise[0], "Fm": force + 0.1 * noise[1]}, sampling_period=1 / RATE
    )


def compared(found: Identification, whole: Identification, rtol: float = 1e-9) -> None:
    # a parameter that is zero differs by rounding, of which fourth derivatives keep few digits
    apart = np.abs(found.fit.parameters - whole.fit.parameters)
    assert np.all(apart <= rtol * (np.abs(whole.fit.parameters) + whole.standard_deviations))
    for one, other in (
        (found.standard_deviations, whole.standard_deviations),
        (found.fit.standard_deviations, whole.fit.standard_deviations),
        (found.fit.residual_norm, whole.fit.residual_norm),
    ):
        np.testing.assert_allclose(one, other, rtol=rtol)
    assert found.fit.rows == whole.fit.rows
    assert (found.status, found.message, found.notes) == (whole.status, whole.message, whole.notes)
    assert found.timing is not None
    assert whole.timing is not None
    assert found.timing.late == pytest.approx(whole.timing.late, rel=1e-9)


@pytest.mark.parametrize("block", [1777, 6000])
@pytest.mark.parametrize(
    "settings",
    [
        {"cutoff_hz": 80.0},
        {"cutoff_hz": 60.0, "decimation": 1},
        {"cutoff_hz": 40.0, "decimation": 7, "trim": (13, 0), "late": {"F": 2.3e-3}},
        {"cutoff_hz": 40.0, "filter_force": False, "standstill": 0.02},
        {"cutoff_hz": 40.0, "decimation": 3, "standstill": 0.0},
    ],
)
def test_blocks_of_a_rigid_axis_with_friction(settings: Mapping[str, Any], block: int) -> None:
    log, model, preparation = rigid(20_011), load_generated("rigid_1m"), Preparation(**settings)
    compared(
        identify(model, LongLog.of(log, block), preparation=preparation),
        identify(model, log, preparation=preparation),
    )


@pytest.mark.parametrize("decimation", [None, 1, 5])
def test_blocks_of_a_flexible_axis(decimation: int | None) -> None:
    log, model = flexible(25_000), load_generated("direct_2m1s", ("q2",))
    preparation = Preparation(cutoff_hz=60.0, decimation=decimation)
    compared(
        identify(model, LongLog.of(log, 4000), preparation=preparation),
        identify(model, log, preparation=preparation),
        rtol=1e-6,
    )


def test_several_logs_of_which_one_is_long() -> None:
    one, two, model = rigid(9000, 1), rigid(21_000, 2), load_generated("rigid_1m")
    preparation = Preparation(cutoff_hz=40.0)
    compared(
        identify(model, [one, LongLog.of(two, 5000)], preparation=preparation),
        identify(model, [one, two], preparation=preparation),
    )


def test_the_scatter_of_a_log_longer_than_its_excerpts_is_that_of_all_rows() -> None:
    log, model, preparation = rigid(80_000), load_generated("rigid_1m"), Preparation(cutoff_hz=20.0)
    blocks, whole = (identify(model, one, preparation=preparation) for one in (LongLog.of(log, 30_000), log))
    compared(blocks, whole)
    assert blocks.scatter is not None
    assert whole.scatter is not None
    np.testing.assert_allclose(blocks.scatter, whole.scatter, rtol=1e-6, atol=1e-9 * np.max(whole.scatter))
    np.testing.assert_allclose(blocks.standard_deviations, whole.standard_deviations, rtol=1e-9)


def test_rows_of_the_first_block_are_kept_with_the_preparation_of_the_whole_log() -> None:
    log, model = rigid(20_000), load_generated("rigid_1m")
    settings = Preparation(cutoff_hz=80.0)
    long, whole = (identify(model, one, preparation=settings) for one in (LongLog.of(log, 5000), log))
    first, every = long.observations[0], whole.observations[0]
    assert 0 < first.time.size < every.time.size
    np.testing.assert_allclose(first.time, every.time[: first.time.size], rtol=1e-12)
    assert first.preparation == every.preparation


def test_all_rows_are_kept_where_they_take_no_more_than_a_block() -> None:
    log, model = rigid(20_000), load_generated("rigid_1m")
    settings = Preparation(cutoff_hz=20.0, decimation=8)
    long, whole = (identify(model, one, preparation=settings) for one in (LongLog.of(log, 5000), log))
    for one, other in zip(long.observations, whole.observations, strict=True):
        np.testing.assert_allclose(one.W, other.W, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(one.valid, other.valid)


def test_friction_of_a_drive_is_taken_off_rows_that_are_kept() -> None:
    log, model = flexible(20_000), load_generated("direct_2m1s", ("q2",))
    force = log.signals["Fm"] + 8.0 * np.sign(np.gradient(log.signals["q2"]))
    log = replace(log, signals={**log.signals, "Fm": force})
    settings = Preparation(cutoff_hz=60.0, decimation=10)
    long, whole = (identify(model, one, preparation=settings) for one in (LongLog.of(log, 5000), log))
    assert long.observations[0].time.size == whole.observations[0].time.size
    compared(long, whole, rtol=1e-6)


def test_peak_memory_does_not_grow_with_the_length_of_the_log() -> None:
    """Sums and one block are all that is held; only the lags of the correlation grow, as a square root."""
    model, period = load_generated("rigid_1m"), 1 / RATE
    base = rigid(100_000)

    def read(first: int, stop: int) -> Mapping[str, np.ndarray]:
        places = np.arange(first, stop) % base.n_samples  # 41 and 530 whole periods
        return {name: values[places] for name, values in base.signals.items()}

    def peak(samples: int) -> int:
        log = LongLog("made", 0.0, period, samples, ("q", "F"), read, block=20_000)
        tracemalloc.start()
        identify(model, log, preparation=Preparation(cutoff_hz=60.0, decimation=8), examine=False)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(50_000)  # imports
    assert peak(800_000) < min(1.2 * peak(200_000), 800_000 * 8)  # a single signal has as many bytes


def test_a_trim_that_leaves_nothing_is_refused() -> None:
    with pytest.raises(SettingError, match="leaves nothing"):
        identify(
            load_generated("rigid_1m"),
            LongLog.of(rigid(5000), 500),
            preparation=Preparation(trim=(4000, 1000)),
        )


def test_an_empty_block_is_refused() -> None:
    with pytest.raises(SettingError, match="holds nothing"):
        LongLog.of(rigid(1000), 0)


def test_other_cutoffs_are_tried_as_they_are_in_memory() -> None:
    model, log = load_generated("rigid_1m"), rigid(6000)
    first = identify(model, log, examine=False)
    memory, blocks = (identify(model, one) for one in (log, LongLog.of(log, block=2000)))
    cutoffs = [one.observations[0].preparation.cutoff_hz for one in (first, memory, blocks)]
    assert cutoffs[0] != cutoffs[1] == cutoffs[2]


@pytest.mark.parametrize("read", [lambda log: log, LongLog.of], ids=["in memory", "in blocks"])
def test_a_log_is_examined_where_it_moves(read: Callable[[Log], Log | LongLog]) -> None:
    t, rng = np.arange(200_000) / RATE - 30.0, np.random.default_rng(1)
    moves = (t > 0) & (t < 4)
    size, change = np.sin(np.pi * t / 4) ** 2 * moves, np.pi / 4 * np.sin(np.pi * t / 2) * moves
    q, v = size * np.sin(9 * t), change * np.sin(9 * t) + size * 9 * np.cos(9 * t)
    a = (
        (np.pi**2 / 8 * np.cos(np.pi * t / 2) * moves - 81 * size) * np.sin(9 * t)
        + 18 * change * np.cos(9 * t)
    )  # fmt: skip
    force = 5.0 * a + 9.0 * v + 2.0 * np.sign(v) + 0.01 * rng.standard_normal(t.size)
    log = Log.from_arrays({"q": q + 1e-8 * rng.standard_normal(t.size), "F": force}, sampling_period=1 / RATE)
    found = identify(load_generated("rigid_1m"), read(log))
    assert found.status == "ok"
    assert found.timing is not None
    assert abs(found.timing.late) < 1e-5
    assert found.physical_parameters == pytest.approx({"M": 5.0, "Fv": 9.0, "Fs": 2.0}, rel=1e-3)
