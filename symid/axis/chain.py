"""The family nM-kS: n masses in a row, joined by k springs."""

from __future__ import annotations

from collections.abc import Sequence

from symid.axis.axis import Axis, Element
from symid.axis.elements import GROUND, Body, Drive, Ground, Spring
from symid.axis.laws import CoulombFriction, ViscousFriction
from symid.axis.sensors import Acceleration, Position, Sensor
from symid.errors import DeclarationError


def chain(
    name: str,
    masses: int,
    springs: int | None = None,
    *,
    driven: int = 2,
    damping: bool = True,
    coulomb: bool = True,
    accelerometers: Sequence[int] = (),
) -> Axis:
    """Chain of masses, each on the one before; every joint holds a spring except the driven one.

    With ``driven=2`` this is the paper's structure: mass 1 stands on the ground by a spring, mass 2 is driven
    along it, further masses hang on mass 2. With ``driven=1`` the first mass is driven against the ground.

    Parameters
    ----------
    name : str
        Name of the axis.
    masses : int
        Number n of masses ``M1 .. Mn``.
    springs : int, optional
        Number k of springs ``K1 .. Kn``: n - 1 (default: none in the driven joint) or n (one in every joint).
    driven : int
        Mass that the drive pushes against the one before it. Its coordinate is the first sensor, ``q<driven>``.
    damping : bool
        Viscous friction ``F1 .. Fn`` in every joint.
    coulomb : bool
        Coulomb friction ``Fs`` in the driven joint.
    accelerometers : sequence of int
        Masses with an accelerometer ``ddq<i>``, relative to the mass before.

    Raises
    ------
    DeclarationError
        If the numbers do not make a chain.

    Examples
    --------
    >>> list(chain("axis_3m2s", 3).physical_parameters)
    ['M1', 'F1', 'K1', 'M2', 'F2', 'Fs', 'M3', 'F3', 'K3']
    """
    springs = masses - 1 if springs is None else springs
    faults = []
    if masses < 1:
        faults.append(f"masses is {masses}: a chain has at least one")
    if springs not in (masses - 1, masses):
        faults.append(f"springs is {springs}: {masses} masses take {masses - 1} or {masses} springs")
    if not 1 <= driven <= max(masses, 1):
        faults.append(f"driven is {driven}: it must be one of the masses 1 to {masses}")
    if any(not 1 <= i <= masses for i in accelerometers):
        faults.append(f"accelerometers {tuple(accelerometers)} must be masses")
    if faults:
        raise DeclarationError(name, faults)
    bodies: list[Body] = []
    elements: list[Element] = []
    for i in range(1, masses + 1):
        parent: Body | Ground = bodies[-1] if bodies else GROUND
        body = Body(f"mass{i}", mass=f"M{i}", on=parent)
        bodies.append(body)
        elements.append(body)
        if damping:
            elements.append(ViscousFriction(body, f"F{i}"))
        if i == driven and coulomb:
            elements.append(CoulombFriction(body, "Fs"))
        if i != driven or springs == masses:
            elements.append(Spring(f"spring{i}", body, stiffness=f"K{i}"))
    sensors: list[Sensor] = [Position(f"q{driven}", bodies[driven - 1])]
    sensors += [Acceleration(f"ddq{i}", bodies[i - 1]) for i in accelerometers]
    return Axis(name, tuple(elements), Drive("F", bodies[driven - 1]), tuple(sensors))
