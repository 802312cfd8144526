"""A vertical ball screw: weight on the nut's side, bearing and nut as springs in series with a massless node."""

import math

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    ViscousFriction,
    Weight,
    derive,
    identify,
    simulate,
)
from symid.simulation import plant_of, trapezoids, tuned_cascade

LEAD = 0.02 / (2 * math.pi)  # m/rad
BEARING = 4e8  # N/m, from the catalogue: the log tells the series of both springs only

screw = Body("screw", inertia="J")
nut = Body("nut", mass=0.0)  # where both springs balance
table = Body("table", mass="M")
axis = Axis(
    "vertical_screw",
    elements=(
        screw,
        ViscousFriction(screw, "Fv"),
        CoulombFriction(screw, "Fs"),
        nut,
        Spring("thread", Between(first=screw, second=nut, ratio=LEAD), stiffness="Kn"),
        Spring("bearing", Between(first=nut, second=table), stiffness=BEARING),
        table,
        Weight(table),
        ViscousFriction(table, "Fvt"),
    ),
    drive=Drive("T", screw, held=True, noise=0.01),
    sensors=(Position("qm", screw, noise=1e-6), Position("z", table, noise=1e-8)),
)
TRUE = {"J": 0.004, "Fv": 0.01, "Fs": 0.8, "Kn": 1e8, "M": 300.0, "Fvt": 900.0}


def main() -> None:
    """Move up and down at three speeds and identify from motor encoder and linear scale."""
    model = derive(axis, ("qm", "z"))
    reference = trapezoids(
        [40.0], [20.0, 50.0, 90.0], acceleration=1500.0, jerk=60000.0, dwell=0.2, sampling_period=1 / 4000
    )
    log = simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "qm")).log
    found = identify(model, log)
    print(found.status)
    for name, value in found.physical_parameters.items():
        print(f"{name:3} {value:9.4g}  true {TRUE[name]:9.4g}")


if __name__ == "__main__":
    main()
