"""One rigid mass with viscous and Coulomb friction, paper eq. [45]."""

from symid import Axis, Body, CoulombFriction, Drive, Position, ViscousFriction

table = Body("motor", mass="M")

axis = Axis(
    "rigid_1m",
    elements=(table, ViscousFriction(table, "Fv"), CoulombFriction(table, "Fs")),
    drive=Drive("F", table),
    sensors=(Position("q", table),),
)
