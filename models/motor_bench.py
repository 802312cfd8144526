"""Two motors joined by a flexible coupling, the bench of data/flex_motor_bench. The torque is in units of current.

The encoders are incremental: their zeros differ by an unknown angle, which differs from log to log.
"""

from symid import Axis, Between, Body, Drive, Position, Spring, UnknownZero, ViscousFriction

motor = Body("motor", inertia="Jm")
load = Body("load", inertia="Jl")

coupling = Between(first=motor, second=load)

axis = Axis(
    "motor_bench",
    elements=(
        motor,
        ViscousFriction(motor, "Fvm"),
        Spring("transmission", coupling, stiffness="Kt", damping="Ft"),
        UnknownZero(coupling, "Pt"),
        load,
        ViscousFriction(load, "Fvl"),
    ),
    drive=Drive("iq", motor, unit="A"),
    sensors=(Position("qm", motor), Position("ql", load)),
)
