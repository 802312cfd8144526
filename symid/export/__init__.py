"""Export of an identified axis to where its users simulate and control."""

from symid.export.c_source import c_source
from symid.export.exported import Exported
from symid.export.fmu import write_fmu
from symid.export.mjcf import mjcf
from symid.export.parameters import parameter_record

__all__ = ["Exported", "c_source", "mjcf", "parameter_record", "write_fmu"]
