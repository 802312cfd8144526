"""A controller other than that of the log: its simulated loop moves the parameters, and the status says so."""

import numpy as np
import pytest

from symid import load_axis, load_generated
from symid.output_error import identify_output_error
from symid.output_error.controller_check import AlteredController
from symid.simulation import Cascade, ClosedLoop, simulate, trapezoids

TRUE = {"M": 40.0, "Fv": 30.0, "Fs": 12.0}
GIVEN = Cascade("q", position_gain=40.0, velocity_gain=6000.0, integral_gain=10.0)
AXIS = load_axis("rigid_1m")
PATH = trapezoids([0.1], [0.2], acceleration=4.0, jerk=200.0, dwell=0.05, sampling_period=1e-3)


class Python(AlteredController):
    """Without matrices."""

    def linear(self, period: float) -> None:
        return None


def log_of(controller, seed: int = 0):
    noisy = AXIS.with_signal("q", noise=2e-7).with_signal("F", noise=0.5)
    return simulate(noisy, TRUE, PATH, controller, seed=seed).log


def status_of(log) -> tuple[str, str]:
    near = {name: 1.1 * value for name, value in TRUE.items()}
    loop = ClosedLoop(AXIS, GIVEN, 1000.0)
    found = identify_output_error(AXIS, load_generated("rigid_1m"), log, loop=loop, nominal=near)
    return found.status, found.message


def test_terms_of_the_error_are_a_position_loop_with_another_gain() -> None:
    # by hand: F grows by Kpv dKpp (e + Kiv integral of e)
    change = 5.0 * GIVEN.velocity_gain * np.array([1.0, GIVEN.integral_gain, 0.0, 0.0, 0.0, 0.0])
    stiffer = simulate(AXIS, TRUE, PATH, GIVEN.with_gains(position_gain=45.0)).log
    for kind in (AlteredController, Python):
        altered = simulate(AXIS, TRUE, PATH, kind(GIVEN, change)).log
        np.testing.assert_allclose(altered["F"], stiffer["F"], atol=1e-6 * np.ptp(stiffer["F"]))


def test_other_terms_are_the_same_with_and_without_matrices() -> None:
    change = np.array([0.0, 0.0, 300.0, 50.0, 4.0, 0.7])
    compiled, plain = (
        simulate(AXIS, TRUE, PATH, kind(GIVEN, change)).log for kind in (AlteredController, Python)
    )
    np.testing.assert_allclose(compiled["F"], plain["F"], atol=1e-6 * np.ptp(plain["F"]))
    late = simulate(AXIS, TRUE, PATH, AlteredController(GIVEN, np.array([0, 0, 0, 0, 0, 1.0]))).log
    given = simulate(AXIS, TRUE, PATH, GIVEN).log
    assert late["F"][0] == 0.0
    assert np.abs(late["F"] - given["F"]).max() > 0.01 * np.ptp(given["F"])


def test_the_controller_of_the_log_is_ok() -> None:
    assert status_of(log_of(GIVEN, seed=1)) == ("ok", "")


def test_a_short_log_that_ends_in_motion_is_ok() -> None:
    assert status_of(log_of(GIVEN, seed=2).window(0, 300)) == ("ok", "")


@pytest.mark.parametrize(
    "made",
    [
        GIVEN.with_gains(velocity_gain=1.1 * GIVEN.velocity_gain),
        GIVEN.with_gains(position_gain=0.97 * GIVEN.position_gain),
        GIVEN.with_gains(acceleration_feedforward=8.0),
        AlteredController(GIVEN, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])),
    ],
    ids=["velocity gain", "position gain", "feed-forward", "a sample late"],
)
def test_another_controller_is_not(made) -> None:
    status, message = status_of(log_of(made))
    assert status == "poor_fit"
    assert "does not produce the logged force" in message
