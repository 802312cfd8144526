"""Step responses of a motor that is driven by a voltage, with a coarse speed, as its user records them."""

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Log, Velocity, ViscousFriction, identify
from symid.data.quality.stuck import cut_in_motion, inspect_spans

PERIOD, INERTIA, VISCOUS, STEP = 1e-3, 0.4, 20.0, 4.0
TIME = np.arange(0, 0.6, PERIOD)


def motor(*, dry: bool) -> Axis:
    rotor = Body("rotor", inertia="J")
    friction = (CoulombFriction(rotor, "Fs"),) if dry else ()
    elements = (rotor, ViscousFriction(rotor, "Fv"), *friction)
    return Axis("motor", elements, Drive("u", rotor, unit="V"), (Velocity("w", rotor),))


def log_of(u: np.ndarray, *, dry: float = 0.0, late: float = 0.0, step: float = STEP) -> Log:
    """Speed after a time `late`, in steps; the drive never gives exactly 0."""
    seen = np.interp(TIME - late, TIME, u, left=u[0])
    speed, fine, w = np.empty(TIME.size), 20, 0.0
    for k, force in enumerate(seen):
        speed[k] = w
        for _ in range(fine):
            before, free = w, w + PERIOD / fine / INERTIA * (force - VISCOUS * w)
            w = np.sign(free) * max(abs(free) - PERIOD / fine / INERTIA * dry, 0.0)
            w = 0.0 if before * w < 0 else w
    return Log("by hand", 0.0, PERIOD, {"u": u, "w": np.round(speed / step) * step})


def test_friction_and_inertia_are_not_told_apart_by_a_constant_force() -> None:
    found = identify(motor(dry=True), log_of(np.where(TIME < 0.2, 1.0, -3600.0), dry=900.0))
    assert found.status == "undetermined"
    assert "u hardly changes while the axis moves" in found.message


def test_steps_of_several_sizes_tell_friction_from_inertia() -> None:
    u = np.select([TIME < 0.1, TIME < 0.25, TIME < 0.4, TIME < 0.5], [0.0, -3600.0, -1800.0, 2400.0], 3600.0)
    found = identify(motor(dry=True), log_of(u, dry=900.0, step=1e-3))
    assert found.status == "ok"
    assert found.physical_parameters["J"] == pytest.approx(INERTIA, rel=0.02)
    assert found.physical_parameters["Fs"] == pytest.approx(900.0, rel=0.02)


def test_a_step_in_one_direction_says_nothing_of_the_other() -> None:
    found = identify(motor(dry=False), log_of(np.where(TIME < 0.4, 1.0, -3600.0), dry=900.0, late=0.012))
    assert found.status == "timing"


@pytest.mark.parametrize(
    ("start", "late", "status"), [(0.2, 0.0, "ok"), (0.4, 0.0, "ok"), (0.2, 0.004, "timing")]
)
def test_a_single_step_shows_no_drift_of_a_clock(start: float, late: float, status: str) -> None:
    found = identify(
        motor(dry=False), log_of(np.where(start > TIME, 1.0, -3600.0), dry=900.0, late=late, step=1e-3)
    )
    assert found.status == status
    assert "clock runs at another rate" not in found.message


def test_the_steady_value_of_a_coarse_speed_is_not_the_end_of_its_range() -> None:
    steady = np.tile([24.0, 23, 24, 24, 23, 24, 24, 24, 24, 24, 24, 23, 24, 24, 23], 12)
    speed = -np.concatenate([np.zeros(400), np.arange(24.0), steady])
    assert cut_in_motion(speed) == 0
    assert not inspect_spans(PERIOD * np.arange(speed.size), {"w": speed + 0.03}, ())
    assert cut_in_motion(np.clip(30 * np.sin(np.arange(300) / 20), -24, 24).round()) > 20
