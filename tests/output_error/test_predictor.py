"""The stationary predictor against scipy's Riccati equation and a Kalman filter run until it settles."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from symid import load_axis
from symid.output_error.predictor import predictor
from symid.output_error.sampled_plant import SampledPlant, sampled_plant
from symid.simulation import plant_of

DIRECT = {"Ms": 40.0, "Fvs": 30.0, "Ks": 9e4, "Mm": 6.0, "Fvm": 5.0, "Fsm": 2.0}
SETS = [("q2",), ("q2", "ddq1"), ("q2", "ddq1", "ddq2")]
FORCE, READING = np.array([2.0, 0.5, 0.3]), np.array([1e-5, 0.02, 0.05])


def sampled(signals: tuple[str, ...]) -> SampledPlant:
    return sampled_plant(
        plant_of(load_axis("direct_2m1s"), DIRECT), signals, 0.01, parts=1, disturbed=signals[1:]
    )


def covariances(plant: SampledPlant, force: np.ndarray, reading: np.ndarray) -> list[np.ndarray]:
    """Q, R and S of the noise: the drive's has the opposite sign, because the log's force holds it too."""
    into = np.column_stack([-plant.effects[:, :, 0].sum(axis=0), plant.disturbances]) * force
    onto = np.column_stack([-plant.feedthrough[:, 0], plant.disturbance_feedthrough]) * force
    return [into @ into.T, onto @ onto.T + np.diag(reading**2), into @ onto.T]


def settled(plant: SampledPlant, force: np.ndarray, reading: np.ndarray, steps: int) -> list[np.ndarray]:
    """Gain and covariance of the innovations of a Kalman filter after some steps from a vague start."""
    A, C = plant.transition, plant.output
    Q, R, S = covariances(plant, force, reading)
    P = np.diag([1.0, 1.0, 100.0, 100.0])[: len(A), : len(A)]
    for _ in range(steps):
        F = C @ P @ C.T + R
        K = np.linalg.solve(F, (A @ P @ C.T + S).T).T
        P = A @ P @ A.T + Q - K @ F @ K.T
        P = (P + P.T) / 2
    return [K, F]


@pytest.mark.parametrize("signals", SETS)
def test_the_predictor_is_that_of_the_riccati_equation(signals: tuple[str, ...]) -> None:
    plant, p = sampled(signals), len(signals)
    force, reading = FORCE[:p], READING[:p]
    Q, R, S = covariances(plant, force, reading)
    scale = np.array([1e-4, 1e-4, 1e-2, 1e-2])
    A, C = plant.transition / scale[:, None] * scale, plant.output * scale / reading[:, None]
    P = solve_discrete_are(
        A.T, C.T, Q / np.outer(scale, scale), R / np.outer(reading, reading), s=S / np.outer(scale, reading)
    ) * np.outer(scale, scale)
    F = plant.output @ P @ plant.output.T + R
    K = (plant.transition @ P @ plant.output.T + S) @ np.linalg.inv(F)
    found = predictor(plant, force, reading)
    np.testing.assert_allclose(found.covariance, F, rtol=1e-6)
    np.testing.assert_allclose(found.innovations.B[:, :p], K, rtol=1e-5, atol=1e-8 * np.abs(K).max())


@pytest.mark.parametrize("signals", SETS)
def test_the_predictor_is_where_a_kalman_filter_settles(signals: tuple[str, ...]) -> None:
    plant, p = sampled(signals), len(signals)
    K, F = settled(plant, FORCE[:p], READING[:p], steps=4000)
    found = predictor(plant, FORCE[:p], READING[:p])
    np.testing.assert_allclose(found.covariance, F, rtol=1e-6)
    np.testing.assert_allclose(found.innovations.B[:, :p], K, rtol=1e-5, atol=1e-7 * np.abs(K).max())
    np.testing.assert_allclose(found.innovations.A, plant.transition - K @ plant.output, atol=1e-4)


@pytest.mark.parametrize(("force", "reading"), [(1e-6, 1.0), (1e6, 1.0), (1.0, 1e-6), (1.0, 1e3)])
def test_extreme_noise_leaves_the_predictor_stable(force: float, reading: float) -> None:
    for signals in SETS:
        p = len(signals)
        found = predictor(sampled(signals), force * FORCE[:p], reading * READING[:p])
        assert np.abs(np.linalg.eigvals(found.innovations.A)).max() < 1.0
        assert np.all(np.linalg.eigvalsh(found.covariance) > 0)


def test_the_gain_of_a_mass_is_that_of_the_alpha_beta_filter() -> None:
    """Kalata 1984: tracking index L = T^2 s_a / s_r; r, alpha and beta in closed form."""
    M, T, force, reading = 3.0, 0.1, 5.0, 0.01
    plant = sampled_plant(plant_of(load_axis("rigid_1m"), {"M": M, "Fv": 0.0, "Fs": 0.0}), ["q"], T, 1)
    index = T**2 * force / M / reading
    r = (4 + index - np.sqrt(8 * index + index**2)) / 4
    alpha, beta = 1 - r**2, 2 * (2 - (1 - r**2)) - 4 * r
    found = predictor(plant, np.array([force]), np.array([reading]))
    np.testing.assert_allclose(found.innovations.B[:, 0], [alpha + beta, beta / T], rtol=1e-7)
    assert found.covariance.item() == pytest.approx(reading**2 / (1 - alpha), rel=1e-7)


def test_a_state_that_no_reading_shows_leaves_the_innovations_right() -> None:
    """The position of a motor beside an accelerometer of the structure alone."""
    plant = sampled(("ddq1",))
    found = predictor(plant, FORCE[:1], READING[:1])
    _, F = settled(plant, FORCE[:1], READING[:1], steps=10_000)
    np.testing.assert_allclose(found.covariance, F, rtol=1e-6)


@pytest.mark.parametrize("transition", [np.full((4, 4), np.nan), 2 * np.eye(4)])
def test_a_growing_state_that_is_not_read_has_no_predictor(transition: np.ndarray) -> None:
    unread = replace(sampled(("q2",)), transition=transition, output=np.zeros((1, 4)))
    with np.errstate(all="ignore"), pytest.raises(np.linalg.LinAlgError, match="no stationary predictor"):
        predictor(unread, FORCE[:1], READING[:1])
