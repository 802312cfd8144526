"""The paper's linear direct-drive axis 2M1S: a motor that slides on a flexible structure, eqs. [1]-[4]."""

from symid import Acceleration, Axis, Body, CoulombFriction, Drive, Position, Spring, ViscousFriction

structure = Body("structure", mass="Ms")
motor = Body("motor", mass="Mm", on=structure)

axis = Axis(
    "direct_2m1s",
    elements=(
        structure,
        ViscousFriction(structure, "Fvs"),
        Spring("foundation", structure, stiffness="Ks"),
        motor,
        ViscousFriction(motor, "Fvm"),
        CoulombFriction(motor, "Fsm"),
    ),
    drive=Drive("Fm", motor),
    sensors=(Position("q2", motor), Acceleration("ddq1", structure), Acceleration("ddq2", motor)),
)
