"""Simulation of declared axes: trajectories, controllers, dynamics, and one loop that runs them.

`trajectories` command the motion, `plants` are axes at given parameter values, `controllers` drive them. `simulate`
makes the controllers and sensors of an axis into a loop around its plant. Between two events all joints
stay in one stick-slip mode, and a sample of the loop is a few products of small matrices: `loops` has these as
records of arrays, and `compiled_loop` makes sample after sample of them, for any law of a controller, any
law of a joint and any sensor. In a sample in which a joint sticks, slips or turns, its `stick_slip` locates the events
exactly and sets the next mode. A controller without matrices is asked for the force of each sample from within the
compiled loop.
"""

from symid.simulation.closed_loop import Simulation, simulate
from symid.simulation.controllers.cascade_tuning import tuned_cascade, tuned_cascades
from symid.simulation.controllers.controller import Cascade, Command, Controller, LinearLaw, OpenLoop
from symid.simulation.controllers.replay import Replay
from symid.simulation.plants.forward_dynamics import (
    ForwardDynamics,
    feedthrough_of,
    forward_dynamics,
    plant_of,
)
from symid.simulation.plants.plant import Plant, SensorRow
from symid.simulation.reference_loop import ClosedLoop, without_noise
from symid.simulation.trajectories.excitation import chirp, from_log, largest_within, steps
from symid.simulation.trajectories.limits import Extremes, Limits
from symid.simulation.trajectories.moves import MoveProfile, move, trapezoids
from symid.simulation.trajectories.multisine import frequency_lines, multisine, whole_periods
from symid.simulation.trajectories.trajectory import Trajectory

__all__ = [
    "Cascade",
    "ClosedLoop",
    "Command",
    "Controller",
    "Extremes",
    "ForwardDynamics",
    "Limits",
    "LinearLaw",
    "MoveProfile",
    "OpenLoop",
    "Plant",
    "Replay",
    "SensorRow",
    "Simulation",
    "Trajectory",
    "chirp",
    "feedthrough_of",
    "forward_dynamics",
    "frequency_lines",
    "from_log",
    "largest_within",
    "move",
    "multisine",
    "plant_of",
    "simulate",
    "steps",
    "trapezoids",
    "tuned_cascade",
    "tuned_cascades",
    "whole_periods",
    "without_noise",
]
