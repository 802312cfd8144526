"""Result of an export: its files, and the parts of the axis that they do not model."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from symid.axis import Axis, Imperfection
from symid.errors import SettingError
from symid.simulation import plant_of


@dataclass(frozen=True)
class Exported:
    """An axis in the language of another program."""

    files: Mapping[str, str]
    """Texts by file suffix, the main file first."""
    losses: tuple[str, ...]
    """Parts of the axis that the target cannot express, one sentence each."""

    @property
    def text(self) -> str:
        """Text of the main file."""
        return next(iter(self.files.values()))

    @property
    def whole(self) -> str:
        """All files as one text: included files precede the main one."""
        main, *others = self.files.values()
        lines = (line for line in main.splitlines(keepends=True) if not line.startswith('#include "'))
        return "\n".join([*others, "".join(lines)])


class TextTarget(NamedTuple):
    """A format whose files are texts made of an axis and the values of its parameters, SI."""

    name: str  # as `symid export --to` takes it
    program: str  # the program or language, as the help of the command names it
    write: Callable[[Axis, Mapping[str, float]], Exported]


def require_physical(axis: Axis, values: Mapping[str, float]) -> None:
    """SettingError if no machine has such values: a mass that is not positive, stiffness or friction below zero.

    >>> from symid.axis import load_axis
    >>> require_physical(load_axis("rigid_1m"), {"M": 100.0, "Fv": 80.0, "Fs": 40.0})
    """
    unsigned = [name for name in axis.physical_parameters if name not in axis.signed_parameters]
    if below := [f"{name} {values[name]:g}" for name in unsigned if values[name] < 0]:
        raise SettingError(
            f"{', '.join(below)} of axis {axis.name!r} must not be negative: nothing is exported; give values that a "
            "machine can have, such as those identified with `bounds=physical`"
        )
    plant_of(axis, values)


def losses_of_imperfections(
    axis: Axis, program: str, held: tuple[type[Imperfection], ...] = ()
) -> Iterator[str]:
    """Losses of a format that has imperfections of the given kinds only.

    >>> from symid.axis import ActuatorDelay, load_axis
    >>> list(losses_of_imperfections(load_axis("rigid_1m").with_effect(ActuatorDelay(1e-3)), "URDF"))
    ['ActuatorDelay: URDF has no such element; left out: f(t) = F(t - 0.001 s).']
    """
    for element in axis.imperfections:
        if not isinstance(element, held):
            yield f"{type(element).__name__}: {program} has no such element; left out: {element.formula}."


def losses_of_signals(axis: Axis) -> Iterator[str]:
    """Losses of every format: parameters that differ from log to log, and noise of the recorded force.

    >>> from symid.axis import load_axis
    >>> list(losses_of_signals(load_axis("motor_bench")))
    ['Pt: it differs from log to log; give 0 for an axis whose zeros are known.']
    """
    for name in axis.log_parameters:
        yield f"{name}: it differs from log to log; give 0 for an axis whose zeros are known."
    for drive in axis.drives:
        if drive.noise or drive.resolution:
            yield f"{drive.signal}: noise and resolution of the recorded force are left out."
