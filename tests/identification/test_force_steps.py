"""Accelerometers under a held force, of an axis that is advanced by an own matrix exponential."""

import numpy as np
import pytest
import scipy

import symid
from symid import Acceleration, Axis, Body, Drive, Log, Position, Spring, ViscousFriction

STRUCTURE = Body("structure", mass="Ms")
MOTOR = Body("motor", mass="Mm", on=STRUCTURE)
AXIS = Axis(
    "held",
    (
        STRUCTURE,
        ViscousFriction(STRUCTURE, "Fvs"),
        Spring("foundation", STRUCTURE, stiffness="Ks"),
        MOTOR,
        ViscousFriction(MOTOR, "Fvm"),
    ),
    Drive("F", MOTOR, held=True),
    (Position("q2", MOTOR), Acceleration("ddq1", STRUCTURE)),
)
TRUE = {"Ms": 390.0, "Fvs": 800.0, "Ks": 1e7, "Mm": 36.0, "Fvm": 88.0}
T = 1e-3


def logged(share_after: float) -> Log:
    """A log whose accelerometer reads a share of the acceleration after each step, the rest before it."""
    Ms, Fvs, Ks, Mm, Fvm = TRUE.values()
    M = np.array([[Ms + Mm, Mm], [Mm, Mm]])  # of x1 and of q2, which is relative
    A, B = np.zeros((4, 4)), np.zeros((4, 1))
    A[:2, 2:] = np.eye(2)
    A[2:] = -np.linalg.solve(M, np.hstack([np.diag([Ks, 0.0]), np.diag([Fvs, Fvm])]))
    B[2:] = np.linalg.solve(M, [[0.0], [1.0]])
    step = scipy.linalg.expm(T * np.block([[A, B], [np.zeros((1, 5))]]))
    random, k = np.random.default_rng(7), np.arange(6000)
    phases = random.uniform(0, 2 * np.pi, 24)
    force = sum(
        60 * np.sin(2 * np.pi * f * T * k + p) for f, p in zip(np.linspace(1, 38, 24), phases, strict=True)
    )
    force *= np.minimum(1, np.minimum(k, k[::-1]) / 500) ** 2
    x, states = np.zeros(4), []
    for F in force:
        states.append(x)
        x = step[:4] @ np.append(x, F)
    motion = np.array(states)
    acting = share_after * force + (1 - share_after) * np.append(0.0, force[:-1])
    ddq1 = motion @ A[2] + B[2, 0] * acting
    q2 = motion[:, 1] + 1e-9 * random.standard_normal(k.size)
    return Log.from_arrays(
        {"q2": q2, "ddq1": ddq1 + 1e-5 * random.standard_normal(k.size), "F": force}, sampling_period=T
    )


@pytest.mark.parametrize(("share", "moment"), [(0.0, "before"), (1.0, "after")])
def test_what_is_read_beside_each_step_is_completed(share: float, moment: str) -> None:
    found = symid.identify(AXIS, logged(share_after=share))
    assert found.status == "ok", found.message
    for name, value in found.physical_parameters.items():
        assert value == pytest.approx(TRUE[name], rel=0.01), name
    assert any("ddq1: what each step" in note and moment in note for note in found.notes)


def test_without_it_the_damping_is_lost() -> None:
    smooth = symid.Preparation(late={"F": -T / 2})  # the same lateness, but no hold is declared
    found = symid.identify(AXIS, logged(share_after=0.0), preparation=smooth)
    assert found.status != "ok"
    assert abs(found.physical_parameters["Fvs"] / TRUE["Fvs"] - 1) > 0.3


def test_a_reading_of_the_mean_of_both_sides_is_left_as_it_is() -> None:
    found = symid.identify(AXIS, logged(share_after=0.5))
    assert found.physical_parameters["Fvs"] == pytest.approx(TRUE["Fvs"], rel=0.01)
    assert not any("ddq1" in note for note in found.notes)
