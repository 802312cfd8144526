"""EMPS, the electro-mechanical positioning system of the nonlinear benchmarks: a rigid axis with an offset."""

from symid import Axis, Body, CoulombFriction, Drive, OffsetForce, Position, ViscousFriction

load = Body("motor", mass="M")

axis = Axis(
    "emps",
    elements=(load, ViscousFriction(load, "Fv"), CoulombFriction(load, "Fc"), OffsetForce(load, "OF")),
    drive=Drive("F", load, gain=35.15065188248547, command="vir"),
    sensors=(Position("q", load),),
)
