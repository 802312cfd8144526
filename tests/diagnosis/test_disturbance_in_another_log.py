"""A disturbance whose frequency is that of another log's motion is the one found where it has its amplitude there."""

import numpy as np
import pytest

from symid import Log, diagnose

NOMINAL = {"M": 100.0, "Fv": 150.0, "Fs": 20.0}


def log(seed: int, hertz: list[float], force: float) -> Log:
    """A body that sways at given frequencies under a constant force and a periodic one of 0.9 Hz."""
    t, rates = 1e-3 * np.arange(7000), 2 * np.pi * np.array(hertz)
    angles, speeds = np.outer(rates, t) + np.arange(rates.size)[:, None], 0.4 / np.sqrt(rates)
    v, a, q = speeds @ np.sin(angles), (speeds * rates) @ np.cos(angles), -(speeds / rates) @ np.cos(angles)
    drive = 100.0 * a + 150.0 * v + 20.0 * np.sign(v) + force * np.sin(1.8 * np.pi * t + seed) + 30.0
    noise = np.random.default_rng(seed).standard_normal((2, t.size))
    return Log.from_arrays({"q": q + 1e-7 * noise[0], "F": drive + noise[1]}, sampling_period=1e-3)


@pytest.mark.parametrize(("force", "holds"), [(40.0, True), (5.0, False)])
def test_a_disturbance_holds_where_it_has_its_amplitude(force: float, holds: bool) -> None:
    """It was dropped, whatever its amplitude, as the motion of the other log has a line there."""
    first, second = log(1, [0.37, 0.55, 1.7, 2.9], 40.0), log(2, [0.45, 0.9, 2.3], force)
    found = diagnose("rigid_1m", first, validation=second, nominal=NOMINAL)
    named = {own.effect for own in found.effects}
    assert ("periodic_disturbance" in named, "offset_force" in named) == (holds, True)
