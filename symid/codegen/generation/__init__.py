"""From derived models to text: NumPy code of their expressions, modules, records of forward dynamics. Needs sympy."""

from symid.codegen.generation.dynamics_record import dynamics_record
from symid.codegen.generation.generate import generate, plan
from symid.codegen.generation.lowering import minimal_parameter_code, numpy_code, symbol_names
from symid.codegen.generation.module import model_signals

__all__ = [
    "dynamics_record",
    "generate",
    "minimal_parameter_code",
    "model_signals",
    "numpy_code",
    "plan",
    "symbol_names",
]
