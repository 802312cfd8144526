"""Hash of a declaration, the same in every process."""

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass

from symid.axis.imperfections import Imperfection
from symid.axis.laws import Law
from symid.axis.sensors import Sensor

_OF_SIGNALS = ("noise", "resolution", "delay")
"""Fields that do not count: no regressor depends on the imperfections of signals."""
_OPTIONAL = ("gain", "offset", "unit", "ratio", "drive")
"""Fields of sensors and imperfections that count where they are given."""


def hash_of(declared: object) -> str:
    """Hash of a declaration: of the names of classes and the values of fields."""
    return hashlib.sha256(repr(_canonical(declared)).encode()).hexdigest()[:16]


def _canonical(value: object) -> object:
    if isinstance(value, Law):
        # The terms too: a law's class may change while its fields stay.
        return (type(value).__name__, _canonical(value.at), _canonical(value.terms()))
    if is_dataclass(value) and not isinstance(value, type):
        named = (f.name for f in fields(value) if f.name not in _OF_SIGNALS)
        named = (name for name in named if name != "known" or value.known)  # type: ignore[attr-defined]
        if isinstance(value, (Sensor, Imperfection)):
            named = (name for name in named if name not in _OPTIONAL or getattr(value, name) is not None)
        return (type(value).__name__, *((name, _canonical(getattr(value, name))) for name in named))
    if isinstance(value, tuple):
        return tuple(_canonical(item) for item in value)
    if isinstance(value, Mapping):
        return tuple((name, _canonical(item)) for name, item in sorted(value.items()))
    if isinstance(value, float):
        return float(value)  # NumPy's numbers print otherwise
    return value
