"""A vertical axis: weight, a pneumatic counterbalance that varies with position, and friction from one log."""

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    OffsetForce,
    Position,
    PositionStiffness,
    ViscousFriction,
    Weight,
    derive,
    identify,
    simulate,
)
from symid.simulation import plant_of, trapezoids, tuned_cascade

slide = Body("slide", mass="M")
axis = Axis(
    "vertical",
    elements=(
        slide,
        Weight(slide),
        ViscousFriction(slide, "Fv"),
        CoulombFriction(slide, "Fs"),
        OffsetForce(slide, "B"),  # acts against the positive direction, so a balance that lifts is negative
        PositionStiffness(slide, "k"),
    ),
    drive=Drive("F", slide, held=True, noise=2.0),  # it acts half a sample late
    sensors=(Position("z", slide, noise=2e-8),),
)
TRUE = {"M": 120.0, "Fv": 300.0, "Fs": 60.0, "B": -1100.0, "k": 150.0}


def main() -> None:
    """Move up and down at three speeds; the mass follows from accelerations, the balance from what is left of it."""
    reference = trapezoids(
        [0.4], [0.1, 0.3, 0.8], acceleration=5.0, jerk=200.0, dwell=0.2, sampling_period=1 / 2000
    )
    log = simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "z")).log
    found = identify(derive(axis), log)
    print(found.status)
    for name, value in found.physical_parameters.items():
        print(f"{name:2} {value:8.1f}  true {TRUE[name]:8.1f}")


if __name__ == "__main__":
    main()
