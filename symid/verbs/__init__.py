"""The Python interface: every verb takes an axis, its name or file, or a model, and logs, files or data frames."""

from symid.verbs.identify_any import identify
from symid.verbs.methods import METHODS, method_of

__all__ = [
    "METHODS",
    "identify",
    "method_of",
]
