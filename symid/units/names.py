"""Names of units as drives, scopes and users write them, with their factors to SI."""

import math
from typing import Final

from symid.units.unit import Unit

_TURN: Final = 2.0 * math.pi
_SECOND, _METRE, _RADIAN = Unit.of("s"), Unit.of("m"), Unit.of("rad")
_NEWTON, _TORQUE, _HERTZ = Unit.of("N"), Unit.of("N*m"), Unit() / _SECOND

_MICRO: Final = dict.fromkeys("uµμ", 1e-6)
_PREFIXES: Final = {
    "p": 1e-12,
    "n": 1e-9,
    **_MICRO,
    "m": 1e-3,
    "c": 1e-2,
    "d": 0.1,
    "da": 10.0,
    "k": 1e3,
    "M": 1e6,
}
_LONG_PREFIXES: Final = {"nano": 1e-9, "micro": 1e-6, "milli": 1e-3, "centi": 1e-2, "kilo": 1e3}

_SYMBOLS: Final[tuple[tuple[str, float, Unit, str], ...]] = (
    ("s", 1.0, _SECOND, "p n u µ μ m"),
    ("m", 1.0, _METRE, "p n u µ μ m c d k"),
    ("rad", 1.0, _RADIAN, "n u µ μ m"),
    ("deg", math.radians(1.0), _RADIAN, "u µ μ m"),
    ("g", 1e-3, Unit.of("kg"), "m k"),
    ("N", 1.0, _NEWTON, "u µ μ m c d da k M"),
    ("Nm", 1.0, _TORQUE, "u µ μ m c d da k M"),
    ("A", 1.0, Unit.of("A"), "n u µ μ m k"),
    ("V", 1.0, Unit.of("V"), "n u µ μ m k"),
    ("Hz", 1.0, _HERTZ, "m k M"),
)
"""Symbols with the prefixes allowed for them: no machine is measured in megametres or gigaradians."""

_LONG: Final[tuple[tuple[str, float, Unit], ...]] = (
    ("second", 1.0, _SECOND),
    ("meter", 1.0, _METRE),
    ("metre", 1.0, _METRE),
    ("radian", 1.0, _RADIAN),
    ("degree", math.radians(1.0), _RADIAN),
    ("gram", 1e-3, Unit.of("kg")),
    ("newton", 1.0, _NEWTON),
    ("ampere", 1.0, Unit.of("A")),
    ("amp", 1.0, Unit.of("A")),
    ("volt", 1.0, Unit.of("V")),
    ("hertz", 1.0, _HERTZ),
)

_OTHERS: Final[tuple[tuple[str, float, Unit], ...]] = (
    ("sec Sek Sekunde Sekunden", 1.0, _SECOND),
    ("min minute minutes Minute Minuten", 60.0, _SECOND),
    ("h hour hours Stunde Stunden", 3600.0, _SECOND),
    ("day days Tag Tage", 86_400.0, _SECOND),
    ("inch inches in", 0.0254, _METRE),
    ("ft foot feet", 0.3048, _METRE),
    ("mil thou", 0.0254e-3, _METRE),
    ("micron microns", 1e-6, _METRE),
    ("° Grad Deg DEG", math.radians(1.0), _RADIAN),
    ("Rad RAD", 1.0, _RADIAN),
    ("gon", math.pi / 200.0, _RADIAN),
    ("arcmin", math.radians(1.0 / 60.0), _RADIAN),
    ("arcsec", math.radians(1.0 / 3600.0), _RADIAN),
    ("mas", math.radians(1e-3 / 3600.0), _RADIAN),
    ("rev revs turn turns revolution revolutions U Umdr Umdrehung Umdrehungen", _TURN, _RADIAN),
    ("rpm RPM Rpm", _TURN / 60.0, _RADIAN / _SECOND),
    ("rps", _TURN, _RADIAN / _SECOND),
    ("gn g0", 9.80665, _METRE / _SECOND**2),
    ("kgf kp", 9.80665, _NEWTON),
    ("lbf", 4.4482216152605, _NEWTON),
    ("ozf", 4.4482216152605 / 16.0, _NEWTON),
    ("Ncm", 1e-2, _TORQUE),
    ("Nmm", 1e-3, _TORQUE),
    ("mNmm", 1e-6, _TORQUE),
)

_COUNTED: Final = """
    count counts cts cnt cnts ct inc incs incr incrs increment increments Inkr Ink Inkremente Inkrement pulse pulses
    Impulse step steps lsb LSB LSBs bit bits Bit Bits digit digits tick ticks qc
"""
COUNT_UNITS: Final = frozenset(_COUNTED.split())
"""Units of encoder or converter counts, whose size only the user knows."""
PER_TURN: Final = frozenset({"cpr", "ppr", "CPR", "PPR"})
"""Counts per turn."""


def _table() -> dict[str, tuple[float, Unit]]:
    known: dict[str, tuple[float, Unit]] = {}
    for symbol, factor, unit, prefixes in _SYMBOLS:
        known[symbol] = factor, unit
        known |= {prefix + symbol: (_PREFIXES[prefix] * factor, unit) for prefix in prefixes.split()}
    for name, factor, unit in _LONG:
        for prefix, size in (("", 1.0), *_LONG_PREFIXES.items()):
            written = prefix + name
            for spelled in (written, written.capitalize()):  # National Instruments writes Volts and Amps
                known |= dict.fromkeys((spelled, f"{spelled}s"), (size * factor, unit))
    for names, factor, unit in _OTHERS:
        known |= dict.fromkeys(names.split(), (factor, unit))
    return known


UNIT_NAMES: Final = _table()
"""Factor to SI and unit by name."""
