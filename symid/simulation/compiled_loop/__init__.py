"""The samples of a loop, compiled. Imported when a simulation runs: Numba takes 0.3 s to load."""

from symid.simulation.compiled_loop.evaluation import built_up, evaluate
from symid.simulation.compiled_loop.products import recursion

__all__ = [
    "built_up",
    "evaluate",
    "recursion",
]
