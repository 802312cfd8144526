"""A ball screw with an elastic nut: motor encoder and table scale identify screw, nut and table separately."""

from math import pi

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    ViscousFriction,
    derive,
    identify,
    simulate,
)
from symid.simulation import plant_of, trapezoids, tuned_cascade

LEAD = 0.01  # m a turn

screw = Body("screw", inertia="J")
table = Body("table", mass="M")
nut = Between(first=screw, second=table, ratio=LEAD / (2 * pi))
axis = Axis(
    "ball_screw",
    elements=(
        screw,
        ViscousFriction(screw, "Fvs"),
        CoulombFriction(screw, "Fss"),
        Spring("nut", nut, stiffness="K", damping="C"),
        table,
        ViscousFriction(table, "Fvt"),
    ),
    drive=Drive("tau", screw, held=True, noise=0.005),  # it acts half a sample late
    sensors=(Position("qm", screw, noise=2e-6), Position("qt", table, noise=2e-8)),
)
TRUE = {"J": 2e-3, "Fvs": 5e-3, "Fss": 0.3, "K": 8e6, "C": 9000.0, "M": 300.0, "Fvt": 400.0}


def main() -> None:
    """Let the axis move like a machine, identify it from that log, and print what was found."""
    reference = trapezoids(
        [60.0, 150.0], [40.0, 120.0], acceleration=900.0, jerk=4e4, dwell=0.2, sampling_period=1 / 4000
    )
    controller = tuned_cascade(plant_of(axis, TRUE), "qm", bandwidth_hz=15.0)
    log = simulate(axis, TRUE, reference, controller).log
    found = identify(derive(axis, ("qm", "qt")), log)
    print(found.status)
    deviations = found.physical[0].standard_deviations
    for (name, value), std in zip(found.physical_parameters.items(), deviations, strict=True):
        print(f"{name:4} {value:9.3g} +- {std:7.1g}  true {TRUE[name]:9.3g}")


if __name__ == "__main__":
    main()
