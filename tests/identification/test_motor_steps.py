"""A geared motor under a few steps of voltage, its speed averaged and rounded by the recorder."""

import numpy as np

from symid import Axis, Body, CoulombFriction, Drive, Velocity, ViscousFriction, identify

TRUE = {"J": 0.08, "Fv": 0.3, "Fc": 1.7}
RPM = 2 * np.pi / 60
PERIOD, FINE = 0.01, 10


def motor_run() -> dict[str, np.ndarray]:
    """At rest under 1 V, then 4 and 6 V; the gear makes 2 % of ripple, the mean of 5 samples is rounded to 0.5 rpm."""
    u = np.repeat([1.0, 4.0, 6.0], [60, 300, 225])
    w, angle, speed = 0.0, 0.0, []
    for volts in np.repeat(u, FINE):
        push = volts - TRUE["Fc"] - TRUE["Fv"] * w
        w = max(w + PERIOD / FINE * push / TRUE["J"], 0.0)
        angle += PERIOD / FINE * w
        speed.append(w * (1 + 0.02 * np.sin(4 * angle)))
    read = np.convolve(speed, np.full(5 * FINE, 1 / (5 * FINE)))[: len(speed)][::FINE]
    return {"t": PERIOD * np.arange(u.size), "w": 0.5 * RPM * np.round(read / (0.5 * RPM)), "u": u}


def test_steps_of_a_motor_are_identified() -> None:
    rotor = Body("rotor", inertia="J")
    axis = Axis(
        "motor_steps",
        elements=(rotor, ViscousFriction(rotor, "Fv"), CoulombFriction(rotor, "Fc")),
        drive=Drive("u", rotor, unit="V"),
        sensors=(Velocity("w", rotor),),
    )
    found = identify(axis, motor_run())
    assert found.status not in ("recording", "poor_fit"), found.message
    assert "drifts by" not in found.message
    assert abs(found.physical_parameters["Fv"] / TRUE["Fv"] - 1) < 0.1
    assert abs(found.physical_parameters["Fc"] / TRUE["Fc"] - 1) < 0.2
    assert abs(found.physical_parameters["J"] / TRUE["J"] - 1) < 0.3
