"""Generated NumPy modules: their text, the folder that holds them, and the record that the numeric half reads.

Importing this package needs no sympy; `symid.codegen.generate` does.
"""

from symid.codegen.model import GeneratedModel
from symid.codegen.store import as_generated, delays_of, load_generated, model_of, passed_over

__all__ = ["GeneratedModel", "as_generated", "delays_of", "load_generated", "model_of", "passed_over"]
