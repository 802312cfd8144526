"""Records against known signals; responses, columns and effects against hand derivations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hand_made import RIGID, rigid_log

from symid import (
    Backlash,
    Log,
    PositionDependentFriction,
    PositionDependentViscousFriction,
    QuadraticDrag,
    StribeckFriction,
    ViscousFriction,
    load_axis,
)
from symid.diagnosis.effects import ActuatorLagEffect, EncoderRippleEffect, Placed, effects_of
from symid.diagnosis.effects.flexible_mode import FlexibleModeEffect
from symid.diagnosis.effects.load_dependent_friction import LoadDependentFrictionEffect
from symid.diagnosis.effects.presliding_friction import dahl_state
from symid.diagnosis.fitting.sensitivity import parameter_columns, prediction_jacobian
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import training_and_held_out
from symid.diagnosis.prediction.prediction import prediction_of
from symid.diagnosis.prediction.record import Record, record_of
from symid.diagnosis.prediction.response import axis_response
from symid.errors import LogError
from symid.estimation.autoregression import autoregression
from symid.simulation import forward_dynamics

PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
SCREW = {"Mm": 120.0, "Fvm": 90.0, "Fsm": 50.0, "Kt": 8e6, "Ft": 700.0, "Ml": 200.0, "Fvl": 110.0}


def record(axis: str, **signals: np.ndarray) -> Record:
    log = Log("by hand", 0.0, 1e-3, signals)
    return record_of(forward_dynamics(load_axis(axis)), log, 40.0)


def waves(seconds: float = 4.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, a smooth motion with several reversals, and another smooth signal."""
    t = np.arange(round(1000 * seconds)) / 1000
    return t, 0.05 * np.sin(7 * t) + 0.002 * np.sin(40 * t), 30 * np.cos(11 * t)


def rigid_record() -> Record:
    _, q, F = waves()
    return record("rigid_1m", q=q, F=F)


def inner(one: Record, times: np.ndarray) -> np.ndarray:
    """Points away from the ends of the log."""
    return (times > 0.2) & (times < one.duration - 0.2)


def test_rows_of_a_sine_are_the_sine_and_its_derivative() -> None:
    t = np.arange(4000) / 1000
    one = record("rigid_1m", q=0.1 * np.sin(9 * t), F=30 * np.cos(9 * t))
    at, rows = one.row_time, inner(one, one.row_time)
    assert np.abs(one.rows(one.motion) - 0.1 * np.sin(9 * at))[rows].max() < 1e-5
    assert np.abs(one.rows(1j * one.omega * one.motion) - 0.9 * np.cos(9 * at))[rows].max() < 1e-3
    assert np.abs(one.rows(one.measured[0] * one.taper) - 30 * np.cos(9 * at))[rows].max() < 0.3
    fine = one.fine(one.motion)
    assert np.abs(fine - 0.1 * np.sin(9 * one.fine_time))[inner(one, one.fine_time)].max() < 1e-5


def test_a_late_signal_is_put_back() -> None:
    t = np.arange(4000) / 1000
    one = record("rigid_1m", q=0.1 * np.sin(9 * t), F=30 * np.cos(9 * (t - 0.004)))
    put_back = replace(one, late={"F": 0.004})
    at, rows = one.row_time, inner(one, one.row_time)
    assert np.abs(put_back.rows(put_back.measured[0]) - 30 * np.cos(9 * at))[rows].max() < 0.1
    assert np.abs(one.rows(one.measured[0]) - 30 * np.cos(9 * at))[rows].max() > 0.9


def test_noise_levels_are_those_of_the_noise() -> None:
    rng, (t, q, F) = np.random.default_rng(0), waves(20.0)
    noisy = record(
        "rigid_1m", q=q + 3e-6 * rng.standard_normal(t.size), F=F + 0.7 * rng.standard_normal(t.size)
    )
    assert noisy.noise == pytest.approx([3e-6, 0.7], rel=0.15)


def test_back_and_forth_between_the_grids() -> None:
    one = rigid_record()
    for there, back in ((one.rows, one.from_grid), (one.fine, one.from_grid)):
        assert np.allclose(back(there(one.motion)), one.motion, atol=1e-9 * np.abs(one.motion).max())


