"""The family nM-kS, n masses in a row joined by k springs, and a first declaration to edit, with comments beside it."""

from collections.abc import Iterator, Sequence

from symid.axis.axis import Axis, Element
from symid.axis.elements import GROUND, Between, Body, Drive, Ground, Spring
from symid.axis.laws import CoulombFriction, ViscousFriction
from symid.axis.sensors import Acceleration, Position, Sensor
from symid.axis.source import axis_source
from symid.errors import DeclarationError, SettingError


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


def sketch(
    name: str,
    bodies: int = 2,
    springs: int | None = None,
    *,
    structure: bool = False,
    rotary: bool = False,
    coulomb: bool = True,
    encoders: Sequence[str] = (),
    accelerometers: Sequence[str] = (),
    drives: int = 1,
) -> Axis:
    """Axis of bodies in a row: (structure,) motor, (motor2, ...) load, load2, ...

    The structure stands on the ground by a spring and carries the motors; a load is joined to what is before it by a
    spring and a damper, the first one to every motor. Motors without a load are joined to each other. A drive pushes
    each motor against what it is on.

    Parameters
    ----------
    name : str
        Name of the axis.
    bodies : int
        Number of bodies, the structure included.
    springs : int, optional
        Number of springs: bodies - 1 (default), or as many as bodies, then the motor's joint has one too.
    structure : bool
        Whether the first body is a flexible structure.
    rotary : bool
        Whether bodies turn: inertias and a torque instead of masses and a force.
    coulomb : bool
        Whether the motor's joint has Coulomb friction.
    encoders, accelerometers : sequence of str
        Bodies with an encoder (besides the motors) or an accelerometer, both against the ground.
    drives : int
        Number of drives, each with a motor and its encoder.

    Raises
    ------
    SettingError
        If the numbers or the names of bodies are not possible.

    Examples
    --------
    >>> list(sketch("mine", 2, encoders=["load"]).physical_parameters)
    ['Mm', 'Fvm', 'Fsm', 'Kl', 'Cl', 'Ml', 'Fvl']
    """
    names = _names(bodies, structure, drives)
    if drives > 1 and springs is not None:
        raise SettingError(
            f"springs is {springs}: with {drives} drives, edit the springs in the file instead"
        )
    springs = bodies - 1 if springs is None else springs
    if springs not in (bodies - 1, bodies):
        raise SettingError(f"springs is {springs}: {bodies} bodies take {bodies - 1} or {bodies} springs")
    if wrong := [body for body in (*encoders, *accelerometers) if body not in names]:
        raise SettingError(f"there is no body {wrong[0]!r} for a sensor: choose from {', '.join(names)}")
    made: dict[str, Body] = {}
    elements: list[Element] = []
    for body in names:
        tag = _tag(body)
        parent = made["structure"] if body.startswith("motor") and structure else GROUND
        made[body] = (
            Body(body, inertia=f"J{tag}", on=parent) if rotary else Body(body, mass=f"M{tag}", on=parent)
        )
        elements += _joint(made, body, tag, held=springs == bodies, coulomb=coulomb)
        if body.startswith("motor") and body != "motor" and "load" not in names:
            end = tag[1:] if tag != "m2" else ""
            between = Between(first=list(made.values())[-2], second=made[body])
            elements.append(Spring(f"coupling{end}", between, stiffness=f"Kc{end}", damping=f"Cc{end}"))
    motors = [made[body] for body in names if body.startswith("motor")]
    sensors: list[Sensor] = [
        Position("q" if bodies == 1 else f"q{_tag(motor.name)}", motor) for motor in motors
    ]
    sensors += [
        Position(f"q{_tag(body)}", made[body], relative_to=_ground(made[body]))
        for body in encoders
        if made[body] not in motors
    ]
    sensors += [
        Acceleration(f"ddq{_tag(body)}", made[body], relative_to=_ground(made[body]))
        for body in accelerometers
    ]
    force = "tau" if rotary else "F"
    driven = tuple(Drive(force if drives == 1 else f"{force}{i}", m) for i, m in enumerate(motors, 1))
    return Axis(name, tuple(elements), driven, tuple(sensors))


