"""Generated NumPy modules: their text, their folder, and the record through which the numeric packages use them.

Importing this package needs no sympy; `symid.codegen.generate` does.
"""

from symid.codegen.generated_models import compiled, load_generated, model_of
from symid.codegen.model import GeneratedModel, declared_delays, passed_over

__all__ = ["GeneratedModel", "compiled", "declared_delays", "load_generated", "model_of", "passed_over"]