def test_logs_that_cannot_be_diagnosed() -> None:
    dynamics = forward_dynamics(load_axis("direct_2m1s"))
    _, q, F = waves()
    with pytest.raises(LogError, match="no position"):
        record_of(dynamics, Log("x", 0.0, 1e-3, {"Fm": F, "ddq1": q}))
    with pytest.raises(LogError, match="at least 100"):
        record_of(dynamics, Log("x", 0.0, 1e-3, {"Fm": F[:90], "q2": q[:90]}))


def test_three_seconds_at_50_hz_are_a_record() -> None:
    t = np.arange(150) / 50
    log = Log("slow", 0.0, 0.02, {"q": 0.1 * np.sin(3 * t) + 0.01 * np.sin(20 * t), "F": np.cos(3 * t)})
    _, weighting = first_state(record_of(forward_dynamics(load_axis("rigid_1m")), log), RIGID)
    assert weighting.kept.sum() > 60


def test_the_band_ends_where_noise_would_hide_the_velocity() -> None:
    rng, t = np.random.default_rng(5), np.arange(350) / 430
    noisy = {
        "q": 4.0 * np.clip(t - 0.05, 0, 0.6) + 8e-3 * rng.standard_normal(t.size),
        "F": 1 + rng.standard_normal(t.size),
    }
    dynamics, log = forward_dynamics(load_axis("rigid_1m")), Log("coarse", 0.0, 1 / 430, noisy)
    found = record_of(dynamics, log)
    assert record_of(dynamics, log, 2 * found.motion_hz).is_drowned
    assert not found.is_drowned


def test_response_is_the_rational_function_of_the_paper() -> None:
    """Eq. [14] with the parameters of [16] on s: Fm (1 + X2 s + X1 s^2) = (X3 s + X5 s^2 + X6 s^3 + X7 s^4) q2."""
    _, q, F = waves()
    one = record("direct_2m1s", q2=q, Fm=F)
    Ms, Fvs, Ks, Mm, Fvm, _ = PAPER.values()
    X1, X2, X3, X7 = (Mm + Ms) / Ks, Fvs / Ks, Fvm, Ms * Mm / Ks
    X5, X6 = Mm + Fvm * Fvs / Ks, (Mm * Fvm + Mm * Fvs + Ms * Fvm) / Ks
    s = 1j * one.omega
    found = axis_response(one, PAPER)
    expected = (X3 * s + X5 * s**2 + X6 * s**3 + X7 * s**4) / (1 + X2 * s + X1 * s**2)
    assert np.allclose(found.of_positions[0, 0], expected, rtol=1e-9)
    on_structure = Mm * s**2 / ((Ms + Mm) * s**2 + Fvs * s + Ks)
    structure = np.eye(2)[found.plant.bodies.index("structure")]
    assert np.allclose(found.of_force(structure)[0], on_structure, rtol=1e-9)


def test_response_of_a_ball_screw_with_both_encoders() -> None:
    _, q, F = waves()
    one = record("ballscrew_2m1s", qm=q, ql=q, Fm=F)
    Mm, Fvm, _, Kt, Ft, Ml, Fvl = SCREW.values()
    s, joint = 1j * one.omega, Ft * 1j * one.omega + Kt
    load = joint / (Ml * s**2 + Fvl * s + joint)
    found = axis_response(one, SCREW).of_positions[0]
    assert np.allclose(found[1], load, rtol=1e-9)
    assert np.allclose(found[0], Mm * s**2 + Fvm * s + joint * (1 - load), rtol=1e-7)


@pytest.mark.parametrize(("axis", "values"), [("direct_2m1s", PAPER), ("ballscrew_2m1s", SCREW)])
def test_columns_are_finite_differences_of_the_prediction(axis: str, values: dict[str, float]) -> None:
    _, q, F = waves()
    names = {"direct_2m1s": ("Fm", "q2"), "ballscrew_2m1s": ("Fm", "qm")}[axis]
    prediction = prediction_of(record(axis, **dict(zip(names, (F, q), strict=True))), values)
    for name, column in zip(values, parameter_columns(prediction), strict=True):
        step = 1e-4 * values[name]
        up, down = (
            prediction_of(prediction.record, values | {name: values[name] + x}).outputs for x in (step, -step)
        )
        difference = (up - down) / (2 * step)
        assert np.abs(column - difference).max() < 5e-3 * np.abs(difference).max(), name


