"""Export of an identified axis to the programs in which its users simulate and control."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from symid.export.c_source import c_source
from symid.export.exported import Exported, TextTarget, require_physical
from symid.export.fmu import write_fmu
from symid.export.mjcf import mjcf
from symid.export.parameters import parameter_record
from symid.export.structured_text import structured_text
from symid.export.urdf import urdf
from symid.registered import registered

TEXT_TARGETS: Final[Mapping[str, TextTarget]] = MappingProxyType(
    {target.name: target for target in registered(__name__, "TARGET")}
)
"""Formats by the name that `symid export --to` takes: those that a module of this package describes as `TARGET`."""

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
