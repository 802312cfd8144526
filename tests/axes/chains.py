"""Chains nM-kS by hand: the plant of any number of masses, from 1M0S to 8M7S."""

from collections.abc import Sequence

import numpy as np

from axes.case import Case
from axes.plant import Plant, Sensor, Values, coulomb
from symid import Axis, chain


def chain_plant(values: Values, masses: int, springs: int, driven: int) -> Plant:
    """Plant of a chain; joint i lies between masses i - 1 and i, joint 1 between the ground and mass 1."""
    p = values.numbers
    C, K = np.zeros((masses, masses)), np.zeros((masses, masses))
    for i in range(masses):
        across = _across(i, masses)
        C += p.get(f"F{i + 1}", 0.0) * np.outer(across, across)
        if i + 1 != driven or springs == masses:
            K += p[f"K{i + 1}"] * np.outer(across, across)
    push = _across(driven - 1, masses)
    still = ((push, coulomb(p["Fs"])),) if "Fs" in p else ()
    return Plant(np.diag([p[f"M{i + 1}"] for i in range(masses)]), C, K, push, np.zeros(masses), still)


def _across(joint: int, masses: int) -> np.ndarray:
    """Row that takes the displacement in a joint from absolute displacements."""
    row = np.zeros(masses)
    row[joint] = 1
    if joint:
        row[joint - 1] = -1
    return row


def chain_values(
    masses: int, springs: int, driven: int, *, damping: bool = True, coulomb_level: float | None = 0.3
) -> dict[str, float]:
    """Values of about one for each parameter, all different."""
    values: dict[str, float] = {}
    for i in range(1, masses + 1):
        values[f"M{i}"] = 1.0 + 0.13 * i
        if damping:
            values[f"F{i}"] = 0.2 + 0.03 * i
        if i == driven and coulomb_level is not None:
            values["Fs"] = coulomb_level
        if i != driven or springs == masses:
            values[f"K{i}"] = 1.5 - 0.11 * i
    return values


def chain_case(
    masses: int,
    springs: int,
    driven: int,
    accelerometers: Sequence[int] = (),
    *,
    coulomb_level: float | None = 0.3,
) -> Case:
    """A chain of symid.chain beside its plant."""
    name = f"chain_{masses}m{springs}s_{driven}" + ("" if coulomb_level else "_smooth")
    declared: Axis = chain(
        name, masses, springs, driven=driven, coulomb=coulomb_level is not None, accelerometers=accelerometers
    )
    sensors = {f"q{driven}": Sensor(tuple(_across(driven - 1, masses)))}
    sensors |= {f"ddq{i}": Sensor(tuple(_across(i - 1, masses)), 2) for i in accelerometers}
    return Case(
        declared,
        chain_values(masses, springs, driven, coulomb_level=coulomb_level),
        lambda p: chain_plant(p, masses, springs, driven),
        sensors,
    )


def chain_cases() -> list[Case]:
    """Chains with the first or the second mass driven, with and without a spring in the driven joint."""
    small = [
        chain_case(masses, springs, driven, (masses,) if 1 < masses < 4 else ())
        for driven in (1, 2)
        for masses in range(driven, 5)
        for springs in (masses - 1, masses)
    ]
    return [*small, chain_case(3, 2, 2, (1, 3), coulomb_level=None)]
