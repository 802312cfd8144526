"""Every law of an effect on a shipped axis, with values at which it shows, and its force by hand."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, pi, sin

from symid import (
    Axis,
    Backlash,
    Cogging,
    FrictionAsymmetry,
    GapDamping,
    Law,
    PeriodicFriction,
    PositionDependentFriction,
    PositionDependentViscousFriction,
    PositionStiffness,
    QuadraticDrag,
    StiffnessNonlinearity,
    StribeckFriction,
    load_axis,
)
from symid.axis import Joint

RIGID = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}
SCREW = {"Mm": 80.0, "Fvm": 120.0, "Fsm": 50.0, "Kt": 6e6, "Ft": 7000.0, "Ml": 200.0, "Fvl": 150.0}


@dataclass(frozen=True)
class Effect:
    """A law of the library, its parameters, and forces written out for (q, v)."""

    law: Callable[[Joint], Law]
    values: dict[str, float]
    forces: dict[tuple[float, float], float]
    units: tuple[str, ...]
    in_spring: bool = False


EFFECTS = {
    "stribeck": Effect(
        lambda at: StribeckFriction(at, "dF", velocity=0.05),
        {"dF": 15.0},
        {(0.0, 0.05): 15 / exp(1), (0.3, -0.1): -15 / exp(4), (0.0, 0.0): 0.0},
        ("N",),
    ),
    "drag": Effect(
        lambda at: QuadraticDrag(at, "c"), {"c": 30.0}, {(1.0, 0.2): 1.2, (0.0, -0.5): -7.5}, ("kg/m",)
    ),
    "stiffness": Effect(
        lambda at: PositionStiffness(at, "k"), {"k": -120.0}, {(0.05, 3.0): -6.0, (-0.1, 0.0): 12.0}, ("N/m",)
    ),
    "cogging": Effect(
        lambda at: Cogging(at, "As", "Ac", pitch=0.03),
        {"As": 4.0, "Ac": -3.0},
        {(0.0, 1.0): -3.0, (0.0075, 0.0): 4.0, (0.0325, -1.0): 4 * sin(pi / 6) - 3 * cos(pi / 6)},
        ("N", "N"),
    ),
    "periodic": Effect(
        lambda at: PeriodicFriction(at, "Fss", "Fsc", pitch=0.16),
        {"Fss": 6.0, "Fsc": -5.0},
        {(0.04, 0.1): 6.0, (0.04, -0.1): -6.0, (0.08, -2.0): -5.0, (0.08, 0.0): 0.0},
        ("N", "N"),
    ),
    "position_dependent": Effect(
        lambda at: PositionDependentFriction(at, "Fs1", "Fs2"),
        {"Fs1": -30.0, "Fs2": 50.0},
        {(0.0, 1.0): 0.0, (0.3, 1.0): -4.5, (0.1, -1.0): 2.5, (-0.1, 2.0): 3.5},
        ("N/m", "kg/m/s^2"),
    ),
    "position_dependent_viscous": Effect(
        lambda at: PositionDependentViscousFriction(at, "Fv1", "Fv2"),
        {"Fv1": -120.0, "Fv2": 900.0},
        {(0.0, 1.0): 0.0, (2.0, 3.0): 10080.0, (-1.0, 2.0): 2040.0},
        ("kg/m/s", "kg/m^2/s"),
    ),
    "asymmetry": Effect(
        lambda at: FrictionAsymmetry(at, "dFs", "dFv"),
        {"dFs": 5.0, "dFv": -10.0},
        {(0.0, 0.2): 3.0, (0.0, -0.2): 3.0, (1.0, 0.0): 5.0},
        ("N", "N*s/m"),
    ),
    "hardening": Effect(
        lambda at: StiffnessNonlinearity(at, "k3"),
        {"k3": 3e14},
        {(1e-5, 0.0): 0.3, (-2e-5, 1.0): -2.4},
        ("kg/m^2/s^2",),
        in_spring=True,
    ),
    "backlash": Effect(
        lambda at: Backlash(at, "Kb", gap=5e-5),
        {"Kb": 4e6},
        {(1e-5, 0.0): -40.0, (2.5e-5, 1.0): -100.0, (1e-3, 0.0): -100.0, (-4e-5, 0.0): 100.0},
        ("N/m",),
        in_spring=True,
    ),
    "gap_damping": Effect(
        lambda at: GapDamping(at, "Cb", gap=5e-5),
        {"Cb": 3000.0},
        {(1e-5, 0.1): -300.0, (-1e-5, -0.2): 600.0, (3e-5, 0.1): 0.0, (-4e-5, 0.1): 0.0},
        ("N*s/m",),
        in_spring=True,
    ),
}


def with_effect(name: str) -> Axis:
    """The axis that the effect belongs to: the rigid one, or the ball screw with it in its transmission."""
    effect = EFFECTS[name]
    axis = load_axis("ballscrew_2m1s" if effect.in_spring else "rigid_1m")
    spring = next(
        (element for element in axis.elements if getattr(element, "name", "") == "transmission"), None
    )
    at = axis.bodies[0] if spring is None else spring.at
    return axis.with_effect(effect.law(at))


def values_of(name: str) -> dict[str, float]:
    """Parameters of that axis."""
    return {**(SCREW if EFFECTS[name].in_spring else RIGID), **EFFECTS[name].values}
