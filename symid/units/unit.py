"""Units of signals and parameters as products of powers of base units: an exact algebra of exponents."""

from __future__ import annotations

from dataclasses import dataclass

BASE_UNITS = ("kg", "A", "V", "m", "s", "rad")
"""Base units in printing order. The volt is one of them, since drives are often identified in volts."""


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
        """Unit with a symbol that symid prints, such as ``"N"`` or ``"kg"``."""
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
        """Symbol of a named unit, else a product of base units, with a slash before each negative power."""
        if self in _SYMBOLS:
            return _SYMBOLS[self]
        powers = [(name, power) for name, power in zip(BASE_UNITS, self.exponents, strict=True) if power]
        above = "*".join(_power(name, power) for name, power in powers if power > 0)
        below = "".join("/" + _power(name, -power) for name, power in powers if power < 0)
        return (above or "1") + below

    def __repr__(self) -> str:
        return f"Unit({str(self)!r})"


def _base(name: str) -> Unit:
    return Unit(tuple(int(name == base) for base in BASE_UNITS))


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
    **{
        f"{name}/{base}": force / _base(base)  # the constant of a drive
        for name, force in (("N", _NEWTON), ("N*m", _NEWTON * _METRE))
        for base in ("A", "V")
    },
}
_SYMBOLS = {unit: name for name, unit in _NAMED.items()}


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"
