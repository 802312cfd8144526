"""What keeps a result from being ok: faults of channels, clocks, gains and sensors, and what is not determined."""

from functools import lru_cache

import numpy as np
import pytest
import scipy

from benchmarks.promise.machines import Case, draw_case, draw_machine
from symid import Log, Preparation, identify, load_generated
from symid.identification import Identification
from symid.identification.rows.bands import completed
from symid.signal_processing import central_difference, central_difference_gain, derivatives

RATE = 500.0
TRUTH = {"M": 100.0, "Fv": 200.0, "Fs": 20.0}


@lru_cache(maxsize=4)
def motion(seconds: float = 20.0, jerky: bool = True) -> tuple[np.ndarray, ...]:
    """Position, velocity and acceleration of sines without common period, the fastest of 6 Hz."""
    t = np.arange(int(seconds * RATE)) / RATE
    rates = 2 * np.pi * np.array([0.31, 0.83, 1.7, 3.1, 6.1 if jerky else 0.5])
    parts = [(0.2 / w**1.4, w, k) for k, w in enumerate(rates)]
    q = sum(a * np.sin(w * t + k) for a, w, k in parts)
    v = sum(a * w * np.cos(w * t + k) for a, w, k in parts)
    a = sum(-a * w**2 * np.sin(w * t + k) for a, w, k in parts)
    return q, v, a


def rigid(seed: int = 0) -> dict[str, np.ndarray]:
    draw, (q, v, a) = np.random.default_rng(seed), motion()
    F = TRUTH["M"] * a + TRUTH["Fv"] * v + TRUTH["Fs"] * np.sign(v)
    return {"q": q + 1e-7 * draw.standard_normal(q.size), "F": F + 0.5 * draw.standard_normal(q.size)}


def identified(**changed: np.ndarray) -> Identification:
    log = Log.from_arrays({**rigid(), **changed}, sampling_period=1 / RATE)
    return identify(load_generated("rigid_1m"), log)


def test_a_whole_log_is_ok_and_right() -> None:
    found = identified()
    assert found.status == "ok", found.message
    for (name, true), deviation in zip(TRUTH.items(), found.physical_deviations, strict=True):
        assert abs(found.physical_parameters[name] - true) < 4 * deviation < 0.05 * true


def shifted(x: np.ndarray, samples: int) -> np.ndarray:
    return x[np.clip(np.arange(x.size) - samples, 0, x.size - 1)]


def slew_limited(x: np.ndarray, most: float) -> np.ndarray:
    found, last = np.empty_like(x), x[0]
    for k, value in enumerate(x):
        last += min(max(value - last, -most), most)
        found[k] = last
    return found


