"""Export of an identified axis to the programs in which its users simulate and control."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from symid.axis import Axis
from symid.export.c_source import c_source
from symid.export.exported import Exported, require_physical
from symid.export.fmu import write_fmu
from symid.export.mjcf import mjcf
from symid.export.parameters import parameter_record
from symid.export.structured_text import structured_text
from symid.export.urdf import urdf


class TextTarget(NamedTuple):
    """A format whose files are texts made of an axis and the values of its parameters, SI."""

    program: str  # the program or language, as the help of the command names it
    write: Callable[[Axis, Mapping[str, float]], Exported]


TEXT_TARGETS: Final[Mapping[str, TextTarget]] = MappingProxyType(
    {
        "mjcf": TextTarget("MuJoCo", mjcf),
        "urdf": TextTarget("URDF", urdf),
        "st": TextTarget("feed-forward in Structured Text", structured_text),
    }
)
"""Formats by the name that `symid export --to` takes; a new one is a module and a line here."""

__all__ = [
    "TEXT_TARGETS",
    "Exported",
    "TextTarget",
    "c_source",
    "mjcf",
    "parameter_record",
    "require_physical",
    "structured_text",
    "urdf",
    "write_fmu",
]
