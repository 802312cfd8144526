"""Gantry with two linear motors: carriages, beam and its rotational stiffness from one log, and a missing effect."""

from collections.abc import Sequence

import numpy as np

from symid import (
    Axis,
    Body,
    Cogging,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    Spring,
    ViscousFriction,
    derive,
    diagnose,
    identify,
    simulate,
)
from symid.simulation import Controller, Trajectory, chirp, plant_of, tuned_cascades

SPAN = 1.25  # between the carriages, m
CARRIAGE = 31.5  # weighed, kg: beam and yaw leave the carriages undetermined otherwise
PERIOD = 1 / 4000

left = Body("left", mass=CARRIAGE)
right = Body("right", mass=CARRIAGE)
beam = Body("beam", mass="Mb", geared=(Geared(to=left, ratio=0.5), Geared(to=right, ratio=0.5)))
yaw = Body("yaw", inertia="J", geared=(Geared(to=left, ratio=-1 / SPAN), Geared(to=right, ratio=1 / SPAN)))
axis = Axis(
    "gantry",
    elements=(
        left,
        ViscousFriction(left, "Fv1"),
        CoulombFriction(left, "Fs1"),
        right,
        ViscousFriction(right, "Fv2"),
        CoulombFriction(right, "Fs2"),
        beam,
        yaw,
        Spring("guides", yaw, stiffness="Ky", damping="Cy"),
    ),
    drive=(Drive("F1", left, held=True, noise=1.0), Drive("F2", right, held=True, noise=1.0)),
    sensors=(Position("q1", left, noise=2e-8), Position("q2", right, noise=2e-8)),
)
TRUE = {"Fv1": 90.0, "Fs1": 22.0, "Fv2": 130.0, "Fs2": 35.0, "Mb": 84.0, "J": 11.0, "Ky": 6e5, "Cy": 350.0}


def references() -> list[Trajectory]:
    """Both carriages on one stroke, and a little against each other: without that, the beam never turns."""
    stroke = chirp(0.5, 15.0, 8.0, 0.3, sampling_period=PERIOD, quantity="velocity")
    turn = chirp(4.0, 60.0, 8.0, 0.02, sampling_period=PERIOD, quantity="velocity")
    parts = ("position", "velocity", "acceleration")
    return [
        Trajectory(*(getattr(stroke, x) + side * getattr(turn, x) for x in parts), PERIOD, "gantry")
        for side in (1, -1)
    ]


def main() -> None:
    """Simulate the machine with a controller for each motor, and identify it; the nominal values are 15 % off."""
    print(derive(axis))
    controllers = tuned_cascades(plant_of(axis, TRUE), axis.controlled_signals, bandwidth_hz=40.0)
    log = simulate(axis, TRUE, references(), controllers).log
    nominal = {name: 1.15 * value for name, value in TRUE.items()}
    found = identify(axis, log, nominal=nominal)
    print(f"status: {found.status}")
    for name, value in found.physical_parameters.items():
        print(f"{name:3} {value:10.4g}  true {TRUE[name]:8.4g}  off {100 * (value / TRUE[name] - 1):+.2f} %")
    worst = max(np.abs(log["q1"] - log["q2"])) / SPAN
    print(f"the beam turned by up to {1e3 * worst:.2f} mrad")
    lacking(found.physical_parameters, controllers)


def lacking(nominal: dict[str, float], controllers: Sequence[Controller]) -> None:
    """The left motor of the machine cogs: which effect at which motor, and how the simulated axis then moves."""
    machine = axis.with_effect(Cogging(left, "As", "Ac", pitch=0.024))
    log = simulate(machine, TRUE | {"As": 4.0, "Ac": -3.0}, references(), controllers, seed=1).log
    found = diagnose(axis, log, nominal=nominal)
    for effect in found.effects:
        values = ", ".join(f"{name} {one.value:.3g} {one.unit}" for name, one in effect.parameters.items())
        print(f"found: {effect.effect} at {effect.at}, {values}")
    for own in found.drives:
        error, motion = own.gap, own.gap.motion
        print(
            f"{error.signal}: force error {error.nominal.rms:.1f} N, then {error.explained.rms:.1f} N; "
            f"{motion.signal} simulated is {1e6 * motion.nominal.position_rms:.1f} um off, "
            f"then {1e6 * motion.explained.position_rms:.1f} um ({motion.driver} controller)"
        )


if __name__ == "__main__":
    main()
