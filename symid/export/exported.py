"""What an export gives: files, and what the axis lost on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Exported:
    """An axis in the language of another program.

    Parameters
    ----------
    files : mapping of str to str
        Text by the suffix of its file, the main one first.
    losses : tuple of str
        What the target cannot express of the axis, one sentence each.
    """

    files: Mapping[str, str]
    losses: tuple[str, ...]

    @property
    def text(self) -> str:
        """Text of the main file."""
        return next(iter(self.files.values()))

    @property
    def whole(self) -> str:
        """All files as one text: what the main one includes stands before it."""
        main, *others = self.files.values()
        lines = (line for line in main.splitlines(keepends=True) if not line.startswith('#include "'))
        return "\n".join([*others, "".join(lines)])
