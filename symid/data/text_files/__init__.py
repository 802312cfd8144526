"""Files of text as tables: their layout, numbers, times, and the names and units of their columns."""

from symid.data.text_files.column_words import ANGLES, TORQUE, TORQUE_CURRENT
from symid.data.text_files.foreign import LONGEST_STROKE, quantity_named
from symid.data.text_files.foreign_column import with_unit
from symid.data.text_files.layout import first_lines

__all__ = [
    "ANGLES",
    "LONGEST_STROKE",
    "TORQUE",
    "TORQUE_CURRENT",
    "first_lines",
    "quantity_named",
    "with_unit",
]
