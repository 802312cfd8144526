"""Units: their algebra, and their notations in logs."""

from symid.units.names import COUNT_UNITS, UNIT_NAMES
from symid.units.unit import BASE_UNITS, Unit
from symid.units.written import to_si

__all__ = ["BASE_UNITS", "COUNT_UNITS", "UNIT_NAMES", "Unit", "to_si"]
