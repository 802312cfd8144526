"""Faults of a declaration, all of them, each as one sentence that names the element, the rule and the cure."""

import keyword
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches

from symid.axis.elements import (
    PARAMETER_FIELDS,
    Between,
    Body,
    Damper,
    Drive,
    Parametrised,
    PendulumWeight,
    Spring,
    Weight,
)
from symid.axis.imperfections import Imperfection
from symid.axis.laws import Law
from symid.axis.laws.law import is_finite
from symid.axis.sensors import Sensor
from symid.axis.signal_faults import (
    drive_faults,
    drive_imperfection_faults,
    ends_of,
    imperfection_faults,
    label_of,
    sensor_faults,
    type_faults,
)
from symid.signal_names import is_signal_name

RESERVED = ("t", "reference", "ground", "np", "n_samples", "branch")
"""Columns of every log, the basement frame, and names that generated modules use."""

_MINIMAL = re.compile(r"X\d+")


def declaration_faults(
    name: object,
    elements: Sequence[object],
    drives: Sequence[object],
    sensors: Sequence[object],
    known: object,
) -> tuple[str, ...]:
    """Every fault of an axis declaration; empty if it is sound.

    Faults of types are reported alone, because nothing else can be checked while they last.
    """
    faults = tuple(type_faults(name, elements, drives, sensors))
    if faults:
        return faults
    checked_drives = [drive for drive in drives if isinstance(drive, Drive)]
    bodies = [element for element in elements if isinstance(element, Body)]
    checked_sensors = [sensor for sensor in sensors if isinstance(sensor, Sensor)]
    return (
        *_name_faults(elements, checked_drives, checked_sensors),
        *_body_faults(bodies),
        *_reference_faults(bodies, (*elements, *checked_drives, *checked_sensors)),
        *_number_faults(elements, checked_drives, checked_sensors),
        *drive_faults(checked_drives),
        *sensor_faults(elements, checked_drives, checked_sensors),
        *drive_imperfection_faults(elements, checked_drives),
        *_joint_faults((*elements, *checked_drives)),
        *_connection_faults(bodies, elements, checked_drives),
        *imperfection_faults(elements, checked_sensors),
        *_known_faults((*elements, *checked_sensors), checked_drives, known),
    )


def _name_faults(
    elements: Sequence[object], drives: Sequence[Drive], sensors: Sequence[Sensor]
) -> Iterator[str]:
    signals = [*(drive.signal for drive in drives), *(sensor.signal for sensor in sensors)]
    commands = [drive.command for drive in drives if drive.command]
    parameters = [name for element in (*elements, *sensors) for name in parameters_in(element)]
    names = [element.name for element in elements if isinstance(element, (Body, Spring, Damper))]
    for name in dict.fromkeys([*signals, *parameters, *names, *commands]):
        if not is_signal_name(name):
            yield f"name {name!r} is not usable: letters, digits and underscores, and no ending like _d1"
    for what, given in (("signal", signals), ("command", commands), ("element name", names)):
        for name in _repeated(given):
            yield f"{what} {name!r} is used more than once: give each a separate one"
    for name in sorted({*signals} & {*parameters}):
        yield f"{name!r} names a signal and a parameter: rename one of them"
    for name in sorted({*signals, *parameters, *names}):
        if name in RESERVED or keyword.iskeyword(name) or (name in parameters and _MINIMAL.fullmatch(name)):
            yield f"name {name!r} is reserved: choose another"


def parameters_in(element: object) -> tuple[str, ...]:
    """Names of the physical parameters of one element."""
    if isinstance(element, Law):
        return tuple(term.parameter for term in element.terms())
    if not isinstance(element, Parametrised):
        return ()
    return tuple(
        element.named(field) for field in PARAMETER_FIELDS if getattr(element, field, None) is not None
    )


def _known_faults(elements: Sequence[object], drives: Sequence[Drive], known: object) -> Iterator[str]:
    """Faults of the values of known parameters."""
    if not isinstance(known, Mapping):
        yield f"known={known!r} must be a mapping of names of parameters to values"
        return
    holders = [element for element in elements if isinstance(element, (Parametrised, Law))]
    names = {name for element in holders for name in parameters_in(element)}
    names |= {drive.constant for drive in drives if drive.constant is not None}
    signed = {term.parameter for e in holders if isinstance(e, Law) for term in e.terms() if term.signed}
    sensors = [element for element in holders if isinstance(element, Sensor)]
    signed |= {sensor.named("offset") for sensor in sensors if sensor.offset is not None}
    gains = {sensor.named("gain") for sensor in sensors if sensor.gain is not None}
    written = [pair for element in holders for pair in element.numbers().items()]
    for name in _repeated(name for name, _ in dict.fromkeys(written)):
        yield f"{name!r} has several values: give these parameters separate names, and their values in known="
    for name, value in (*written, *known.items()):
        if name not in names:
            yield f"known: there is no parameter {name!r}: choose from {', '.join(sorted(names))}"
        elif not is_finite(value) or (value < 0 and name not in signed):
            range_ = "a finite number" if name in signed else "a finite number of at least 0"
            yield f"the known value of {name!r} is {value!r}: it must be {range_}"
        elif name in gains and value == 0:
            yield f"the known value of {name!r} is {value!r}: the gain of a sensor must be positive"
    if names and names <= {*known, *(name for name, _ in written)}:
        yield "every parameter is known: give the one that is to be identified a name"


