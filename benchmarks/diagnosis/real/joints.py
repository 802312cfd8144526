"""The cases of single joints of other machines: a robot, a servo, a motor that turns slowly, a shoulder, a lift."""

from collections.abc import Iterator

from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    OffsetForce,
    PendulumWeight,
    Position,
    Spring,
    UnknownZero,
    ViscousFriction,
)

from . import recordings
from .case import Case, identified
from .plain import LOAD, Script

_COULOMB = ("coulomb_friction", "body")


def rigid(name: str, drive: tuple[str, str], position: str, *, hangs: bool, dry: bool = False) -> Axis:
    """A turning body with viscous friction, and weight and Coulomb friction as wanted.

    Parameters
    ----------
    name : str
        Of the axis.
    drive : (str, str)
        Signal and unit of the force.
    position : str
        Signal of the angle.
    hangs, dry : bool
        Whether it has weight, and Coulomb friction.
    """
    body = Body("body", inertia="J")
    weight = (PendulumWeight(body, "ml"),) if hangs else ()
    coulomb = (CoulombFriction(body, "Fc"),) if dry else ()
    elements = (body, *weight, ViscousFriction(body, "Fv"), *coulomb)
    return Axis(name, elements, Drive(drive[0], body, unit=drive[1]), (Position(position, body),))


def robot() -> Iterator[Case]:
    """Axis 1 of a robot of six: as one body, then with its joint and the encoder behind the gear."""
    a, b, c = (recordings.robot(which) for which in "ABC")
    axis = rigid("robot_rigid", ("tau", "N*m"), "qm", hangs=False)
    yield Case(
        name="robot-viscous",
        model="one inertia and viscous friction, motor encoder",
        published="Coulomb 355 N m, viscous 2050 N m s/rad, offset 54 N m; the inertia depends on the pose of the "
        "other axes, 719 to 1690 kg m^2 and the motor's 609 kg m^2",
        right=(_COULOMB,),
        axis=axis,
        training=(a, c),
        held_out=b,
        script=Script("tau", "qm", ("inertia", "viscous"), ("coulomb",)),
        band_hz=20.0,
    )
    yield Case(
        name="robot-flexible",
        model="motor with friction and arm joined by a spring, both encoders, published values",
        published="the encoder behind the gear is read 2.8 ms late, which is 91 % of the difference of the two; "
        "stiffness 4.6e6 N m/rad, backlash 3e-5 rad. The force shows none of this",
        right=(("sensor_delay", "ql"),),
        axis=_joint(),
        training=(a, c),
        held_out=b,
        nominal={"Jm": 609.0, "Fvm": 2050.0, "Fcm": 355.0, "Kt": 4.6e6, "Pt": 0.0, "Jl": 1000.0},
        script=Script("tau", "qm", ("inertia", "viscous", "coulomb")),
        band_hz=20.0,
    )


def _joint() -> Axis:
    motor, arm = Body("motor", inertia="Jm"), Body("arm", inertia="Jl")
    gear = Between(first=motor, second=arm)
    spring, zero = Spring("gear", gear, stiffness="Kt"), UnknownZero(gear, "Pt")
    friction = ViscousFriction(motor, "Fvm"), CoulombFriction(motor, "Fcm")
    sensors = Position("qm", motor), Position("ql", arm)
    return Axis("robot_flexible", (motor, arm, spring, zero, *friction), Drive("tau", motor), sensors)


def servo() -> Iterator[Case]:
    """A servo motor that swings a weight on a lever; at twice the gain of its controller by a model without it."""
    axis = rigid("servo", ("u", "V"), "q", hangs=True)
    runs = [recordings.servo(run) for run in ("10h28m32", "10h28m10", "10h28m24", "10h29m04")]
    yield Case(
        name="servo-viscous",
        model="inertia, weight and viscous friction in units of voltage",
        published="the authors fit Coulomb, Stribeck and load-dependent friction (0.07 to 0.27 of the load)",
        right=(_COULOMB, ("load_dependent_friction", "body"), ("stribeck_friction", "body")),
        axis=axis,
        training=tuple(runs[:3]),
        held_out=runs[3],
        script=Script("u", "q", ("inertia", "weight", "viscous"), (LOAD,)),
        band_hz=15.0,
    )
    first, second = (recordings.servo(run) for run in ("10h28m42", "10h28m57"))
    axis = rigid("servo", ("u", "V"), "q", hangs=False, dry=True)
    yield Case(
        name="servo-weightless",
        model="inertia, viscous and Coulomb friction in units of voltage, at twice the gain of the controller",
        published="a weight of 0.49 kg at 0.1 m",
        right=(("weight", "body"),),
        axis=axis,
        training=(first, second),
        held_out=runs[3],
        script=Script("u", "q", ("inertia", "viscous", "coulomb"), ("weight",)),
        band_hz=15.0,
    )


