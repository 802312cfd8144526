"""Errors that symid raises when its input is wrong.

Every message states the fault, the value, the requirement and the cure. Numerical outcomes on
real data are not errors: they are a status in the result.
"""

from collections.abc import Sequence


class SymidError(Exception):
    """A mistake in what the user gave; the command line prints it as one line and exits with 2."""


class DeclarationError(SymidError, ValueError):
    """One or more faults of an axis declaration, all reported at once.

    Attributes
    ----------
    faults : tuple of str
        One sentence for each fault.
    """

    def __init__(self, axis: str, faults: Sequence[str]) -> None:
        self.axis = axis
        self.faults = tuple(faults)
        super().__init__(f"axis {axis!r}: " + "; ".join(self.faults))


class EliminationError(SymidError):
    """The sensors given do not allow an identification model; the message names the element and a sensor that helps."""


class LogError(SymidError):
    """A log cannot be used: unreadable, a missing or wrong column, a clock that is not uniform, bad values."""


class GeneratedModuleError(SymidError):
    """A generated module is missing or older than its declaration; the message names the command that renews it."""


class SettingError(SymidError, ValueError):
    """An option or argument outside what is possible (a cutoff above the Nyquist frequency, ...).

    >>> from symid import load_axis
    >>> try:
    ...     load_axis("rigid_1m").with_known({"mass": 1.0})
    ... except ValueError as error:
    ...     print(error)
    known: there is no parameter 'mass': choose from Fs, Fv, M
    """