@pytest.mark.parametrize(
    ("effect", "shape", "force"),
    [
        (effects_of(ViscousFriction)[0], (), lambda q, v, F: v),
        (effects_of(QuadraticDrag)[0], (), lambda q, v, F: v * np.abs(v)),
        (effects_of(StribeckFriction)[0], (0.3,), lambda q, v, F: np.sign(v) * np.exp(-((v / 0.3) ** 2))),
        (effects_of(PositionDependentFriction)[0], (), lambda q, v, F: np.sign(v) * q),
        (effects_of(PositionDependentViscousFriction)[1], (), lambda q, v, F: np.sign(v) * q),
        (effects_of(PositionDependentViscousFriction)[0], (), lambda q, v, F: v * q),
    ],
)
def test_forces_of_effects(effect, shape, force) -> None:
    """Motion in one direction, so that no jump spreads over the band: q = 0.2 t + 0.005 sin(9 t)."""
    t = np.arange(4000) / 1000
    one = record("rigid_1m", q=0.2 * t + 0.005 * np.sin(9 * t), F=60 + 20 * np.cos(9 * t))
    prediction = prediction_of(one, RIGID)
    joint = prediction.joints["motor"]
    at = one.fine_time
    q, v, F = 0.2 * at + 0.005 * np.sin(9 * at), 0.2 + 0.045 * np.cos(9 * at), 60 + 20 * np.cos(9 * at)
    rows, logged = inner(one, at), at < one.duration
    found = one.fine(effect.forces(prediction, joint, shape)[0])[rows]
    expected = np.full(at.size, np.nan)
    expected[logged] = force(q[logged], v[logged], F[logged])
    assert np.abs(found - expected[rows]).max() < 0.01 * np.abs(expected[rows]).max()


def test_the_load_of_friction_is_that_of_the_model_and_not_the_record() -> None:
    """A record of the drive that is no answer to the motion changes nothing."""
    t = np.arange(4000) / 1000
    q = 0.2 * t + 0.005 * np.sin(9 * t)
    found = []
    for logged in (60 + 20 * np.cos(9 * t), np.zeros(t.size)):
        prediction = prediction_of(record("rigid_1m", q=q, F=logged), RIGID)
        found.append(LoadDependentFrictionEffect().forces(prediction, prediction.joints["motor"], ()))
    assert np.abs(found[0]).max() > 0
    assert np.abs(found[0] - found[1]).max() < 1e-4 * np.abs(found[0]).max()


def test_a_mode_is_a_mass_hung_on_a_spring() -> None:
    m, k, c = 30.0, 2e5, 400.0
    w = np.sqrt(k / m)
    s = 1j * np.linspace(1, 400, 50)
    added = FlexibleModeEffect().stiffness(s.imag, (w / (2 * np.pi), c / (2 * m * w)))
    carried = (c * s + k) * m * s**2 / (m * s**2 + c * s + k)
    assert np.allclose(m * added, carried - m * s**2)


def test_backlash_takes_the_force_away_inside_the_gap() -> None:
    _, q, F = waves()
    prediction = prediction_of(record("ballscrew_2m1s", qm=q, Fm=F), SCREW)
    joint = prediction.springs["transmission"]
    force = prediction.record.fine(effects_of(Backlash)[0].forces(prediction, joint, (joint.stroke / 4,))[0])
    rows, half = inner(prediction.record, prediction.record.fine_time), joint.stroke / 8
    left = joint.q + force
    assert np.abs(left[rows & (np.abs(joint.q) < 0.7 * half)]).max() < 0.05 * half
    far = rows & (joint.q > 1.5 * half)
    assert np.allclose(left[far], joint.q[far] - half, atol=0.05 * half)


