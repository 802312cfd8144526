"""Cache of the last values of functions that are asked again for the same arguments."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, TypeVar

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False, repr=False)
class LastValues:
    """The last value of each key.

    >>> memory = LastValues()
    >>> memory.of("squared", 3, lambda: 9), memory.of("squared", 3, lambda: 10), memory.of("squared", 4, lambda: 16)
    (9, 9, 16)
    """

    known: dict[Hashable, tuple[Hashable, Any]] = field(default_factory=dict)

    def of(self, key: Hashable, given: Hashable, compute: Callable[[], Found]) -> Found:
        """Value of a key for `given`: the last one if `given` has not changed, otherwise computed."""
        known = self.known.get(key)
        if known is None or known[0] != given:
            known = self.known[key] = given, compute()
        found: Found = known[1]
        return found
