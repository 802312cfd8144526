"""Generated NumPy modules: their folder, and the record through which the numeric packages use them.

Importing this package needs no sympy; `symid.codegen.generation`, which writes the modules, does.
"""

from symid.codegen.generated_models import StoredModule, compiled, load_generated, model_of, stored_module
from symid.codegen.model import GeneratedModel, declared_delays, passed_over
from symid.codegen.store import stored_dynamics, write_stale

__all__ = [
    "GeneratedModel",
    "StoredModule",
    "compiled",
    "declared_delays",
    "load_generated",
    "model_of",
    "passed_over",
    "stored_dynamics",
    "stored_module",
    "write_stale",
]
