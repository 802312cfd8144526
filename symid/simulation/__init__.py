"""Simulation of declared axes: trajectories, controllers, dynamics, and one loop that runs them.

`simulate` makes the controllers and sensors of an axis into a `Loop` around its `Plant`. Between two events all joints
stay in one stick-slip mode, and a sample of the loop is a few products of small matrices: `loop_numbers` has these as
records of arrays, and the compiled `sample_loop` makes sample after sample of them, for any law of a controller, any
law of a joint and any sensor. In a sample in which a joint sticks, slips or turns, `stick_slip` locates the events
exactly and sets the next mode. A controller without matrices is asked for the force of each sample from within the
compiled loop.
"""

from symid.simulation.cascade_tuning import tuned_cascade, tuned_cascades
from symid.simulation.closed_loop import Simulation, simulate
from symid.simulation.controller import Cascade, Command, Controller, LinearLaw, OpenLoop
from symid.simulation.excitation import chirp, from_log, largest_within, steps
from symid.simulation.forward_dynamics import ForwardDynamics, feedthrough_of, forward_dynamics, plant_of
from symid.simulation.limits import Extremes, Limits
from symid.simulation.moves import MoveProfile, move, trapezoids
from symid.simulation.multisine import frequency_lines, multisine, whole_periods
from symid.simulation.plant import Plant, SensorRow
from symid.simulation.reference_loop import ClosedLoop
from symid.simulation.replay import Replay
from symid.simulation.trajectory import Trajectory

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
]
