"""A swivel table: a workpiece clamped off centre at an unknown angle, found with an encoder and a tachometer."""

import math

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    Unbalance,
    Velocity,
    ViscousFriction,
    derive,
    identify,
    simulate,
)
from symid.simulation import plant_of, trapezoids, tuned_cascade

motor = Body("motor", inertia="Jm")
table = Body("table", inertia="Jt")
axis = Axis(
    "swivel",
    elements=(
        motor,
        ViscousFriction(motor, "Fv"),
        CoulombFriction(motor, "Fs"),
        table,
        Unbalance(table, "Gs", "Gc"),  # needs the angle of the table
        Spring("shaft", Between(first=motor, second=table), stiffness="K", damping="D"),
    ),
    drive=Drive("T", motor, held=True, noise=0.02),
    sensors=(
        Position("qm", motor, noise=1e-6),
        Position("qt", table, noise=1e-6),
        Velocity("wt", table, noise=1e-4),  # a tachometer: one derivative less to take
    ),
)
TRUE = {"Jm": 0.8, "Fv": 1.5, "Fs": 3.0, "Jt": 2.4, "Gs": 18.0, "Gc": -7.0, "K": 4e4, "D": 12.0}


def main() -> None:
    """Turn to and fro by more than half a turn; weight and its angle follow from sine and cosine."""
    reference = trapezoids(
        [4.0], [1.0, 3.0, 6.0], acceleration=40.0, jerk=1500.0, dwell=0.2, sampling_period=1 / 2000
    )
    log = simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "qm")).log
    found = identify(derive(axis, ("qm", "qt", "wt")), log)
    print(found.status)
    for name, value in found.physical_parameters.items():
        print(f"{name:2} {value:9.4g}  true {TRUE[name]:9.4g}")
    Gs, Gc = (found.physical_parameters[name] for name in ("Gs", "Gc"))
    print(f"m g l = {math.hypot(Gs, Gc):.1f} N m, at {math.degrees(math.atan2(Gc, Gs)):.0f} degrees")


if __name__ == "__main__":
    main()
