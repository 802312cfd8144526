"""Export of an identified axis to the programs in which its users simulate and control."""

from symid.export.c_source import c_source
from symid.export.exported import Exported
from symid.export.fmu import write_fmu
from symid.export.mjcf import mjcf
from symid.export.parameters import parameter_record
from symid.export.structured_text import structured_text
from symid.export.urdf import urdf

__all__ = ["Exported", "c_source", "mjcf", "parameter_record", "structured_text", "urdf", "write_fmu"]
