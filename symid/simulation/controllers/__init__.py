"""Controllers of an axis: cascades and their tuning, recorded forces, and laws as matrices."""

from symid.simulation.controllers.controller import linear_law

__all__ = [
    "linear_law",
]
