"""Parser of units in headers and options, which interprets a unit for its signal.

    unit   = ["/"] factor { ["*" | "·" | " " | "/" | "per"] factor }
    factor = number | name [power] | "(" unit ")"

A power is a small integer. Length and nesting are limited, so that no text takes long to parse.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from symid.errors import LogError
from symid.units.names import COUNT_UNITS, PER_TURN, UNIT_NAMES
from symid.units.unit import BASE_UNITS, Unit

_LONGEST: Final = 60
_DEEPEST: Final = 4
_LARGEST_POWER: Final = 9
_TOKEN: Final = re.compile(
    r"""\s*(?:
      (?P<number>\d+(?:\.\d+)?(?:[eE][-+]?\d{1,3})?)(?![\d_.])
    | (?P<name>(?:(?![⁻⁺¹²³⁴])[^\W\d_])+0?|°)
      (?P<power>(?:\s?(?:\^|\*\*)\s?[-+]?\d+|-?[1-9]|[⁻⁺]?[¹²³⁴]+)(?![\w.^]|\*\*))?
    | (?P<times>[*·⋅×.])
    | (?P<over>/)
    | (?P<open>\()
    | (?P<close>\))
    )""",
    re.VERBOSE,
)
_SUPERSCRIPTS: Final = str.maketrans("⁻⁺¹²³⁴", "-+1234")
_NONE: Final = Unit()
_RADIAN: Final = Unit.of("rad")
_TURNS: Final = BASE_UNITS.index("rad")
_SQUARED: Final = re.compile(r"\b(k?g)(?=[cm]?m(?:\^2|\*\*2|²|2)(?!\w))")
"""Mass of an inertia that is written as one word, kgcm^2."""
_ACCELERATION: Final = Unit.of("m/s^2")
_ROTATIONS: Final = (Unit.of("rad/s"), Unit.of("rad/s^2"))
_GRAVITY: Final = {"g": 9.80665, "mg": 9.80665e-3}
_CLOCKED: Final = ("Hz", "min")
"""Endings of names that make a frequency count turns, not radians."""


@dataclass(frozen=True)
class _Read:
    """A parsed unit: factor to SI, unit, the names in it, and its number if it has one."""

    factor: float = 1.0
    unit: Unit = _NONE
    names: tuple[str, ...] = ()
    number: float | None = None

    def times(self, other: _Read, power: int = 1) -> _Read:
        """Product with a power of another unit."""
        number = other.number if self.number is None else self.number
        factor = self.factor * other.factor**power
        return _Read(factor, self.unit * other.unit**power, self.names + other.names, number)


@lru_cache(maxsize=1024)
def to_si(text: str, expected: Unit | None = None) -> float:
    """Factor from a written unit to SI base units.

    Parameters
    ----------
    text : str
        A unit as users write it: ``"mm"``, ``"deg/s"``, ``"kN"``, ``"1/min"``, ``"4096 counts/rev"``.
    expected : Unit, optional
        Unit that the signal must have. For an angular velocity, ``Hz`` and ``1/min`` count turns; for an acceleration,
        ``g`` is that of gravity; for a position, counts per turn or length are accepted.

    Returns
    -------
    float
        A value in the written unit times this factor is the value in SI.

    Raises
    ------
    LogError
        If the unit is unknown, ambiguous, or of another quantity than expected.

    Examples
    --------
    >>> to_si("mm"), round(to_si("1/min", Unit.of("rad/s")), 6), round(to_si("4096 counts/rev", Unit.of("rad")), 6)
    (0.001, 0.10472, 0.001534)
    >>> to_si("kgcm²", Unit.of("kg*m^2")), to_si("50counts/m", Unit.of("m"))
    (0.0001, 0.02)
    """
    given = text.strip()
    if expected is not None and given == str(expected):
        return 1.0
    if expected == _ACCELERATION and given in _GRAVITY:
        return _GRAVITY[given]
    read = _parsed(text)
    factor = read.factor if expected is None else _in(expected, read, text)
    if not (math.isfinite(factor) and factor > 0.0):
        raise LogError(f"unit {_quoted(text)} is not possible: write a unit such as m, mm or rad")
    if expected is None and (read.unit == Unit() or _is_counted(read)):
        raise _says_nothing(text)
    return factor


def _in(expected: Unit, read: _Read, text: str) -> float:
    """Factor to an expected unit."""
    counted = _is_counted(read)
    if read.unit == expected and not counted:
        return read.factor
    turns = expected.exponents[_TURNS]
    if turns < 0 and read.unit * _RADIAN**turns == expected and not counted:
        return read.factor  # an inertia in kg*cm^2, a stiffness in N*m: the radian is not written
    if expected in (Unit.of("m"), _RADIAN) and read.unit * expected == Unit() and (read.number or 1.0) > 1.0:
        return 1.0 / read.factor  # counts per turn or per length
    if expected in _ROTATIONS and expected / read.unit == _RADIAN and not counted:
        if any(name.endswith(_CLOCKED) for name in read.names):
            return 2.0 * math.pi * read.factor
        raise LogError(f"unit {_quoted(text)} may count radians or turns: write for example rad/s or rev/s")
    if counted or read.unit == Unit():
        raise _says_nothing(text)
    raise LogError(
        f"unit {_quoted(text)} does not measure what is expected here: give a unit that converts to {expected}"
    )


def _is_counted(read: _Read) -> bool:
    return any(name in COUNT_UNITS for name in read.names)


def _says_nothing(text: str) -> LogError:
    return LogError(
        f"unit {_quoted(text)} has no known size: write a unit such as mm or deg, what one count is "
        "(0.1 um), or the counts per turn or length (4096 counts/rev, 1000 counts/mm)"
    )


def _quoted(text: str) -> str:
    return repr(text if len(text) <= _LONGEST else text[:_LONGEST] + "...")


def _parsed(text: str) -> _Read:
    """Parse a unit; LogError if the text is not a unit."""
    unknown = LogError(
        f"unit {_quoted(text)} is not known: write a unit such as m, mm, um, rad, deg, N, kN, A or V"
    )
    given = _SQUARED.sub(r"\1*", re.sub(r"\b(?:per|pro)\b", "/", text.strip()))
    if given in ("", "-", "1", "%"):
        raise _says_nothing(text)
    if given == "grad":
        raise LogError("unit 'grad' may be a degree or a gon: write deg or gon")
    if len(given) > _LONGEST:
        raise unknown
    try:
        read, rest = _product(given, 0)
    except (KeyError, ValueError, OverflowError, ZeroDivisionError) as error:
        raise unknown from error
    if rest:
        raise unknown
    return read


def _product(text: str, depth: int) -> tuple[_Read, str]:
    """The product at the start of a text, and the rest of the text; ValueError without a product."""
    read, sign, wanted = _Read(), 1, True
    while text.strip():
        token = _TOKEN.match(text)
        if token is None:
            raise ValueError(text)
        if token["close"]:
            break
        text = text[token.end() :]
        if token["over"] or token["times"]:
            if wanted and (read != _Read() or token["times"]):
                raise ValueError(text)
            sign, wanted = (-1 if token["over"] else 1), True
            continue
        if token["open"]:
            if depth == _DEEPEST:
                raise ValueError(text)
            factor, text = _product(text, depth + 1)
            if not text.startswith(")"):
                raise ValueError(text)
            text = text[1:]
        else:
            factor = _factor(token)
        read, sign, wanted = read.times(factor, sign), 1, False
    if wanted:
        raise ValueError(text)
    return read, text.lstrip()


def _factor(token: re.Match[str]) -> _Read:
    """A number, or a name with its power."""
    if token["number"]:
        return _Read(float(token["number"]), number=float(token["number"]))
    name = token["name"]
    power = int((token["power"] or "1").translate(_SUPERSCRIPTS).replace("**", "").lstrip(" ^"))
    if abs(power) > _LARGEST_POWER:
        raise ValueError(name)
    if name in COUNT_UNITS:
        return _Read(names=(name,))
    if name in PER_TURN:
        return _Read(1.0 / (2.0 * math.pi), Unit() / _RADIAN, (name,))
    factor, unit = UNIT_NAMES[name]
    return _Read(factor**power, unit**power, (name,))
