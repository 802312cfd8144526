"""Units: their algebra, and their notations in logs."""

from symid.units.unit import BASE_UNITS, Unit
from symid.units.written import to_si

__all__ = ["BASE_UNITS", "Unit", "to_si"]
