"""Statuses of an identification, several logs, and round trips from exactly simulated flexible axes."""

import numpy as np
import pytest
from scipy import linalg

from symid import Log, Preparation, derive, identify, load_axis, load_generated, predict
from symid.errors import LogError, SettingError

RATE = 8000.0
DIRECT = {"Ms": 900.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 200.0, "Fvm": 150.0, "Fsm": 0.0}
BALLSCREW = {"Mm": 80.0, "Fvm": 120.0, "Fsm": 0.0, "Kt": 6e6, "Ft": 700.0, "Ml": 200.0, "Fvl": 150.0}


def multisine(seconds: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, frequencies (every 2 Hz up to 100 Hz) and complex amplitudes of a periodic force."""
    frequency = np.arange(2, 101, 2.0)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, frequency.size)
    return np.arange(int(seconds * RATE)) / RATE, frequency, 200.0 * np.exp(1j * phase)


def steady_state(
    M: list[list[float]], C: list[list[float]], K: list[list[float]], B: list[float], seed: int
) -> dict[str, np.ndarray]:
    """Absolute displacements and force of a linear axis in periodic motion, exact to rounding."""
    t, frequency, force = multisine(2.0, seed)
    total, motion = np.zeros(t.size), np.zeros((len(B), t.size))
    for f, amplitude in zip(frequency, force, strict=True):
        s = 2j * np.pi * f
        x = linalg.solve(np.array(M) * s**2 + np.array(C) * s + np.array(K), np.array(B) * amplitude)
        wave = np.exp(s * t)
        total += (amplitude * wave).real
        motion += (x[:, None] * wave).real
    return {"F": total, **{f"x{i}": row for i, row in enumerate(motion)}}


def direct_log(seed: int = 0, noise: float = 0.0) -> Log:
    p = DIRECT
    C = [[p["Fvs"] + p["Fvm"], -p["Fvm"]], [-p["Fvm"], p["Fvm"]]]
    run = steady_state([[p["Ms"], 0], [0, p["Mm"]]], C, [[p["Ks"], 0], [0, 0]], [-1.0, 1.0], seed)
    force = run["F"] + noise * np.random.default_rng(seed).standard_normal(run["F"].size)
    acceleration = np.gradient(np.gradient(run["x0"], 1 / RATE), 1 / RATE)
    return Log.from_arrays(
        {"q2": run["x1"] - run["x0"], "Fm": force, "ddq1": acceleration}, sampling_period=1 / RATE
    )


def ballscrew_log(seed: int = 0) -> Log:
    p = BALLSCREW
    C = [[p["Fvm"] + p["Ft"], -p["Ft"]], [-p["Ft"], p["Ft"] + p["Fvl"]]]
    K = [[p["Kt"], -p["Kt"]], [-p["Kt"], p["Kt"]]]
    run = steady_state([[p["Mm"], 0], [0, p["Ml"]]], C, K, [1.0, 0.0], seed)
    return Log.from_arrays({"qm": run["x0"], "ql": run["x1"], "Fm": run["F"]}, sampling_period=1 / RATE)


@pytest.mark.parametrize(
    ("axis", "measured", "log", "truth", "tolerance"),
    [
        ("direct_2m1s", ("q2",), direct_log(), DIRECT, 0.02),
        ("direct_2m1s", ("q2", "ddq1"), direct_log(), DIRECT, 0.02),
        ("ballscrew_2m1s", ("qm",), ballscrew_log(), BALLSCREW, 0.05),
        ("ballscrew_2m1s", ("qm", "ql"), ballscrew_log(), BALLSCREW, 0.02),
    ],
)
def test_flexible_axes_come_back_from_exact_signals(
    axis: str, measured: tuple[str, ...], log: Log, truth: dict[str, float], tolerance: float
) -> None:
    """What remains is the bias of central differences and of rows near standstill."""
    found = identify(
        load_generated(axis, measured), log, preparation=Preparation(cutoff_hz=150.0, standstill=0.0)
    )
    branches = [dict(zip(found.model.physical_units, e.parameters, strict=True)) for e in found.physical]
    names = [name for name, value in truth.items() if value and not name.startswith("F")]
    assert min(max(abs(branch[n] / truth[n] - 1) for n in names) for branch in branches) < tolerance


def test_several_logs_are_solved_jointly_with_a_weight_each() -> None:
    model = load_generated("direct_2m1s", ("q2", "ddq1"))
    preparation = Preparation(cutoff_hz=150.0, decimation=8, coulomb=())
    quiet, loud = direct_log(1, noise=0.5), direct_log(2, noise=20.0)
    joint = identify(model, [quiet, loud], preparation=preparation)
    alone = [identify(model, log, preparation=preparation) for log in (quiet, loud)]
    rows, right = [], []
    for single in alone:
        observation = single.observations[0]
        for j, weight in enumerate(single.fit.weights):
            used = observation.valid[j]
            rows.append(weight * observation.W[j][used])
            right.append(weight * observation.y[j][used])
    W = np.concatenate(rows)
    scale = np.linalg.norm(W, axis=0)
    expected = np.linalg.lstsq(W / scale, np.concatenate(right), rcond=None)[0] / scale
    assert joint.fit.parameters == pytest.approx(expected, rel=1e-6)
    assert joint.logs == ("arrays", "arrays")
    assert np.all(joint.fit.standard_deviations <= 1.01 * alone[0].fit.standard_deviations)


def test_prediction_of_a_log_with_its_own_zero() -> None:
    model, log = load_generated("motor_bench", ("qm", "ql")), ballscrew_log(3)
    first = Log.from_arrays({"qm": log["qm"], "ql": log["ql"], "iq": log["Fm"]}, sampling_period=1 / RATE)
    other = Log.from_arrays(
        {"qm": log["qm"], "ql": log["ql"] + 0.7, "iq": log["Fm"]}, sampling_period=1 / RATE
    )
    found = identify(model, first, preparation=Preparation(cutoff_hz=150.0))
    errors = predict(found, other).residuals
    assert errors[0].relative == pytest.approx(found.residuals[0].relative, rel=0.05)
    with pytest.raises(SettingError, match="each log"):
        identify(model, [first, other])


def test_motion_in_one_direction_is_named() -> None:
    t = np.arange(4000) / 1000
    q = 0.1 * t + 0.01 * np.sin(9 * t) / 9
    v, a = np.full_like(t, 0.1), np.zeros_like(t)
    rigid = load_generated("rigid_1m")
    log = Log.from_arrays(
        {"q": 0.1 * t, "F": 5 * a + 3 * v + 2.0 + 0.01 * np.sin(50 * t)}, sampling_period=1e-3
    )
    found = identify(rigid, log, preparation=Preparation(cutoff_hz=50.0))
    assert found.status in ("rank_deficient", "poorly_excited")
    assert "move at several speeds" in found.message
    assert not found.physical or found.status != "ok"
    assert q.size == t.size


def test_too_few_rows_is_a_status() -> None:
    log = direct_log()
    found = identify(
        load_generated("direct_2m1s"), log, preparation=Preparation(cutoff_hz=100.0, standstill=1e3)
    )
    assert found.status == "too_few_rows"
    assert "`standstill=0`" in found.message
    assert found.physical_parameters == {}


def test_slow_log_of_many_reversals_takes_a_higher_cutoff() -> None:
    """Ten samples between reversals: at the first cutoff, 5 % of the sampling frequency, none is left."""
    t = np.arange(800) / 40.0
    terms = list(zip((0.9, 1.4, 1.7, 1.9), (0.3, 1.0, 2.0, 4.0), (0.1, 0.1, 0.2, 0.2), strict=True))
    q, v, a = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    for hz, phase, size in terms:
        w = 2 * np.pi * hz
        q += size * np.sin(w * t + phase)
        v += size * w * np.cos(w * t + phase)
        a -= size * w**2 * np.sin(w * t + phase)
    log = Log.from_arrays({"q": q, "F": 3.0 * a + 8.0 * v + 20.0 * np.sign(v) + 5.0}, sampling_period=0.025)
    found = identify(load_generated("emps"), log)
    true = {"M": 3.0, "Fv": 8.0, "Fc": 20.0, "OF": 5.0}
    assert found.physical_parameters == pytest.approx(true, rel=0.1)


def test_a_structure_that_the_log_does_not_show_is_not_ok() -> None:
    """The axis has no load on the motor: no values of it are right."""
    log = direct_log(noise=1.0)
    found = identify(load_generated("direct_3m2s"), log, preparation=Preparation(cutoff_hz=150.0))
    assert found.status != "ok"


def test_a_derived_model_serves_as_well_as_a_generated_one() -> None:
    log, preparation = ballscrew_log(), Preparation(cutoff_hz=150.0)
    derived = derive(load_axis("ballscrew_2m1s"), ("qm", "ql"))
    generated = load_generated("ballscrew_2m1s", ("qm", "ql"))
    first, second = (identify(model, log, preparation=preparation) for model in (derived, generated))
    assert np.array_equal(first.fit.parameters, second.fit.parameters)
    assert "Fm = X1*(qm_d2)" in str(derived)
    assert "Kt: unique" in str(derived.parameter_map)


def test_a_log_without_a_signal_is_refused() -> None:
    with pytest.raises(LogError, match="q2"):
        identify(load_generated("direct_2m1s"), ballscrew_log())
    with pytest.raises(SettingError, match="no log"):
        identify(load_generated("direct_2m1s"), [])


def test_a_log_of_two_samples_is_refused_by_its_name() -> None:
    short = Log.from_arrays({"q": [0.0, 0.1], "F": [1.0, 2.0]}, sampling_period=1e-3, source="short")
    with pytest.raises(SettingError, match="short has 2 samples, an acceleration needs 3"):
        identify(load_generated("rigid_1m"), short)