FAULTS = {
    "zeros": (lambda F, r: np.where(r.random(F.size) < 0.05, 0.0, F), "recording", "filled with 0"),
    "held": (
        lambda F, r: F[np.maximum.accumulate(np.where(r.random(F.size) < 0.2, 0, np.arange(F.size)))],
        "recording",
        "repeats the last value",
    ),
    "rarely": (lambda F, r: np.repeat(F[::4], 4), "recording", "F changes every 4 samples only"),
    "slew": (lambda F, r: slew_limited(F, 0.6), None, "slope is limited"),
    "coarse": (lambda F, r: np.trunc(F / 8) * 8, "recording", "in steps of"),
    "late 0.5 s": (lambda F, r: shifted(F, 250), None, "before it was recorded"),
    "early 40 ms": (lambda F, r: shifted(F, -20), None, "after it was recorded"),
    "clipped": (
        lambda F, r: np.clip(F, -0.5 * F.max(), 0.5 * F.max()) + 0.3 * r.standard_normal(F.size),
        "poor_fit",
        "the true force went beyond it",
    ),
    "soft limit in noise": (
        lambda F, r: (
            1.5 * F.max() * np.tanh(F / (1.5 * F.max())) + 0.03 * F.max() * r.standard_normal(F.size)
        ),
        "poor_fit",
        "where F is large it is less",
    ),
    "drifting gain": (
        lambda F, r: F * np.linspace(1.0, 0.8, F.size) + 0.2 * F.max() * r.standard_normal(F.size),
        "poor_fit",
        "from the start to the end of the log",
    ),
    "interpolated": (
        lambda F, r: np.interp(np.arange(F.size), np.arange(0, F.size, 2), F[::2]),
        "recording",
        "along straight lines of 2 samples each",
    ),
    "mean": (
        lambda F, r: np.convolve(F, np.full(21, 1 / 21), mode="same"),
        "recording",
        "a mean over 21 samples",
    ),
    "two machines": (
        lambda F, r: F * np.where(np.arange(F.size) < 0.6 * F.size, 1.0, 1.5),
        "poor_fit",
        "parameters change",
    ),
    "sign": (lambda F, r: -F, "not_physical", "the sign of F or of a position is wrong"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_the_force_is_named(fault: str) -> None:
    damage, status, words = FAULTS[fault]
    found = identified(F=damage(rigid()["F"], np.random.default_rng(1)))
    assert found.status != "ok"
    assert status in (None, found.status), found.message
    assert words in found.message


def test_jumps_of_friction_are_no_noise_of_the_force() -> None:
    case = draw_case(np.random.default_rng([90421, 72, 0]))
    log = Log.from_arrays(case.signals, sampling_period=1 / case.rate)
    found = identify(load_generated(case.axis, case.measured), log, preparation=Preparation(cutoff_hz=30.0))
    assert found.physical_parameters["Ms"] == pytest.approx(case.truth["Ms"], rel=0.02)


def test_a_force_that_is_updated_rarely_is_a_cause_of_what_it_spoils() -> None:
    case = draw_case(np.random.default_rng([31007, 18, 1]))
    Fm = case.signals["Fm"]
    signals = {**case.signals, "Fm": np.repeat(Fm[::16], 16)[: Fm.size]}
    log = Log.from_arrays(signals, sampling_period=1 / case.rate)
    found = identify(load_generated("direct_2m1s", ("q2",)), log)
    assert found.status == "poor_fit"
    assert "Fm changes every 16 samples only" in found.message


def test_a_lag_that_imitates_a_damped_mode_is_named() -> None:
    case = draw_case(np.random.default_rng([3, 18]), "direct_2m1s")
    a = np.exp(-case.mode_hz / case.rate)
    signals = {**case.signals, case.force: scipy.signal.lfilter([1 - a], [1, -a], case.signals[case.force])}
    for chosen, is_named in ((case.signals, False), (signals, True)):
        log = Log.from_arrays(chosen, sampling_period=1 / case.rate)
        found = identify(load_generated(case.axis, case.measured), log)
        is_stated = f"{case.force} lags with a time constant" in found.message
        assert (is_stated, found.status == "ok") == (is_named, not is_named), found.message


def test_a_soft_limit_of_a_force_that_is_faster_than_the_cutoff_is_named() -> None:
    case = draw_case(np.random.default_rng([771, 24, 77]))
    F = case.signals["Fm"]
    level = 1.1 * np.max(np.abs(F))
    for recorded, is_named in ((F, False), (level * np.tanh(F / level), True)):
        log = Log.from_arrays({**case.signals, "Fm": recorded}, sampling_period=1 / case.rate)
        found = identify(load_generated("ballscrew_2m1s", ("qm",)), log)
        is_stated = "where Fm is large it is less than proportional" in found.message
        assert (is_stated, found.status == "ok") == (is_named, not is_named), found.message


def test_signals_that_are_averaged_alike_are_no_fault() -> None:
    same = {name: np.convolve(x, np.full(9, 1 / 9), mode="same") for name, x in rigid().items()}
    assert "a mean" not in identified(**same).message
    assert "F is a mean over 9" in identified(F=same["F"]).message


def test_a_drifting_clock_is_named() -> None:
    F = rigid()["F"]
    log = Log.from_arrays(
        {**rigid(), "F": np.interp(np.arange(F.size) * 1.004, np.arange(F.size), F)}, sampling_period=1 / RATE
    )
    assert identify(load_generated("rigid_1m"), log).status != "ok"
    found = identify(load_generated("rigid_1m"), log, preparation=Preparation(cutoff_hz=30.0))
    assert "its clock runs at another rate" in found.message


def flexible(unit: float = 1.0, late: int = 0) -> Log:
    """The axis direct_2m1s, its structure's response to sines in closed form, with both accelerometers."""
    Ms, Fvs, Ks, Mm, Fvm, Fsm = 900.0, 3000.0, 5e6, 300.0, 500.0, 60.0
    rate = 2000.0
    t = np.arange(16_000) / rate
    q1, q2 = np.zeros((3, t.size)), np.zeros((3, t.size))
    for k, f in enumerate((0.7, 1.9, 4.3, 8.1, 13.7, 19.0)):
        w = 2 * np.pi * f
        amplitude = 0.02 / f
        answer = Mm * w**2 / (Ks + 1j * w * Fvs - (Ms + Mm) * w**2)
        for order in range(3):
            wave = (1j * w) ** order * amplitude * np.exp(1j * (w * t + k))
            q2[order] += wave.real
            q1[order] += (answer * wave).real
    draw = np.random.default_rng(2)
    F = Mm * (q1[2] + q2[2]) + Fvm * q2[1] + Fsm * np.sign(q2[1])
    noisy = {
        name: x + 1e-4 * x.std() * draw.standard_normal(t.size) for name, x in (("ddq1", q1[2]), ("Fm", F))
    }
    signals = {"q2": q2[0] + 1e-9 * draw.standard_normal(t.size), **noisy, "ddq2": q2[2] * unit}
    signals["ddq1"] = shifted(signals["ddq1"], late)
    return Log.from_arrays(signals, sampling_period=1 / rate)


def test_friction_beside_the_drive_is_differentiated_with_it() -> None:
    """The paper takes derivatives of friction as zero, which biases what is differentiated."""
    model = load_generated("direct_2m1s", ("q2",))
    assert model.coulomb_at_drive == ((0, 3),)
    right, paper = (
        identify(model, flexible(), preparation=Preparation(coulomb=coulomb), examine=False)
        for coulomb in (None, ())
    )
    errors = [abs(found.physical_parameters["Ms"] / 900.0 - 1) for found in (right, paper)]
    assert errors[0] < 0.01
    assert errors[1] > 3 * errors[0]


@pytest.mark.parametrize(
    ("log", "words"),
    [(flexible(unit=1 / 9.81), "times the reading of other sensors"), (flexible(late=30), "ddq1 acts as if")],
)
def test_sensors_are_compared(log: Log, words: str) -> None:
    model = load_generated("direct_2m1s", ("q2", "ddq1", "ddq2"))
    assert identify(model, flexible()).status == "ok"
    found = identify(model, log)
    assert found.status in ("recording", "timing", "not_physical")
    assert words in found.message


def test_what_a_log_does_not_determine_is_named() -> None:
    q, v, a = motion(jerky=False)
    draw = np.random.default_rng(3)
    F = 1e-3 * a + 200.0 * v + 20.0 * np.sign(v) + 5.0 * draw.standard_normal(q.size)
    found = identified(q=q + 1e-6 * draw.standard_normal(q.size), F=F)
    assert found.status == "undetermined"
    assert "M (" in found.message


def test_printed_deviations_hold_the_bias_and_the_scatter() -> None:
    found = identified()
    assert found.bias is not None
    assert found.scatter is not None
    assert np.all(found.standard_deviations >= np.abs(found.bias.total))
    assert np.all(found.standard_deviations >= np.sqrt(np.diag(found.scatter)))
    assert np.all(found.standard_deviations >= found.sampling_deviations)


@pytest.mark.parametrize("order", [2, 4, 6, 10, 14])
def test_differences_of_an_order_are_exact_on_polynomials_and_have_their_gain(order: int) -> None:
    t = np.linspace(-1.0, 1.0, 81)
    slope = central_difference(t**order, t[1] - t[0], order=order)
    inner = slice(order // 2, -(order // 2))
    assert slope[inner] == pytest.approx(order * t[inner] ** (order - 1), abs=1e-10)
    w, period = 2 * np.pi * 60.0, 1e-3
    wave = derivatives(np.sin(w * period * np.arange(400)), period, 1, accuracy=order)[0][200]
    expected = w * np.cos(w * period * 200) * central_difference_gain(60.0, period, order=order)
    assert wave == pytest.approx(expected, abs=1e-9 * w)


@pytest.mark.parametrize(("number", "axis"), [(22, "direct_2m1s"), (47, "ballscrew_2m1s")])
def test_a_log_of_few_samples_is_estimated_at_a_cutoff_that_determines_it(number: int, axis: str) -> None:
    case = draw_case(np.random.default_rng([911, number, False]))
    assert (case.axis, case.rate <= 500) == (axis, True)
    model = load_generated(case.axis, case.measured)
    log = Log.from_arrays(case.signals, sampling_period=1 / case.rate)
    chosen = identify(model, log)
    first = completed(Preparation(), log, model).cutoff_hz
    assert chosen.status == "ok", chosen.message
    assert greatest_error(chosen, case) < 0.1
    at_first = identify(model, log, preparation=Preparation(cutoff_hz=first))
    assert greatest_error(at_first, case) > 1.5 * greatest_error(chosen, case)


def greatest_error(found: Identification, case: Case) -> float:
    return max(abs(found.physical_parameters[name] / true - 1) for name, true in case.truth.items())


@pytest.mark.parametrize("name", ["q", "F"])
def test_held_spans_in_motion_are_named(name: str) -> None:
    x = rigid()[name].copy()
    for start in range(500, x.size - 600, 400):
        x[start : start + 30] = x[start]
    assert f"{name} keeps exactly one value over" in identified(**{name: x}).message


@pytest.mark.parametrize("is_driven", [True, False])
def test_an_acceleration_may_jump_for_a_sample_where_the_force_does(is_driven: bool) -> None:
    rng = np.random.default_rng(20261127)
    case = draw_machine("direct_2m1s", ("q2", "ddq1", "ddq2"), rng)
    sizes = {name: 2e-8 if name == "q2" else 1e-3 * np.std(x) for name, x in case.signals.items()}
    logged = {name: x + sizes[name] * rng.standard_normal(x.size) for name, x in case.signals.items()}
    at, pulse = np.arange(1, 6) * logged["Fm"].size // 7, 0.5 * np.ptp(logged["Fm"])
    logged["ddq1"][at] -= pulse / case.truth["Ms"]
    logged["ddq2"][at] += pulse * (1 / case.truth["Mm"] + 1 / case.truth["Ms"])
    logged["Fm"][at] += pulse if is_driven else 0.0
    found = identify("direct_2m1s", Log.from_arrays(logged, sampling_period=1 / case.rate))
    assert ("ddq1 jumps by" in found.message) == (not is_driven)
    assert (found.status == "ok") == is_driven
