"""Entries of the catalogue of effects: the law with its parameters, and the remedy on the machine."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Final

from symid.axis import shipped_folder

_ENTRY: Final = re.compile(
    r"^## (?P<name>\w+)\n.*?^\*\*Law\.\*\* (?P<law>.*?)\n\*At\*.*?^\*\*On the machine\.\*\* (?P<remedy>.*?)(?=\n\n|\Z)",
    re.MULTILINE | re.DOTALL,
)
_LINK: Final = re.compile(r"\[([^\]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class CatalogueEntry:
    """An effect in the catalogue."""

    law: str
    remedy: str


@cache
def effect_catalogue() -> Mapping[str, CatalogueEntry]:
    """Entries of the catalogue by the name of the effect, as plain text.

    >>> effect_catalogue()["delay"].law
    'The force acts T later than logged: u(t - T).'
    """
    text = (shipped_folder("docs") / "effects" / "index.md").read_text(encoding="utf-8")
    return {
        found["name"]: CatalogueEntry(_plain(found["law"]), _plain(found["remedy"]))
        for found in _ENTRY.finditer(text)
    }


def _plain(text: str) -> str:
    r"""Text without links and emphasis, in one line.

    >>> _plain("of the *commanded* velocity, see\n[there](#delay) and `--held`; 2 * 3")
    'of the commanded velocity, see there and --held; 2 * 3'
    """
    shown = _LINK.sub(r"\1", " ".join(text.split()))
    return re.sub(r"\*(\S[^*]*?\S|\S)\*", r"\1", shown).replace("`", "")
