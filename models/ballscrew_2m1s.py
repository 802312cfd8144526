"""A ball-screw axis: a motor on the ground that moves a sliding load through an elastic transmission."""

from symid import Axis, Between, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction

motor = Body("motor", mass="Mm")
load = Body("load", mass="Ml")

axis = Axis(
    "ballscrew_2m1s",
    elements=(
        motor,
        ViscousFriction(motor, "Fvm"),
        CoulombFriction(motor, "Fsm"),
        Spring("transmission", Between(first=motor, second=load), stiffness="Kt", damping="Ft"),
        load,
        ViscousFriction(load, "Fvl"),
    ),
    drive=Drive("Fm", motor),
    sensors=(Position("qm", motor), Position("ql", load)),
)
