"""The library of effects that a model may lack.

`effect` defines the interface of an effect. `from_law` makes effects of the force laws of an axis; the other modules
hold effects with memory, in time, in a drive or in a reading. `declared_imperfections` relates effects to elements of
an axis.
"""

from collections.abc import Sequence
from itertools import chain

from symid.axis import Backlash, Cogging, PeriodicFriction
from symid.diagnosis.effects.backlash import BacklashEffect
from symid.diagnosis.effects.declared_imperfections import (
    declared_effects,
    effects_of_element,
    imperfection_of,
)
from symid.diagnosis.effects.effect import (
    ACTUATOR,
    Effect,
    FreeForce,
    JointEffect,
    Key,
    LinearEffect,
    MatchedFilter,
    Placed,
    Shape,
)
from symid.diagnosis.effects.flexible_mode import FlexibleModeEffect
from symid.diagnosis.effects.friction_drift import FrictionDriftEffect, SteadyFrictionDriftEffect
from symid.diagnosis.effects.from_law import LawEffect, effects_of, library_of_laws
from symid.diagnosis.effects.load_dependent_friction import LoadDependentFrictionEffect
from symid.diagnosis.effects.payload_change import PayloadChangeEffect
from symid.diagnosis.effects.periodic_disturbance import PeriodicDisturbanceEffect
from symid.diagnosis.effects.presliding_friction import (
    PreslidingFrictionEffect,
    is_presliding_part,
    with_presliding_parts,
)
from symid.diagnosis.effects.repeating import (
    CoggingEffect,
    EncoderRippleEffect,
    ForceConstantRippleEffect,
    PeriodicFrictionEffect,
)
from symid.diagnosis.effects.signals import (
    LATE_FORCES,
    ActuatorLagEffect,
    DelayEffect,
    DriveEffect,
    GainAsymmetryEffect,
    GainNonlinearityEffect,
    RecordedLagEffect,
    SaturationEffect,
    SensorDelayEffect,
    TransferEffect,
    force_at,
    time_of,
    with_equivalents,
)
from symid.errors import SettingError

LIBRARY: tuple[Effect, ...] = (
    *library_of_laws(
        {Backlash: BacklashEffect, Cogging: CoggingEffect, PeriodicFriction: PeriodicFrictionEffect}
    ),
    PreslidingFrictionEffect(),
    LoadDependentFrictionEffect(),
    FrictionDriftEffect(coulomb=True, viscous=False),
    FrictionDriftEffect(coulomb=False, viscous=True),
    FrictionDriftEffect(coulomb=True, viscous=True),
    SteadyFrictionDriftEffect(coulomb=True, viscous=False),
    SteadyFrictionDriftEffect(coulomb=False, viscous=True),
    SteadyFrictionDriftEffect(coulomb=True, viscous=True),
    PeriodicDisturbanceEffect(),
    PayloadChangeEffect(),
    FlexibleModeEffect(),
    DelayEffect(),
    ActuatorLagEffect(),
    RecordedLagEffect(),
    SaturationEffect(),
    GainNonlinearityEffect(2),
    GainNonlinearityEffect(3),
    GainAsymmetryEffect(),
    ForceConstantRippleEffect(),
    EncoderRippleEffect(),
    SensorDelayEffect(),
)
"""All effects that a diagnosis considers by default."""


def effects_named(library: Sequence[Effect | str]) -> tuple[Effect, ...]:
    """Effects of a library; a name stands for all effects of that name.

    Raises
    ------
    SettingError
        If no effect has a name.

    Examples
    --------
    >>> [type(effect).__name__ for effect in effects_named(["delay", "backlash"])]
    ['DelayEffect', 'BacklashEffect']
    """
    names = dict.fromkeys(effect.name for effect in LIBRARY)
    library = [library] if isinstance(library, str) else library
    if unknown := [own for own in library if isinstance(own, str) and own not in names]:
        raise SettingError(
            f"no effect is named {', '.join(unknown)}; those of the library are {', '.join(names)}"
        )
    found = (
        [effect for effect in LIBRARY if effect.name == own] if isinstance(own, str) else [own]
        for own in library
    )
    return tuple(chain.from_iterable(found))


__all__ = [
    "ACTUATOR",
    "LATE_FORCES",
    "LIBRARY",
    "ActuatorLagEffect",
    "BacklashEffect",
    "DelayEffect",
    "DriveEffect",
    "Effect",
    "EncoderRippleEffect",
    "FlexibleModeEffect",
    "ForceConstantRippleEffect",
    "FreeForce",
    "FrictionDriftEffect",
    "GainAsymmetryEffect",
    "GainNonlinearityEffect",
    "JointEffect",
    "Key",
    "LawEffect",
    "LinearEffect",
    "LoadDependentFrictionEffect",
    "MatchedFilter",
    "PayloadChangeEffect",
    "PeriodicDisturbanceEffect",
    "Placed",
    "SaturationEffect",
    "Shape",
    "TransferEffect",
    "declared_effects",
    "effects_named",
    "effects_of",
    "effects_of_element",
    "force_at",
    "imperfection_of",
    "is_presliding_part",
    "time_of",
    "with_equivalents",
    "with_presliding_parts",
]
