"""An axis as the text of an axis file: bodies as variables, then ``axis = Axis(...)``."""

from __future__ import annotations

import json
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import Field, dataclass, fields, is_dataclass, replace
from pathlib import Path

from symid.axis.axis import Axis
from symid.axis.elements import Between, Body, Drive, Ground, Spring
from symid.axis.loading import of_any_axis
from symid.errors import SettingError, SymidError
from symid.files import write_whole
from symid.signal_names import is_signal_name

_WIDTH = 88
"""Longest line. A longer call has one argument per line, which formatters of longer lines leave as it is."""
_NAMED = ("mass", "inertia", "stiffness", "damping")
"""Fields that are written with their name wherever they stand."""


@of_any_axis
def axis_source(axis: Axis, summary: str | None = None) -> str:
    """Text of the axis file that declares an axis.

    Parameters
    ----------
    axis : Axis
        The axis; all its laws must be those of symid.
    summary : str, optional
        First line of the file; the name and bodies of the axis by default.

    Raises
    ------
    SettingError
        If a law is a class of the user's own, which the file would not know.

    Examples
    --------
    >>> from symid.axis import StribeckFriction, load_axis
    >>> axis = load_axis("rigid_1m")
    >>> print(axis_source(axis.with_effect(StribeckFriction(axis.bodies[0], "dF", velocity=0.05))))
    \"""Axis rigid_1m: motor.\"""
    <BLANKLINE>
    from symid import (
        Axis,
        Body,
        CoulombFriction,
        Drive,
        Position,
        StribeckFriction,
        ViscousFriction,
    )
    <BLANKLINE>
    motor = Body("motor", mass="M")
    <BLANKLINE>
    axis = Axis(
        "rigid_1m",
        elements=(
            motor,
            ViscousFriction(motor, "Fv"),
            CoulombFriction(motor, "Fs"),
            StribeckFriction(motor, "dF", velocity=0.05),
        ),
        drive=Drive("F", motor),
        sensors=(Position("q", motor),),
    )
    <BLANKLINE>
    """
    for element in (*axis.laws, *axis.sensors):
        if not type(element).__module__.startswith("symid.axis."):
            raise SettingError(
                f"{type(element).__name__} of axis {axis.name!r} is not a class of symid, which an axis file "
                f"that is written cannot use: copy the file that declares it, and edit the copy"
            )
    calls = set(_classes(axis))
    variables = _variables(axis, {*calls, "axis"})

    def assignment(name: str, value: object) -> str:
        others = {other: name for other, name in variables.items() if other is not value}
        return _call(value, others).written(f"{name} = ", 0)

    bodies = [assignment(variables[body], body) for body in _in_order(axis.bodies)]
    joints = [assignment(name, at) for at, name in variables.items() if isinstance(at, Between)]
    read = [assignment(name, it) for it, name in variables.items() if isinstance(it, (Spring, Drive))]
    plain = summary or f"Axis {axis.name}: {', '.join(body.name for body in axis.bodies)}."
    plain = plain.replace("\\", "/").replace('"', "'")
    blocks = (
        textwrap.fill(f'"""{plain.strip()}', 110, break_long_words=False) + '"""',
        _import(calls),
        "\n".join(bodies),
        "\n".join([*joints, *read]),
        assignment("axis", axis),
    )
    return "\n\n".join(block for block in blocks if block) + "\n"


def declared_lines(axis: Axis) -> list[str]:
    """The declaration of each element, drive and sensor as an axis file writes it, bodies by their names.

    >>> from symid.axis import load_axis
    >>> declared_lines(load_axis("rigid_1m"))[:2]
    ['Body("motor", mass="M")', 'ViscousFriction(motor, "Fv")']
    """
    variables = _variables(axis, set())
    values = (*axis.elements, *axis.drives, *axis.sensors)
    return [
        _call(value, {other: name for other, name in variables.items() if other is not value}).written("", 0)
        for value in values
    ]


def axis_path(file: str | Path) -> Path:
    """Path of an axis file to be written.

    Raises
    ------
    SettingError
        If its name cannot be that of an axis.

    Examples
    --------
    >>> axis_path("models/my_axis.py").stem
    'my_axis'
    """
    path = Path(file)
    if path.suffix != ".py" or not is_signal_name(path.stem):
        raise SettingError(
            f"axis file {path.name!r} cannot name an axis: use NAME.py, NAME of letters, digits and underscores, "
            "without an ending such as _d2, which is that of a derivative"
        )
    return path


@of_any_axis
def write_axis(axis: Axis, file: str | Path, summary: str | None = None) -> Axis:
    """Write an axis to a file, from which `load_axis` reads it; an existing file is overwritten.

    Parameters
    ----------
    axis : Axis
        The axis.
    file : str or Path
        A file NAME.py. The axis is called NAME in it.
    summary : str, optional
        As in `axis_source`.

    Returns
    -------
    Axis
        The axis under its new name.

    Raises
    ------
    SettingError
        If the file's name cannot be that of an axis, or a law or sensor is not a class of symid.
    SymidError
        If the file cannot be written.
    """
    path = axis_path(file)
    named = replace(axis, name=path.stem)
    text = axis_source(named, summary)
    try:
        write_whole(path, text)
    except OSError as error:
        raise SymidError(f"axis file {str(path)!r} cannot be written: {error.strerror}") from error
    return named


