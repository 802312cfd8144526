"""Generated NumPy modules: their text, their folder, and the record through which the numeric packages use them.

Importing this package needs no sympy; `symid.codegen.generate` does.
"""

from symid.codegen.generated_models import as_generated, load_generated, model_of
from symid.codegen.model import GeneratedModel, declared_delays, passed_over

__all__ = ["GeneratedModel", "as_generated", "declared_delays", "load_generated", "model_of", "passed_over"]
