"""The symbolic half: Lagrange's equations, elimination, minimal parameters and their maps."""

from symid.symbolic.pipeline import DerivedModel, derive

__all__ = ["DerivedModel", "derive"]
