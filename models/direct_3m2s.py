"""The paper's axis with a load hung on the motor by a spring: 3M2S. `ddql` is relative to the motor."""

from symid import Acceleration, Axis, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction

structure = Body("structure", mass="Ms")
motor = Body("motor", mass="Mm", on=structure)
load = Body("load", mass="Ml", on=motor)

axis = Axis(
    "direct_3m2s",
    elements=(
        structure,
        ViscousFriction(structure, "Fvs"),
        Spring("foundation", structure, stiffness="Ks"),
        motor,
        ViscousFriction(motor, "Fvm"),
        CoulombFriction(motor, "Fsm"),
        Spring("transmission", load, stiffness="Kl", damping="Fl"),
        load,
    ),
    drive=Drive("Fm", motor),
    sensors=(Position("q2", motor), Acceleration("ddq1", structure), Acceleration("ddql", load)),
)
