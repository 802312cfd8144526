"""Commanded motions: moves, chirps, multisines, steps, motions of a log, and their limits."""

from symid.simulation.trajectories.excitation import Sweep
from symid.simulation.trajectories.multisine import MotionQuantity

__all__ = [
    "MotionQuantity",
    "Sweep",
]
