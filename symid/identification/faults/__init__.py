"""Faults of recorders, logs and structure that contradict an estimate."""

from symid.identification.faults.constant_force import CONSTANT, is_constant
from symid.identification.faults.poor_fit import unexplained_statement
from symid.identification.faults.recording import channel_fault, held_fault
from symid.identification.faults.smoothing import interpolated_from, uneven_averaging, updated_every

__all__ = [
    "CONSTANT",
    "channel_fault",
    "held_fault",
    "interpolated_from",
    "is_constant",
    "uneven_averaging",
    "unexplained_statement",
    "updated_every",
]
