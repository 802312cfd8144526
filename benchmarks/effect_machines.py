"""Elements of the effects of the library, each with its values in a machine, and logs of these machines."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from symid import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    Backlash,
    Body,
    Cogging,
    CoulombFriction,
    Drive,
    EncoderRipple,
    ForceConstantRipple,
    ForceLimit,
    FrictionAsymmetry,
    FrictionDrift,
    FrictionTrend,
    GainAsymmetry,
    GainNonlinearity,
    LoadDependentFriction,
    Log,
    OffsetForce,
    PayloadChange,
    PeriodicForce,
    PeriodicFriction,
    Position,
    PositionStiffness,
    PreslidingFriction,
    QuadraticDrag,
    Spring,
    SpringDamping,
    StiffnessNonlinearity,
    StribeckFriction,
    Unbalance,
    ViscousFriction,
)
from symid.axis import Between
from symid.simulation import Cascade, Trajectory, simulate, trapezoids

MOTOR, LOAD = Body("motor", mass="M"), Body("load", mass="Ml")
FRICTION = (ViscousFriction(MOTOR, "Fv"), CoulombFriction(MOTOR, "Fs"))
SENSORS = (Position("q", MOTOR, noise=1e-7),)
RIGID = Axis("rigid", (MOTOR, *FRICTION), Drive("F", MOTOR, noise=0.3), SENSORS)
COUPLING = Between(first=MOTOR, second=LOAD)
ELASTIC = Axis(
    "elastic",
    (*RIGID.elements, LOAD, Spring("coupling", COUPLING, "K", damping="C")),
    RIGID.drive,
    (*SENSORS, Position("ql", LOAD, noise=1e-7)),
)
UNDAMPED = replace(ELASTIC, elements=(*RIGID.elements, LOAD, Spring("coupling", COUPLING, "K")))
TABLE = Body("table", inertia="J")
TURNING = Axis(
    "turning",
    (TABLE, ViscousFriction(TABLE, "Fv"), CoulombFriction(TABLE, "Fs")),
    Drive("F", TABLE, noise=0.3),
    (Position("q", TABLE, noise=1e-6),),
)
VALUES = {"J": 40.0, "M": 40.0, "Fv": 120.0, "Fs": 12.0, "Ml": 25.0, "K": 6e5, "C": 300.0}
LOOP = Cascade("q", position_gain=20.0, velocity_gain=2500.0, integral_gain=4.0)
PERIOD = 1e-3


@dataclass(frozen=True)
class Kind:
    """An element of an effect, values of its parameters, the machine that has it, and the size of its moves."""

    effect: str
    element: Any
    values: Mapping[str, float] = field(default_factory=dict)
    lacking: Axis = RIGID
    size: float = 1.0

    @property
    def axis(self) -> Axis:
        """The machine with the element."""
        return self.lacking if self.element in self.lacking.elements else self.plain.with_effect(self.element)

    @property
    def plain(self) -> Axis:
        """The model without it."""
        return self.lacking.without(self.element)

    def of(self, axis: Axis) -> dict[str, float]:
        values = {**VALUES, **self.values}
        return {name: values[name] for name in axis.physical_parameters}


KINDS = (
    Kind("viscous_friction", FRICTION[0]),
    Kind("coulomb_friction", FRICTION[1]),
    Kind("stribeck_friction", StribeckFriction(MOTOR, "dF", velocity=0.03), {"dF": 8.0}),
    Kind("asymmetric_friction", FrictionAsymmetry(MOTOR, "dFs", "dFv"), {"dFs": 4.0, "dFv": 20.0}),
    Kind("presliding_friction", PreslidingFriction(MOTOR, 12.0, reach=3e-4)),
    Kind("load_dependent_friction", LoadDependentFriction(MOTOR, 0.15)),
    Kind(
        "position_dependent_friction", PeriodicFriction(MOTOR, "dS", "dC", pitch=0.1), {"dS": 5.0, "dC": 3.0}
    ),
    Kind("friction_drift", FrictionDrift(MOTOR, 10.0, 60.0, time_constant=4.0)),
    Kind("friction_drift", FrictionTrend(MOTOR, 0.8, 0.0)),
    Kind("quadratic_drag", QuadraticDrag(MOTOR, "c"), {"c": 150.0}),
    Kind("offset_force", OffsetForce(MOTOR, "F0"), {"F0": 15.0}),
    Kind("position_stiffness", PositionStiffness(MOTOR, "k"), {"k": 120.0}),
    Kind("cogging", Cogging(MOTOR, "As", "Ac", pitch=0.024), {"As": 6.0, "Ac": -4.0}),
    Kind("periodic_disturbance", PeriodicForce(MOTOR, 6.0, 3.0, frequency=7.3)),
    Kind("payload_change", PayloadChange(MOTOR, 8.0, time=9.0)),
    Kind("delay", ActuatorDelay(0.0032)),
    Kind("actuator_lag", ActuatorLag(0.004)),
    Kind("saturation", ForceLimit(150.0)),
    Kind("gain_nonlinearity", GainNonlinearity(0.001, power=2)),
    Kind("gain_nonlinearity", GainNonlinearity(2e-6, power=3)),
    Kind("gain_nonlinearity", GainAsymmetry(0.08)),
    Kind("force_constant_ripple", ForceConstantRipple(0.06, -0.03, pitch=0.024)),
    Kind("encoder_ripple", EncoderRipple("q", 3e-6, 2e-6, pitch=0.01)),
    Kind("stiffness_nonlinearity", StiffnessNonlinearity(COUPLING, "k3"), {"k3": 1.5e13}, ELASTIC),
    Kind("spring_damping", SpringDamping(COUPLING, "C"), {}, UNDAMPED),
    Kind("backlash", Backlash(COUPLING, "Kb", gap=1e-4), {"Kb": 6e5}, ELASTIC),
    Kind("weight", Unbalance(TABLE, "Gs", "Gc"), {"Gs": 60.0, "Gc": -30.0}, TURNING, size=10.0),
)
"""Elements of effects; a flexible mode is a body and a spring, a late reading a property of its sensor."""


def path(seed: int, rate: float = 1 / PERIOD, size: float = 1.0) -> Trajectory:
    """Strokes of two lengths at several speeds, in a size."""
    levels, speeds = {1: ([0.12, 0.04], [0.06, 0.2, 0.4]), 2: ([0.15, 0.05], [0.08, 0.3])}[seed]
    levels, speeds = ([size * x for x in some] for some in (levels, speeds))
    return trapezoids(
        levels, speeds, acceleration=size * 2.5, jerk=size * 50.0, dwell=0.1, sampling_period=1 / rate
    )


def machine(axis: Axis, values: Mapping[str, float], seed: int, size: float = 1.0) -> Log:
    """A log of an axis under `LOOP`."""
    return replace(simulate(axis, values, path(seed, size=size), LOOP, seed=seed).log, source=f"run {seed}")