@dataclass(frozen=True)
class _Call:
    """A call, or a tuple if it has no name, with its arguments as text or as further calls."""

    name: str
    arguments: tuple[tuple[str, _Call | str], ...]

    def written(self, first: str, indent: int, last: str = "") -> str:
        """Text after `first`, on one line if that and `last` fit, else with one argument per line."""
        line = f"{' ' * indent}{first}{self.in_line}{last}"
        if len(line) <= _WIDTH:
            return line
        inner = indent + 4
        lines = [
            argument.written(key, inner, ",")
            if isinstance(argument, _Call)
            else f"{' ' * inner}{key}{argument},"
            for key, argument in self.arguments
        ]
        return "\n".join([f"{' ' * indent}{first}{self.name}(", *lines, f"{' ' * indent}){last}"])

    @property
    def in_line(self) -> str:
        """Text with all white space as single spaces."""
        inside = ", ".join(
            key + (argument.in_line if isinstance(argument, _Call) else argument)
            for key, argument in self.arguments
        )
        single = not self.name and len(self.arguments) == 1
        return f"{self.name}({inside}{',' if single else ''})"


def _text(value: object, variables: Mapping[object, str]) -> _Call | str:
    """A value as text, or as a call if it is a record or a tuple."""
    if isinstance(value, tuple):
        return _Call("", tuple(("", _text(item, variables)) for item in value))
    if isinstance(value, Ground):
        return "GROUND"
    if isinstance(value, (Body, Between, Spring, Drive)) and value in variables:
        return variables[value]
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float):
        return repr(float(value))
    if value is None or isinstance(value, int):
        return repr(value)
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{json.dumps(name)}: {_text(item, {})}' for name, item in value.items())}}}"
    return _call(value, variables)


def _call(value: object, variables: Mapping[object, str]) -> _Call:
    """The call that makes a record: its first fields without their names, no field that has its default."""
    arguments: list[tuple[str, _Call | str]] = []
    named = False
    for field in sorted(fields(value), key=lambda field: bool(field.kw_only)):  # type: ignore[arg-type]  # a dataclass
        content = getattr(value, field.name)
        if _is_default(field, content):
            named = True
            continue
        named = named or bool(field.kw_only) or field.name in _NAMED
        named = named or not isinstance(content, (str, Body, Between, Spring, Drive))
        arguments.append((f"{field.name}=" if named else "", _text(content, variables)))
    return _Call(type(value).__name__, tuple(arguments))


def _is_default(field: Field[object], content: object) -> bool:
    """Whether a field can be left out; 1 and 1.0 are not the same to the signature of an axis."""
    if isinstance(content, Mapping):
        return not content
    return type(content) is type(field.default) and content == field.default


def _classes(value: object) -> Iterator[str]:
    """Names of the classes of all records in a value."""
    if isinstance(value, tuple):
        for item in value:
            yield from _classes(item)
    elif is_dataclass(value):
        yield "GROUND" if isinstance(value, Ground) else type(value).__name__
        for field in fields(value):
            if not _is_default(field, content := getattr(value, field.name)):
                yield from _classes(content)


def _variables(axis: Axis, taken: set[str]) -> dict[object, str]:
    """Names for the bodies, for pairs of bodies between which several elements lie, and for what force sensors read."""
    names: dict[object, str] = {}

    def give(value: object, name: str) -> None:
        while name in taken or name in names.values():
            name += "_"
        names[value] = name

    for body in axis.bodies:
        give(body, body.name)
    holders = (*axis.elements, *axis.drives)
    counted = Counter(at for holder in holders if isinstance(at := getattr(holder, "at", None), Between))
    for at, count in counted.items():
        if count > 1:
            give(at, f"{at.first.name}_{at.second.name}")
    for sensor in axis.sensors:
        if (read := sensor.element) is not None and read not in names:
            give(read, read.name if isinstance(read, Spring) else "drive")
    return names


def _in_order(bodies: tuple[Body, ...]) -> list[Body]:
    """Bodies after those that carry or turn them."""
    ordered: dict[Body, None] = {}

    def place(body: Body) -> None:
        for other in (body.on, *(gear.to for gear in body.gears)):
            if isinstance(other, Body):
                place(other)
        ordered.setdefault(body)

    for body in bodies:
        place(body)
    return list(ordered)


def _import(names: set[str]) -> str:
    ordered = sorted(names, key=lambda name: (not name.isupper(), name))
    line = f"from symid import {', '.join(ordered)}"
    if len(line) <= _WIDTH:
        return line
    return "\n".join(["from symid import (", *(f"    {name}," for name in ordered), ")"])
