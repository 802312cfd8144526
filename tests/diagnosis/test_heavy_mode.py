"""A load on a soft spring that holds most of the inertia, swept through its mode, by a model without it."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import chirp, lsim

from symid import Axis, Between, Body, Drive, Log, Position, Spring, ViscousFriction, diagnose
from symid.diagnosis.fitting import start

PERIOD, HUB, TIP, STIFFNESS, DAMPING, VISCOUS, GAIN = 2e-3, 2.1e-3, 4.2e-3, 1.05, 1.5e-3, 0.07, 3.0
TIME = np.arange(0, 2.8, PERIOD)


def swept_arm() -> Log:
    """A hub under position feedback, in counts, that follows a sweep to 12 Hz; the mode of its load is at 2.5 Hz."""
    balance = [[0.0, 1.0, 0.0, 0.0], [-STIFFNESS - GAIN, -VISCOUS - DAMPING, STIFFNESS, DAMPING]]
    matrix = np.array([*balance, [0.0, 0.0, 0.0, 1.0], [STIFFNESS, DAMPING, -STIFFNESS, -DAMPING]])
    matrix[1] /= HUB
    matrix[3] /= TIP
    reference = 50.0 * chirp(TIME, 0.0, TIME[-1], 12.0, phi=-90)
    system = matrix, np.array([[0.0], [GAIN / HUB], [0.0], [0.0]]), np.array([[1.0, 0.0, 0.0, 0.0]]), [[0.0]]
    angle = lsim(system, reference, TIME)[1]
    return Log("by hand", 0.0, PERIOD, {"theta": np.round(angle), "v": GAIN * (reference - angle)})


def test_a_load_that_holds_most_of_the_inertia_is_found() -> None:
    hub = Body("hub", inertia="J")
    axis = Axis(
        "arm", (hub, ViscousFriction(hub, "Fv")), Drive("v", hub, unit="V"), (Position("theta", hub),)
    )
    found = diagnose(axis, swept_arm())
    assert (found.verdict, found.effects[0].effect) == ("effect", "flexible_mode")
    values = found.effects[0].parameters
    assert values["f"].value == pytest.approx(np.sqrt(STIFFNESS / TIP) / (2 * np.pi), rel=0.01)
    assert values["m"].value == pytest.approx(TIP, rel=0.1)


def test_a_mode_that_rings_from_before_the_log_is_found() -> None:
    """The state in which the log begins is fitted along, and its motion depends on frequency and damping."""
    hub = Body("hub", inertia="J")
    axis = Axis(
        "arm", (hub, ViscousFriction(hub, "Fv")), Drive("v", hub, unit="V"), (Position("theta", hub),)
    )
    found = diagnose(axis, swept_arm().window(350, 1400))
    assert (found.verdict, found.effects[0].effect) == ("effect", "flexible_mode")
    assert found.effects[0].parameters["m"].value == pytest.approx(TIP, rel=0.1)


def test_the_axis_is_simulated_from_the_swing_in_which_a_log_begins() -> None:
    hub = Body("hub", inertia="J")
    axis = Axis(
        "arm", (hub, ViscousFriction(hub, "Fv")), Drive("v", hub, unit="V"), (Position("theta", hub),)
    )
    found = diagnose(axis, swept_arm(), validation=swept_arm().window(500, 1300))
    assert [effect.effect for effect in found.effects] == ["flexible_mode"]
    motion = found.gap.motion
    assert motion.explained.position_rms < 0.1 * motion.reidentified.position_rms


def test_a_declared_load_that_moves_when_the_log_begins_is_identified() -> None:
    hub, tip = Body("hub", inertia="J"), Body("tip", inertia="Jt")
    beam = Spring("beam", Between(first=hub, second=tip), stiffness="K", damping="D")
    elements = (hub, ViscousFriction(hub, "Fv"), tip, beam)
    axis = Axis("arm", elements, Drive("v", hub, unit="V"), (Position("theta", hub),))
    nominal = {
        "J": 0.85 * HUB,
        "Fv": 1.15 * VISCOUS,
        "Jt": 0.85 * TIP,
        "K": 1.15 * STIFFNESS,
        "D": 0.85 * DAMPING,
    }
    found = diagnose(axis, swept_arm().window(350, 1400), nominal=nominal)
    values = {change.name: change.explained for change in found.parameters}
    assert found.verdict == "parameters"
    assert [values["Jt"], values["K"]] == pytest.approx([TIP, STIFFNESS], rel=0.03)


def test_a_spring_that_least_squares_lose_begins_with_the_output_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hub, tip = Body("hub", inertia="J"), Body("tip", inertia="Jt")
    beam = Spring("beam", Between(first=hub, second=tip), stiffness="K", damping="D")
    elements = (hub, ViscousFriction(hub, "Fv"), tip, beam)
    axis = Axis("arm", elements, Drive("v", hub, unit="V"), (Position("theta", hub),))
    lost = {"J": 5e-3, "Fv": 0.06, "Jt": -2e-3, "K": -7.0, "D": 0.01}
    monkeypatch.setattr(
        start, "identify_by_least_squares", lambda *_, **__: SimpleNamespace(physical_parameters=lost)
    )
    found = diagnose(axis, swept_arm())
    assert found.verdict == "no_gap"
    values = {change.name: change.explained for change in found.parameters}
    assert values["K"] == pytest.approx(STIFFNESS, rel=0.05)
    assert values["Jt"] == pytest.approx(TIP, rel=0.05)
