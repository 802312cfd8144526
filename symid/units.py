"""Units of signals and parameters as products of powers of base units.

Parameters need only an exact algebra of exponents (`Unit`). Units that users write in log headers are
read by pint (`to_si`), which knows them all.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from symid.errors import LogError

if TYPE_CHECKING:
    import pint

BASE_UNITS = ("kg", "A", "V", "m", "s", "rad")
"""Base units in printing order. The volt is kept as its own unit: drives are often identified in volts."""


@dataclass(frozen=True)
class Unit:
    """A product of powers of base units.

    Parameters
    ----------
    exponents : tuple of int
        One exponent for each of `BASE_UNITS`.

    Examples
    --------
    >>> newton = Unit.of("N")
    >>> str(newton / Unit.of("m") * Unit.of("s"))
    'N*s/m'
    >>> str(Unit.of("kg") * Unit.of("s") ** 2)
    'kg*s^2'
    """

    exponents: tuple[int, ...] = (0,) * len(BASE_UNITS)

    @classmethod
    def of(cls, name: str) -> Unit:
        """Unit named by one of the symbols that symid prints, such as ``"N"`` or ``"kg"``."""
        return _NAMED[name]

    @staticmethod
    def is_named(name: str) -> bool:
        """Whether `of` knows a symbol."""
        return name in _NAMED

    def __mul__(self, other: Unit) -> Unit:
        return Unit(tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __truediv__(self, other: Unit) -> Unit:
        return Unit(tuple(a - b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __pow__(self, power: int) -> Unit:
        return Unit(tuple(power * a for a in self.exponents))

    def __str__(self) -> str:
        return _symbol_of(self)

    def __repr__(self) -> str:
        return f"Unit({str(self)!r})"


def _base(name: str) -> Unit:
    return Unit(tuple(int(name == base) for base in BASE_UNITS))


_WRITTEN = re.compile(r"[\w\s*/^().%°·⋅×⁻+-]*")
"""What units are written in; pint passes over any other sign."""

_METRE, _SECOND, _NEWTON = _base("m"), _base("s"), _base("kg") * _base("m") / _base("s") ** 2
_NAMED: dict[str, Unit] = {
    "1": Unit(),
    **{name: _base(name) for name in BASE_UNITS},
    "N": _NEWTON,
    "N*m": _NEWTON * _METRE,
    "m/s": _METRE / _SECOND,
    "m/s^2": _METRE / _SECOND**2,
    "N/m": _NEWTON / _METRE,
    "N*s/m": _NEWTON * _SECOND / _METRE,
    "N/rad": _NEWTON / _base("rad"),
    "N*s/rad": _NEWTON * _SECOND / _base("rad"),
    "N*m/rad": _NEWTON * _METRE / _base("rad"),
    "N*m*s/rad": _NEWTON * _METRE * _SECOND / _base("rad"),
    "rad/s": _base("rad") / _SECOND,
    "rad/s^2": _base("rad") / _SECOND**2,
    "kg*m^2": _NEWTON * _METRE * _SECOND**2 / _base("rad"),  # an inertia: torque per angular acceleration
    "kg*m": _NEWTON * _SECOND**2,
}
_SYMBOLS = {unit: name for name, unit in _NAMED.items()}


def _symbol_of(unit: Unit) -> str:
    """Named unit if there is one, else the product of base units with negative powers behind one slash each."""
    if unit in _SYMBOLS:
        return _SYMBOLS[unit]
    powers = [(name, power) for name, power in zip(BASE_UNITS, unit.exponents, strict=True) if power]
    above = "*".join(_power(name, power) for name, power in powers if power > 0)
    below = "".join("/" + _power(name, -power) for name, power in powers if power < 0)
    return (above or "1") + below


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


@cache
def _registry() -> pint.UnitRegistry[float]:
    # pint takes half a second to load; logs in plain SI never need it.
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=False)


@cache
def to_si(text: str, expected: Unit | None = None) -> float:
    """Factor that takes a quantity from a written unit to SI base units.

    Parameters
    ----------
    text : str
        A unit as users write it: ``"mm"``, ``"deg/s"``, ``"kN"``, ``"um"``.
    expected : Unit, optional
        What the signal must be measured in. Angles count as dimensionless, as in pint.

    Returns
    -------
    float
        Multiply a value in `text` by this to have it in SI.

    Raises
    ------
    LogError
        If the unit is unknown, has an offset (degC), or has not the expected dimension.

    Examples
    --------
    >>> to_si("mm")
    0.001
    """
    if expected is not None and text == str(expected):
        return 1.0
    registry = _registry()
    try:
        if not _WRITTEN.fullmatch(text):
            raise ValueError(text)
        quantity = registry.Quantity(1.0, registry.parse_units(text)).to_base_units()
    except Exception as error:
        raise LogError(
            f"unit {text!r} is not known: write a unit such as m, mm, um, rad, deg, N, kN, A or V"
        ) from error
    if expected is not None:
        wanted = registry.parse_units(str(expected).replace("^", "**"))
        if quantity.dimensionality != wanted.dimensionality:
            raise LogError(
                f"unit {text!r} does not measure what is expected here: give a unit that converts to {expected}"
            )
        return float(quantity.to(wanted).magnitude)
    return float(quantity.magnitude)
