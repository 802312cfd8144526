"""Friction that reverses before the velocity, as where a motor sticks, widens the deviations."""

import numpy as np

from symid import Log
from symid.codegen import load_generated
from symid.identification import identify_by_least_squares

TRUE = {"Ms": 80.0, "Fvs": 400.0, "Ks": 4.4e5, "Mm": 27.0, "Fvm": 13.0, "Fsm": 24.0}
RATE = 1000.0


def log(earlier: float, offset: float = 0.0) -> Log:
    """A motor on a structure in steady motion of several tones; its friction reverses `earlier` than it, in s."""
    t = np.arange(12000) / RATE
    rng = np.random.default_rng(3)
    s = 2j * np.pi * np.array([0.6, 1.7, 2.9, 4.3, 6.1, 8.7, 11.3, 14.1])
    drive = rng.uniform(20.0, 40.0, s.size) * np.exp(2j * np.pi * rng.uniform(size=s.size))
    # Mm s^2 (q1 + q2) + Fvm s q2 = drive; (Ms s^2 + Fvs s + Ks) q1 = -Mm s^2 (q1 + q2)
    structure = (TRUE["Ms"] + TRUE["Mm"]) * s**2 + TRUE["Fvs"] * s + TRUE["Ks"]
    share = -TRUE["Mm"] * s**2 / structure  # q1 over q2
    q2 = drive / (TRUE["Mm"] * s**2 * (1 + share) + TRUE["Fvm"] * s)
    tones = np.exp(np.outer(t, s))
    turned = np.exp(s * earlier)
    friction = TRUE["Fsm"] * np.sign(np.real(tones @ (turned * s * q2)))
    signals = {
        "q2": np.real(tones @ q2),
        "ddq2": np.real(tones @ (s**2 * q2)),
        "Fm": np.real(tones @ drive) + friction + offset + 0.02 * rng.standard_normal(t.size),
    }
    return Log.from_arrays(signals, sampling_period=1 / RATE)


def test_the_residual_shows_friction_that_turns_before_the_motion():
    model = load_generated("direct_2m1s", ("q2", "ddq2"))
    for earlier in (0.0, 0.004):
        found = identify_by_least_squares(model, log(earlier, offset=1.3))
        off = [abs(found.physical_parameters[name] - true) for name, true in TRUE.items()]
        seen = [one.effect for one in found.discrepancies]
        assert found.status == "ok"
        assert ("friction that turns at another moment" in seen) == bool(earlier)
        assert np.all(off < 2 * found.physical_deviations)