def test_dahl_state_is_an_exponential_between_reversals() -> None:
    reach = 0.3
    q = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0.2, 40)[1:]])
    state = dahl_state(q, reach)
    top = 1 - np.exp(-1 / reach)
    assert np.allclose(state[:50], 1 - np.exp(-q[:50] / reach))
    assert np.allclose(state[50:], (1 + top) * np.exp(-(1 - q[50:]) / reach) - 1)


def test_derivatives_by_amplitude_and_shape_are_finite_differences() -> None:
    state, _ = first_state(record_of(forward_dynamics(load_axis("rigid_1m")), rigid_log(seconds=4.0)), RIGID)
    placed = Placed(effects_of(StribeckFriction)[0], "motor", (0.05,), (20.0,))
    columns = prediction_jacobian(replace(state, placed=(placed,)))[-2:]
    for column, low, high, step in (
        (columns[0], replace(placed, amplitudes=(19.0,)), replace(placed, amplitudes=(21.0,)), 2.0),
        (columns[1], replace(placed, shape=(0.0499,)), replace(placed, shape=(0.0501,)), 0.0002),
    ):
        difference = (high.change(state.prediction) - low.change(state.prediction)) / step
        assert np.abs(column - difference).max() < 2e-3 * np.abs(difference).max()


def test_a_lag_passes_on_the_ripple_of_the_encoder() -> None:
    state, weighting = first_state(rigid_record(), {"M": 20.0, "Fv": 15.0, "Fs": 20.0})
    lag = Placed(ActuatorLagEffect(), "actuator", (), (0.002,))
    ripple = Placed(EncoderRippleEffect(), "q", (0.01,), (1e-7, 2e-7))
    omega = state.prediction.record.omega

    def outputs(*placed: Placed) -> np.ndarray:
        return state.prediction.record.measured - with_effects(state, weighting, placed).errors

    assert np.allclose(outputs(lag, ripple), (1 + 0.002j * omega) * outputs(ripple))
    columns = prediction_jacobian(with_effects(state, weighting, (lag, ripple)))
    for at, (moved, step) in enumerate(
        [
            ((replace(lag, amplitudes=(0.0021,)), ripple), 1e-4),
            ((lag, replace(ripple, amplitudes=(1.1e-7, 2e-7))), 1e-8),
            ((lag, replace(ripple, amplitudes=(1e-7, 2.1e-7))), 1e-8),
        ]
    ):
        by_difference = (outputs(*moved) - outputs(lag, ripple)) / step
        tolerance = 0.01 if at else 1e-6  # derivatives by the ripple leave out its slope
        assert np.allclose(columns[3 + at], by_difference, atol=tolerance * np.abs(by_difference).max())


def test_a_motion_in_a_part_of_the_log_is_parted_where_it_moves() -> None:
    t = np.arange(5000) / 1000
    q = 0.05 * np.where((t > 3) & (t < 4), 1 - np.cos(2 * np.pi * 3 * (t - 3)), 0.0)
    one = record_of(forward_dynamics(load_axis("rigid_1m")), Log("at rest", 0.0, 1e-3, {"q": q, "F": q}))
    moving = one.moves(one.speeds[0])
    for part in training_and_held_out(one):
        assert np.sum(part & moving) > 0.25 * np.sum(moving)


def test_rows_of_short_strokes_count_in_the_models_of_errors() -> None:
    # One long stroke and many short ones: with a past of six rows only the long one would be left.
    kept = np.ones(160, dtype=bool)
    kept[40::6] = False
    rows = np.random.default_rng(0).standard_normal((1, 160))
    assert autoregression(rows, kept, 6).usable[40:].sum() > 0.5 * kept[40:].sum()


def test_errors_of_short_stretches_have_an_autoregressive_model() -> None:
    rows = np.random.default_rng(0).standard_normal((1, 40))
    kept = np.arange(40) % 8 < 7  # no row has more than six before it
    found = autoregression(rows, kept, 6)
    assert found.coefficients.shape[1] < 6
    assert 0.5 < found.apply(rows).std() < 2.0