def motor() -> Iterator[Case]:
    """A direct-drive motor that turns slowly, once in 10 s; the held-out log without the return that precedes it.

    At last with the controller's map of the cogging, whose current shows the cogging as well.
    """
    cases = (
        ("motor-viscous", "nocomp", False),
        ("motor-friction", "nocomp", True),
        ("motor-map", "comp", True),
    )
    for name, run, dry in cases:
        first, second = recordings.motor(f"{run}_0"), recordings.motor(f"{run}_1").between(0.5, 10.0)
        axis = rigid("motor", ("i", "A"), "q", hangs=False, dry=dry)
        yield Case(
            name=name,
            model=f"inertia, viscous {'and Coulomb ' if dry else ''}friction in units of current",
            published="cogging of orders 7, 14, 28, 36 and 12 a turn, strongest 7. It turns one way only: Coulomb "
            "friction is a constant",
            right=(("cogging", "body"),),
            axis=axis,
            training=(first,),
            held_out=second,
            nominal=identified(axis, first) if run == "nocomp" else {},  # the map alone makes J negative
            script=Script("i", "q", ("inertia", "viscous", *(("coulomb",) * dry)), ("cogging 7",)),
            band_hz=30.0,
        )


def shoulder() -> Iterator[Case]:
    """The shoulder of a double pendulum while its elbow stands still: the first 6.5 s and the rest of one run.

    The run is one sine near the natural frequency, which does not separate inertia and weight. Nominal values
    are those for which both this run and 144115, a sine of 0.478 Hz, have the force in phase with the angle that they
    show.
    """
    run = recordings.double_pendulum("143906")
    yield Case(
        name="shoulder-viscous",
        model="inertia, weight and viscous friction",
        published="Coulomb 0.16 N m; a torque ripple of 126 waves a turn, 0.026 N m. Not published: the Coulomb level "
        "falls over the run, or with the amplitude",
        right=(_COULOMB,),
        confirmed=(("friction_drift", "body"),),
        axis=rigid("shoulder", ("tau", "N*m"), "q", hangs=True),
        training=(run.between(0.0, 6.5),),
        held_out=run.between(6.5, 10.0),
        nominal={"J": 0.128, "ml": 0.281, "Fv": 0.42},
        script=Script("tau", "q", ("inertia", "weight", "viscous"), ("coulomb",)),
        band_hz=10.0,
    )


def lift() -> Iterator[Case]:
    """The vertical lift of a service robot's torso, without its weight and without its Coulomb friction."""
    run = recordings.tiago("torso_lift_joint")
    first, second = run.between(10.0, 48.0), run.between(48.0, 67.0)
    body = Body("body", mass="M")
    viscous, coulomb, weight = (
        ViscousFriction(body, "Fv"),
        CoulombFriction(body, "Fc"),
        OffsetForce(body, "W"),
    )
    drive, sensors = Drive("F", body), (Position("q", body),)
    values = identified(Axis("lift", (body, viscous, coulomb, weight), drive, sensors), first)
    for name, model, law, right, terms, added in (
        ("lift-weightless", "Coulomb friction", coulomb, "offset_force", "coulomb", "offset"),
        ("lift-frictionless", "weight", weight, "coulomb_friction", "offset", "coulomb"),
    ):
        axis = Axis("lift", (body, viscous, law), drive, sensors)
        yield Case(
            name=name,
            model=f"mass, viscous friction and {model} in units of the motor's effort",
            published="the force is the effort times its constant plus the weight. Not published: Coulomb friction",
            right=((right, "body"),),
            axis=axis,
            training=(first,),
            held_out=second,
            nominal={key: values[key] for key in axis.physical_parameters},
            script=Script("F", "q", ("inertia", "viscous", terms), (added,)),
            band_hz=3.0,
        )