def _body_faults(bodies: Sequence[Body]) -> Iterator[str]:
    if not bodies:
        yield "there is no body: declare Body(name, mass=PARAMETER)"
    for body in bodies:
        if (body.mass is None) == (body.inertia is None):
            yield f"body {body.name!r} needs either mass= (it slides) or inertia= (it turns)"
        elif isinstance(body.on, Body) and body.on.turns and not body.turns:
            yield f"body {body.name!r} slides on {body.on.name!r}, which turns: put it on the ground and gear it"
        drivers = [gear.to for gear in body.gears]
        if body in drivers:
            yield f"body {body.name!r} is geared to itself: gear it to another body"
        for name in _repeated(driver.name for driver in drivers):
            yield f"body {body.name!r} is geared to {name!r} more than once: add up the ratios"


def _reference_faults(bodies: Sequence[Body], holders: Sequence[object]) -> Iterator[str]:
    names = [body.name for body in bodies]
    for holder in holders:
        for body in _bodies_of(holder):
            if body not in bodies:
                near = get_close_matches(body.name, names, 1)
                hint = f", or did you mean {near[0]!r}?" if near and near[0] != body.name else ""
                yield f"{label_of(holder)} refers to body {body.name!r}, which is not among the elements: add it{hint}"


def _bodies_of(holder: object) -> Iterator[Body]:
    """Bodies that an element refers to."""
    if isinstance(holder, Body):
        candidates: tuple[object, ...] = (holder.on, *(gear.to for gear in holder.gears))
    else:
        at = getattr(holder, "at", None)
        ends = (at.first, at.second) if isinstance(at, Between) else (at,)
        candidates = (*ends, getattr(holder, "body", None), getattr(holder, "relative_to", None))
    return (candidate for candidate in candidates if isinstance(candidate, Body))


def _number_faults(
    elements: Sequence[object], drives: Sequence[Drive], sensors: Sequence[Sensor]
) -> Iterator[str]:
    numbers: list[tuple[str, object]] = []
    for holder in (*elements, *drives):
        at = getattr(holder, "at", None)
        if isinstance(at, Between):
            numbers.append((f"{label_of(holder)}: ratio", at.ratio))
        if isinstance(holder, Body):
            numbers += [(f"{label_of(holder)}: ratio", gear.ratio) for gear in holder.gears]
        if isinstance(holder, (Weight, PendulumWeight)):
            numbers.append((f"{label_of(holder)}: acceleration", holder.acceleration))
        if isinstance(holder, (Law, Imperfection)):
            yield from (f"{label_of(holder)}: {fault}" for fault in holder.faults())
    for holder in (*drives, *sensors):
        for field in ("noise", "resolution", "delay"):
            value = getattr(holder, field, 0.0)
            if not is_finite(value) or value < 0:
                yield f"{label_of(holder)}: {field} is {value!r}: it must be a finite number of at least 0"
    for sensor in sensors:
        of, to = getattr(sensor, "body", None), getattr(sensor, "relative_to", None)
        ratio = getattr(sensor, "ratio", None)
        if ratio is not None and to is None:
            yield f"{label_of(sensor)}: ratio scales the body that relative_to= names: give that too"
        elif ratio is not None:
            numbers.append((f"{label_of(sensor)}: ratio", ratio))
        if ratio is None and isinstance(of, Body) and isinstance(to, Body) and of.turns != to.turns:
            yield (
                f"{label_of(sensor)} subtracts {'an angle' if to.turns else 'a displacement'} from "
                f"{'an angle' if of.turns else 'a displacement'}: measure {of.name!r} alone, "
                f"relative to a body that {'turns' if of.turns else 'slides'}, or with the ratio= of a deflection"
            )
    numbers += [(f"{label_of(d)}: gain", d.gain) for d in drives if d.gain is not None and d.constant is None]
    for what, value in numbers:
        if not is_finite(value) or value == 0:
            yield f"{what} is {value!r}: it must be a finite number other than 0"


def _joint_faults(holders: Sequence[object]) -> Iterator[str]:
    for holder in holders:
        at = getattr(holder, "at", None)
        if isinstance(at, Between):
            if at.first == at.second:
                yield f"{label_of(holder)} lies between {at.first.name!r} and itself: name two bodies"
            kinds = {end.turns for end in (at.first, at.second) if isinstance(end, Body)}
            if len(kinds) == 2 and at.ratio == 1:
                yield f"{label_of(holder)} joins a turning and a sliding body: give the ratio in metres per radian"
        if isinstance(holder, Weight) and holder.body.turns:
            yield f"{label_of(holder)}: a weight acts on a sliding body; use PendulumWeight where it turns"
        if isinstance(holder, PendulumWeight) and not holder.body.turns:
            yield f"{label_of(holder)}: a pendulum weight acts on a turning body; use Weight where it slides"


def _connection_faults(
    bodies: Sequence[Body], elements: Sequence[object], drives: Sequence[Drive]
) -> Iterator[str]:
    """Bodies that no drive can move: no spring, damper, law, gear or common parent leads to them."""
    links = [ends_of(getattr(holder, "at", None)) for holder in (*elements, *drives)]
    links += [(body.name, gear.to.name) for body in bodies for gear in body.gears]
    # The inertia force of a body acts on what it is on only through its coordinate, which a law or a spring must hold.
    reached = {name for drive in drives for name in ends_of(drive.at)} - {"ground"}
    while True:
        grown = reached | {name for link in links if reached & set(link) for name in link} - {"ground"}
        if grown == reached:
            break
        reached = grown
    for body in bodies:
        if body.name not in reached:
            cannot = "the drive cannot" if len(drives) == 1 else "no drive can"
            yield f"{cannot} move body {body.name!r}: join it by a spring, a damper or a gear to the others"


def _repeated(names: Iterable[str]) -> list[str]:
    return sorted(name for name, count in Counter(names).items() if count > 1)
