"""EMPS with friction that depends on the direction of motion, the second fit of its published report."""

from symid import AsymmetricFriction, Axis, Body, Drive, Position

load = Body("motor", mass="M")

axis = Axis(
    "emps_asymmetric",
    elements=(load, AsymmetricFriction(load, viscous=("Fvp", "Fvn"), coulomb=("Fcp", "Fcn"))),
    drive=Drive("F", load, gain=35.15065188248547, command="vir"),
    sensors=(Position("q", load),),
)
