"""A weakly damped mode that rings from before the log to beyond its end."""

import numpy as np
import pytest
from scipy.signal import lsim

from symid import Log, diagnose, load_axis
from symid.diagnosis import LIBRARY
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection import confirmation
from symid.diagnosis.selection.forward import forward_selection

PERIOD, INERTIA, MASS, STIFFNESS, DAMPING = 2e-3, 30.0, 12.0, 9000.0, 3.0
TIME = np.arange(0, 16, PERIOD)


def ringing_log(seed: int) -> Log:
    """A driven mass of 30 kg whose motion is given, with 12 kg on a spring, ringing at the start: 4.4 Hz, D 0.005."""
    rng = np.random.default_rng(seed)
    rates = 2 * np.pi * np.array([0.2, 0.37, 0.71, 1.3, 2.9])
    angles = np.outer(rates, TIME) + rng.uniform(0, 2 * np.pi, (5, 1))
    amplitudes = np.array([0.1, 0.1, 0.05, 0.02, 0.01])
    q, v = amplitudes @ np.sin(angles), (amplitudes * rates) @ np.cos(angles)
    a = -(amplitudes * rates**2) @ np.sin(angles)
    # Deflection d of the spring: MASS (d'' + a) + DAMPING d' + STIFFNESS d = 0
    matrix = np.array([[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]])
    system = (matrix, np.array([[0.0], [-1.0]]), np.array([[-STIFFNESS, -DAMPING]]), np.zeros((1, 1)))
    spring = lsim(system, a, TIME, X0=np.array([2e-3, 0.0]))[1]
    force = INERTIA * a + spring + 80.0 * v + 15.0 * np.sign(v)
    noise = np.array([[1e-6], [0.5]]) * rng.standard_normal((2, TIME.size))
    return Log("by hand", 0.0, PERIOD, {"q": q + noise[0], "F": force + noise[1]})


def test_a_mode_that_rings_is_found_with_its_values() -> None:
    found = diagnose(load_axis("rigid_1m"), ringing_log(4))
    assert (found.verdict, [effect.effect for effect in found.effects]) == ("effect", ["flexible_mode"])
    values = found.effects[0].parameters
    assert values["m"].value == pytest.approx(MASS, rel=0.03)
    assert values["f"].value == pytest.approx(np.sqrt(STIFFNESS / MASS) / (2 * np.pi), rel=0.01)
    assert values["D"].value == pytest.approx(DAMPING / (2 * np.sqrt(STIFFNESS * MASS)), rel=0.3)
    assert found.gap.explained.rms < 1.5 * found.gap.noise_floor.rms


def test_the_leading_candidate_is_fitted_until_its_error_hardly_falls(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    library = [effect for effect in LIBRARY if effect.name == "flexible_mode"]
    monkeypatch.setattr(confirmation, "_DIRECT", (0, 0, 0))
    axis = load_axis("rigid_1m")
    data = data_of(axis, (joined([ringing_log(4)]), None), Recording({}, True))
    plain = fitted_axis(*first_state(data.record, {"M": 40.0, "Fv": 80.0, "Fs": 15.0}))
    (step,) = forward_selection(plain, library)[:1]
    assert step.best.fit.mean_square < 0.02 * plain.mean_square
    assert step.best.placed.shape[0] == pytest.approx(np.sqrt(STIFFNESS / MASS) / (2 * np.pi), rel=0.01)