def _names(bodies: int, structure: bool, drives: int) -> list[str]:
    if drives < 1 or bodies < drives + structure:
        of_drives = f" with {drives} drives" if drives > 1 else ""
        raise SettingError(
            f"bodies is {bodies}: an axis has at least {drives + structure}{' with a structure' * structure}{of_drives}"
        )
    loads = bodies - drives - structure
    return [
        *["structure"] * structure,
        *(f"motor{i}" if i > 1 else "motor" for i in range(1, drives + 1)),
        *(f"load{i}" if i > 1 else "load" for i in range(1, loads + 1)),
    ]


def _tag(body: str) -> str:
    """End of the names of a body's parameters: its first letter, and its number if it has one."""
    return body[0] + body.lstrip("abcdefghijklmnopqrstuvwxyz")


def _ground(body: Body) -> Ground | None:
    """The ground for a body on another one; what is on the ground is read against it without saying so."""
    return None if body.on == GROUND else GROUND


def _joint(made: dict[str, Body], body: str, tag: str, *, held: bool, coulomb: bool) -> Iterator[Element]:
    """A body with what holds it."""
    new_body = made[body]
    motors = [motor for motor in made.values() if motor.name.startswith("motor")]
    # The first load hangs on all motors, each further load on the one before.
    joined = motors if body == "load" else list(made.values())[-2:-1] if body.startswith("load") else []
    for before in joined:
        end = f"_{_tag(before.name)}" if before in motors[1:] else ""
        name = f"transmission{tag[1:]}{end}"
        between = Between(first=before, second=new_body)
        yield Spring(name, between, stiffness=f"K{tag}{end}", damping=f"C{tag}{end}")
    yield new_body
    yield ViscousFriction(new_body, f"Fv{tag}")
    if body == "structure":
        yield Spring("foundation", new_body, stiffness=f"K{tag}")
    if body.startswith("motor"):
        if coulomb:
            yield CoulombFriction(new_body, f"Fs{tag}")
        if held:
            yield Spring("flexure", new_body, stiffness=f"K{tag}")


_COMMENTS = (
    ("structure = ", "the machine bed, on the ground; held by the spring `foundation`"),
    (
        "motor = ",
        "the driven body; `on=` names the body that carries it, to which its coordinate is relative",
    ),
    (
        "load = ",
        "joined to the motor by the spring `transmission`; geared=Geared(to=motor, ratio=...) makes it rigid",
    ),
    (
        "    elements=",
        "one line for each element; names in quotes are parameters to identify: delete, add, rename",
    ),
    ("    drive=", 'held=True: sent at t and held until the next sample; unit="A": the constant is unknown'),
    (
        "    sensors=",
        "names are the columns of a log; the first is needed, of the others those that a log has",
    ),
)


def sketch_source(axis: Axis) -> str:
    """Text of the axis file of a sketch, with comments that say what to edit.

    Examples
    --------
    >>> print(sketch_source(sketch("mine", 1)).splitlines()[0])
    \"""Axis mine: motor. Edit it, look at it with `symid show`, and write its regressors with `symid generate`.
    """
    summary = (
        f"Axis {axis.name}: {', '.join(body.name for body in axis.bodies)}. Edit it, look at it with `symid show`, "
        "and write its regressors with `symid generate`. More elements (weights, gears, Stribeck friction, cogging, "
        "backlash) are in docs/declaring.md."
    )
    lines: list[str] = []
    for line in axis_source(axis, summary).splitlines():
        comment = next((text for start, text in _COMMENTS if line.startswith(start)), None)
        if comment:
            lines.append(f"{' ' * (len(line) - len(line.lstrip()))}# {comment}")
        lines.append(line)
    return "\n".join(lines) + "\n"
