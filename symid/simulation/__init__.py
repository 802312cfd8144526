"""Simulation of declared axes: trajectories, controllers, dynamics and the engine that runs them."""

from symid.simulation.closed_loop import Simulation, simulate
from symid.simulation.controller import (
    Cascade,
    Command,
    Controller,
    LinearLaw,
    OpenLoop,
    Replay,
    tuned_cascade,
    tuned_cascades,
)
from symid.simulation.engine import Engine
from symid.simulation.excitation import chirp, from_log, steps
from symid.simulation.forward_dynamics import ForwardDynamics, forward_dynamics, plant_of
from symid.simulation.limits import Extremes, Limits
from symid.simulation.moves import MoveProfile, move, trapezoids
from symid.simulation.multisine import Multisine, frequency_lines, multisine
from symid.simulation.plant import Plant, SensorRow
from symid.simulation.reference_loop import ClosedLoop
from symid.simulation.trajectory import Trajectory

__all__ = [
    "Cascade",
    "ClosedLoop",
    "Command",
    "Controller",
    "Engine",
    "Extremes",
    "ForwardDynamics",
    "Limits",
    "LinearLaw",
    "MoveProfile",
    "Multisine",
    "OpenLoop",
    "Plant",
    "Replay",
    "SensorRow",
    "Simulation",
    "Trajectory",
    "chirp",
    "forward_dynamics",
    "frequency_lines",
    "from_log",
    "move",
    "multisine",
    "plant_of",
    "simulate",
    "steps",
    "trapezoids",
    "tuned_cascade",
    "tuned_cascades",
]
