"""Effects of a size that suits a machine, as elements of its axis."""

from dataclasses import dataclass

import numpy as np

from symid import Body
from symid.axis import (
    ActuatorDelay,
    Cogging,
    EncoderRipple,
    ForceLimit,
    FrictionAsymmetry,
    FrictionDrift,
    GainAsymmetry,
    LoadDependentFriction,
    OffsetForce,
    PayloadChange,
    PeriodicForce,
    PositionStiffness,
    PreslidingFriction,
    QuadraticDrag,
    StribeckFriction,
)
from symid.axis.axis import Element
from symid.axis.imperfections import Imperfection

EFFECTS = (
    "delay",
    "saturation",
    "stribeck_friction",
    "asymmetric_friction",
    "quadratic_drag",
    "offset_force",
    "position_stiffness",
    "cogging",
    "presliding_friction",
    "load_dependent_friction",
    "friction_drift",
    "periodic_disturbance",
    "payload_change",
    "gain_nonlinearity",
    "encoder_ripple",
)
_MOST_ONE_SIDED = 0.9
"""Difference of friction by direction, relative to its mean."""
_WAVES = (1, 2, 4, 6, 7, 12, 24)
_PITCHES = (0.01, 0.02, 0.024, 0.036)


@dataclass(frozen=True)
class Scale:
    """Sizes of a machine's motion and force, SI."""

    body: Body
    force: float
    acceleration: float
    speed: float
    travel: float
    inertia: float
    resolution: float
    turns: bool
    friction: float
    viscous: float


def drawn_effect(
    name: str, scale: Scale, share: float, rng: np.random.Generator, level: str = "E"
) -> tuple[Element | Imperfection, dict[str, float]]:
    """An effect of a share of the force, and the values of its parameters, which `level` names."""
    body, force, speed = scale.body, share * scale.force, scale.speed
    second = level + "2"
    phase = float(rng.uniform(0, 2 * np.pi))
    sine, cosine = np.cos(phase), np.sin(phase)
    pitch = 2 * np.pi / float(rng.choice(_WAVES)) if scale.turns else float(rng.choice(_PITCHES))
    pitch = min(pitch, scale.travel / 2)
    match name:
        case "delay":
            return ActuatorDelay(8e-3 * share * float(rng.uniform(1, 4))), {}
        case "saturation":
            return ForceLimit(scale.force * float(rng.uniform(0.9, 1.1))), {}
        case "stribeck_friction":
            return StribeckFriction(body, level, velocity=speed * float(rng.uniform(0.03, 0.1))), {
                level: force
            }
        case "asymmetric_friction":
            dry = min(force, _MOST_ONE_SIDED * scale.friction)  # with more, friction would push one way
            return FrictionAsymmetry(body, level, second), {
                level: dry,
                second: min(0.3 * dry / speed, _MOST_ONE_SIDED * scale.viscous),
            }
        case "quadratic_drag":
            return QuadraticDrag(body, level), {level: 1.5 * force / speed**2}
        case "offset_force":
            return OffsetForce(body, level), {level: force}
        case "position_stiffness":
            return PositionStiffness(body, level), {level: 2 * force / scale.travel}
        case "cogging":
            return Cogging(body, level, second, pitch=pitch), {level: force * sine, second: force * cosine}
        case "presliding_friction":
            reach = scale.travel * float(rng.uniform(0.001, 0.01))
            return PreslidingFriction(body, 1.5 * force, reach=reach), {}
        case "load_dependent_friction":
            return LoadDependentFriction(body, share), {}
        case "friction_drift":
            return FrictionDrift(body, force, force / speed, time_constant=float(rng.uniform(2, 6))), {}
        case "periodic_disturbance":
            return PeriodicForce(body, force * sine, force * cosine, frequency=float(rng.uniform(5, 40))), {}
        case "payload_change":
            return PayloadChange(body, scale.inertia * share, time=float(rng.uniform(2, 4))), {}
        case "gain_nonlinearity":
            return GainAsymmetry(0.6 * share), {}
        case "encoder_ripple":
            size = share * scale.resolution * float(rng.uniform(2, 10))
            return EncoderRipple("q", size * sine, size * cosine, pitch=pitch), {}
    raise ValueError(f"no effect {name!r}: choose from {', '.join(EFFECTS)}")
