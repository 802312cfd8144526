"""Rack and pinion without play: the parameters that a log determines, and how a data sheet provides the rest."""

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    ViscousFriction,
    derive,
    identify,
    simulate,
)
from symid.simulation import plant_of, trapezoids, tuned_cascade

RADIUS = 0.03  # pitch radius of the pinion, m

pinion = Body("pinion", inertia="J")
carriage = Body("carriage", mass="M", geared=Geared(to=pinion, ratio=RADIUS))
axis = Axis(
    "rack",
    elements=(pinion, ViscousFriction(pinion, "Fv"), CoulombFriction(pinion, "Fs"), carriage),
    drive=Drive("tau", pinion, held=True, noise=0.05),  # it acts half a sample late
    sensors=(Position("q", pinion, noise=1e-6),),
)
TRUE = {"J": 0.02, "M": 250.0, "Fv": 0.4, "Fs": 2.5}
SHEET = 0.02  # inertia of motor and pinion from the data sheet, kg m^2


def main() -> None:
    """Identify what the log determines, then the carriage from the known inertia."""
    model = derive(axis)
    print(model)
    for name, solutions in model.parameter_map.identifiability.items():
        print(f"{name:2} solutions: {solutions}")
    reference = trapezoids(
        [10.0, 30.0], [5.0, 20.0], acceleration=60.0, jerk=2000.0, dwell=0.2, sampling_period=1 / 2000
    )
    log = simulate(axis, TRUE, reference, tuned_cascade(plant_of(axis, TRUE), "q")).log
    found = identify(model, log)
    for name, value in found.minimal_parameters.items():
        print(f"{name} = {value:.4f}")
    inertia = found.minimal_parameters["X1"]
    print(f"carriage {(inertia - SHEET) / RADIUS**2:.0f} kg, true {TRUE['M']:.0f} kg")


if __name__ == "__main__":
    main()
