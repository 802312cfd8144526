"""Output error where no sensor sees the place of a free base: a satellite under its reaction wheel."""

import numpy as np
import pytest
import scipy

from symid import Axis, Body, Drive, Position, Spring, Velocity, ViscousFriction, identify
from symid.data import Log
from symid.identification import Preparation

TRUE = {"Jh": 4.0, "Jw": 0.02, "Fw": 2e-3, "Jp": 1.2, "Kp": 600.0, "Dp": 3.0}
HUB = Body("hub", inertia="Jh")
WHEEL, PANEL = Body("wheel", inertia="Jw", on=HUB), Body("panel", inertia="Jp", on=HUB)
SATELLITE = Axis(
    "satellite",
    (HUB, WHEEL, ViscousFriction(WHEEL, "Fw"), PANEL, Spring("hinge", PANEL, stiffness="Kp", damping="Dp")),
    Drive("T", WHEEL),
    (Position("qw", WHEEL), Velocity("gyro", HUB)),
)


def logged(n: int, rate: float) -> Log:
    """Motion under a held torque by scipy's discretisation of the balances, written by hand; with noise."""
    J, W, F, P, K, D = TRUE.values()
    M = np.array([[J + W + P, W, P], [W, W, 0.0], [P, 0.0, P]])
    inverse = np.linalg.inv(M)
    A = np.block(
        [[np.zeros((3, 3)), np.eye(3)], [-inverse @ np.diag([0, 0, K]), -inverse @ np.diag([0, F, D])]]
    )
    B = np.concatenate([np.zeros(3), inverse @ [0.0, 1.0, 0.0]])[:, None]
    C = np.zeros((2, 6))
    C[0, 1] = C[1, 3] = 1.0
    A, B, *_ = scipy.signal.cont2discrete((A, B, C, np.zeros((2, 1))), 1 / rate)
    draw = np.random.default_rng(5)
    time, lines = np.arange(n) / rate, np.geomspace(0.5, 12.0, 15)
    torque = np.sin(2 * np.pi * np.outer(time, lines) + draw.uniform(0, 6, lines.size)).sum(axis=1)
    states = np.zeros((n, 6))
    for k in range(n - 1):
        states[k + 1] = A @ states[k] + B[:, 0] * torque[k]
    q, gyro = (states @ C.T + draw.normal(scale=[1e-5, 1e-6], size=(n, 2))).T
    return Log("own", 0.0, 1 / rate, {"T": torque + 1e-3 * draw.normal(size=n), "qw": q, "gyro": gyro})


@pytest.mark.parametrize("nominal", [None, TRUE])
def test_the_place_of_a_free_base_is_not_needed(nominal: dict[str, float] | None) -> None:

    found = identify(
        SATELLITE, logged(1500, 200.0), method="oe", preparation=Preparation(held=True), nominal=nominal
    )
    assert found.status == "ok", found.message
    for (name, value), deviation in zip(
        found.physical_parameters.items(), found.physical_deviations, strict=True
    ):
        assert abs(value - TRUE[name]) < 4 * deviation < 0.1 * TRUE[name], name
