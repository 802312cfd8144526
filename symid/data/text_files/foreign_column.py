"""A column of a foreign log with its guessed meaning."""

from dataclasses import dataclass, replace

from symid.data.text_files.column_names import match, measured_in, split_header, words_of
from symid.data.text_files.column_words import Quantity
from symid.errors import LogError
from symid.units import to_si


@dataclass(frozen=True)
class ForeignColumn:
    """A column with its guessed meaning."""

    header: str
    """As written in the file."""
    quantity: Quantity | None
    """Guessed quantity; None without evidence."""
    unit: str | None
    """Unit that `to_si` reads; None where none is known."""
    setpoint: bool
    """Whether it seems to be commanded, not measured."""
    reason: str
    """Reason for the guess."""
    stated: bool
    """Whether the file states the unit; otherwise it is guessed, or unknown."""
    doubt: str = ""
    """Evidence that the values are not numbers of a quantity; empty without such evidence."""
    scaled: bool = False
    """Whether the values cannot be in SI and their unit is unknown, such as counts of an encoder."""
    constant: bool = False
    """Whether all values are equal."""
    extent: tuple[float, float] = (0.0, 0.0)
    """Lowest and highest value."""
    coarse: bool = False
    """Whether it is a time that several samples share, as it is rounded."""
    row_period: float | None = None
    """Period by which the numbers of the rows give a coarse time, in its unit; None where it does not rise evenly."""

    @property
    def name(self) -> str:
        """Its header without the unit."""
        return split_header(self.header)[0]

    def is_named(self, pattern: str) -> bool:
        """Whether a word of its name matches a pattern."""
        return match(words_of(self.name), pattern) is not None


def with_unit(column: ForeignColumn, unit: str) -> ForeignColumn:
    """A column in a unit that the user gives; LogError if no quantity of a log has this unit."""
    quantity, read = measured_in(unit)
    if quantity is None:
        to_si(unit)
        raise LogError(
            f"unit {unit!r} is not a unit of any signal of an axis: give one such as ms, mm, rpm, N or A"
        )
    return replace(column, quantity=quantity, unit=read, reason="its unit is given", stated=True)
