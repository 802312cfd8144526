"""Export of an identified axis to where its users simulate and control: C, MuJoCo, FMU, JSON."""

from symid.export.c_source import c_source
from symid.export.exported import Exported


__all__ = ["Exported", "c_source"]
