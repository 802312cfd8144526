"""Blocks of samples behind an imperfect drive are what single samples make, recorded force included."""

import numpy as np
import pytest
from driven import called

from symid import ActuatorDelay, ActuatorLag, ForceLimit, GainAsymmetry, GainNonlinearity, load_axis
from symid.axis import DriveImperfection
from symid.simulation import Controller, Replay, chirp, plant_of, simulate, tuned_cascade

PERIOD = 1 / 2000
VALUES = {"M": 5.0, "Fv": 3.0, "Fs": 2.0}
AXIS = load_axis("rigid_1m")
CASCADE = tuned_cascade(plant_of(AXIS, VALUES), "q", 10.0)
FORCES = 3.0 * np.sin(np.arange(4000) / 90.0)


DRIVES = {
    "lag": (ActuatorLag(2e-3),),
    "delay": (ActuatorDelay(1.3e-3),),
    "both": (ActuatorLag(1e-3), ActuatorDelay(1e-3)),
    "limit": (ForceLimit(20.0),),
    "gain": (GainNonlinearity(0.003, power=2),),
    "all": (ActuatorDelay(1e-3), ActuatorLag(1e-3), ForceLimit(20.0), GainAsymmetry(0.1)),
}


@pytest.mark.parametrize("controller", [CASCADE, Replay(FORCES, CASCADE)])
@pytest.mark.parametrize("name", DRIVES)
def test_blocks_are_what_single_samples_make(name: str, controller: Controller) -> None:
    drive: tuple[DriveImperfection, ...] = DRIVES[name]
    path = chirp(0.5, 8.0, 2.0, 0.01, sampling_period=PERIOD, quantity="position")
    axis = AXIS.with_effect(*drive)
    blocks, singly = (simulate(axis, VALUES, path, one) for one in (controller, called(controller)))
    for signal in ("q", "F"):
        scale = np.abs(singly.log[signal]).max()
        np.testing.assert_allclose(blocks.log[signal], singly.log[signal], atol=1e-9 * scale)
    np.testing.assert_allclose(blocks.forces, singly.forces, atol=1e-9 * np.abs(singly.forces).max())
    assert np.abs(blocks.forces - blocks.log["F"]).max() > 0.1  # the drive does something
