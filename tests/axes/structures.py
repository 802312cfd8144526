"""Cases with several springs, redundant sensors or accelerometers alone."""

from axes.case import Case
from axes.plant import Sensor, coulomb, plant
from symid import (
    GROUND,
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    Spring,
    Velocity,
    ViscousFriction,
)


def two_springs_case() -> Case:
    """One body between two springs to the ground: only their sum can be seen."""
    body = Body("body", mass="M")
    declared = Axis(
        "two_springs",
        (
            body,
            ViscousFriction(body, "F"),
            Spring("left", Between(first=GROUND, second=body), stiffness="K1"),
            Spring("right", body, stiffness="K2"),
        ),
        Drive("f", body),
        (Position("q", body),),
    )
    return Case(
        declared,
        {"M": 2.0, "F": 3.0, "K1": 500.0, "K2": 800.0},
        lambda p: plant([[p.M]], [[p.F]], [[p.K1 + p.K2]], [1]),
        {"q": Sensor((1,))},
    )


def triangle_case() -> Case:
    """Three bodies, each joined to each: two paths lead from the driven body to either of the others."""
    a, b, c = Body("a", mass="Ma"), Body("b", mass="Mb"), Body("c", mass="Mc")
    declared = Axis(
        "triangle",
        (
            a,
            ViscousFriction(a, "Fa"),
            b,
            c,
            Spring("ab", Between(first=a, second=b), stiffness="Kab", damping="Fab"),
            Spring("bc", Between(first=b, second=c), stiffness="Kbc"),
            Spring("ca", Between(first=c, second=a), stiffness="Kca"),
        ),
        Drive("F", a),
        (Position("qa", a), Acceleration("ddb", b), Velocity("dc", c)),
    )
    return Case(
        declared,
        {"Ma": 2.0, "Fa": 3.0, "Mb": 1.0, "Mc": 1.5, "Kab": 900.0, "Fab": 2.0, "Kbc": 700.0, "Kca": 500.0},
        lambda p: plant(
            [[p.Ma, 0, 0], [0, p.Mb, 0], [0, 0, p.Mc]],
            [[p.Fa + p.Fab, -p.Fab, 0], [-p.Fab, p.Fab, 0], [0, 0, 0]],
            [
                [p.Kab + p.Kca, -p.Kab, -p.Kca],
                [-p.Kab, p.Kab + p.Kbc, -p.Kbc],
                [-p.Kca, -p.Kbc, p.Kbc + p.Kca],
            ],
            [1, 0, 0],
        ),
        {"qa": Sensor((1, 0, 0)), "ddb": Sensor((0, 1, 0), 2), "dc": Sensor((0, 0, 1), 1)},
    )


def both_ends_case() -> Case:
    """Three bodies in a row, sensors at both ends: the middle is not seen."""
    a, b, c = Body("a", mass="Ma"), Body("b", mass="Mb"), Body("c", mass="Mc")
    declared = Axis(
        "both_ends",
        (
            a,
            CoulombFriction(a, "Fs"),
            b,
            ViscousFriction(b, "Fb"),
            c,
            Spring("ab", Between(first=a, second=b), stiffness="Kab", damping="Fab"),
            Spring("bc", Between(first=b, second=c), stiffness="Kbc", damping="Fbc"),
        ),
        Drive("F", a),
        (Position("qa", a), Position("qc", c), Acceleration("ddc", c), Velocity("dqb", b)),
    )
    return Case(
        declared,
        {
            "Ma": 2.0,
            "Fs": 0.2,
            "Mb": 1.0,
            "Fb": 4.0,
            "Mc": 1.5,
            "Kab": 900.0,
            "Fab": 2.0,
            "Kbc": 700.0,
            "Fbc": 3.0,
        },
        lambda p: plant(
            [[p.Ma, 0, 0], [0, p.Mb, 0], [0, 0, p.Mc]],
            [[p.Fab, -p.Fab, 0], [-p.Fab, p.Fab + p.Fb + p.Fbc, -p.Fbc], [0, -p.Fbc, p.Fbc]],
            [[p.Kab, -p.Kab, 0], [-p.Kab, p.Kab + p.Kbc, -p.Kbc], [0, -p.Kbc, p.Kbc]],
            [1, 0, 0],
            nonlinear=[([1, 0, 0], coulomb(p.Fs))],
        ),
        {
            "qa": Sensor((1, 0, 0)),
            "qc": Sensor((0, 0, 1)),
            "ddc": Sensor((0, 0, 1), 2),
            "dqb": Sensor((0, 1, 0), 1),
        },
    )


def redundant_sensors_case() -> Case:
    """The paper's axis with sensors that repeat each other: absolute against relative, velocity against position."""
    structure = Body("structure", mass="Ms")
    motor = Body("motor", mass="Mm", on=structure)
    declared = Axis(
        "redundant_sensors",
        (
            structure,
            ViscousFriction(structure, "Fvs"),
            Spring("foundation", structure, stiffness="Ks"),
            motor,
            ViscousFriction(motor, "Fvm"),
            CoulombFriction(motor, "Fsm"),
        ),
        Drive("Fm", motor),
        (
            Position("q2", motor),
            Acceleration("ddxm", motor, relative_to=GROUND),
            Acceleration("ddq1", structure),
            Velocity("dq2", motor),
        ),
    )
    return Case(
        declared,
        {"Ms": 30.0, "Fvs": 300.0, "Ks": 4e5, "Mm": 12.0, "Fvm": 100.0, "Fsm": 0.4},
        lambda p: plant(
            [[p.Ms, 0], [0, p.Mm]],
            [[p.Fvs + p.Fvm, -p.Fvm], [-p.Fvm, p.Fvm]],
            [[p.Ks, 0], [0, 0]],
            [-1, 1],
            nonlinear=[([-1, 1], coulomb(p.Fsm))],
        ),
        {
            "q2": Sensor((-1, 1)),
            "ddxm": Sensor((0, 1), 2),
            "ddq1": Sensor((1, 0), 2),
            "dq2": Sensor((-1, 1), 1),
        },
    )


def accelerometer_only_case() -> Case:
    """The paper's axis without Coulomb friction, seen by accelerometers alone."""
    structure = Body("structure", mass="Ms")
    motor = Body("motor", mass="Mm", on=structure)
    declared = Axis(
        "accelerometer_only",
        (
            structure,
            ViscousFriction(structure, "Fvs"),
            Spring("foundation", structure, stiffness="Ks"),
            motor,
            ViscousFriction(motor, "Fvm"),
        ),
        Drive("Fm", motor),
        (Acceleration("ddq2", motor), Acceleration("ddq1", structure)),
    )
    return Case(
        declared,
        {"Ms": 30.0, "Fvs": 300.0, "Ks": 4e5, "Mm": 12.0, "Fvm": 100.0},
        lambda p: plant(
            [[p.Ms, 0], [0, p.Mm]], [[p.Fvs + p.Fvm, -p.Fvm], [-p.Fvm, p.Fvm]], [[p.Ks, 0], [0, 0]], [-1, 1]
        ),
        {"ddq2": Sensor((-1, 1), 2), "ddq1": Sensor((1, 0), 2)},
    )


def parallel_masses_case() -> Case:
    """Two masses rigidly side by side: only their sum can be seen."""
    first = Body("first", mass="M1")
    second = Body("second", mass="M2", geared=Geared(to=first, ratio=1))
    declared = Axis(
        "parallel_masses",
        (first, ViscousFriction(first, "Fv"), second),
        Drive("F", first),
        (Position("q", first),),
    )
    return Case(
        declared,
        {"M1": 2.0, "Fv": 3.0, "M2": 5.0},
        lambda p: plant([[p.M1 + p.M2]], [[p.Fv]], [[0]], [1]),
        {"q": Sensor((1,))},
    )


def single_letters_case() -> Case:
    """Names that a generated function might use for its own variables: y for an axis, c1 for a damper."""
    first, second = Body("first", mass="c1"), Body("second", mass="a")
    declared = Axis(
        "single_letters",
        (
            first,
            ViscousFriction(first, "c0"),
            CoulombFriction(first, "sign"),
            Spring("coupling", Between(first=first, second=second), stiffness="c", damping="b"),
            second,
            ViscousFriction(second, "c_0"),
        ),
        Drive("W", first),
        (Position("y", first), Position("v", second)),
    )
    return Case(
        declared,
        {"c1": 2.0, "c0": 0.3, "sign": 0.2, "c": 500.0, "b": 0.7, "a": 3.0, "c_0": 0.4},
        lambda p: plant(
            [[p.c1, 0], [0, p.a]],
            [[p.c0 + p.b, -p.b], [-p.b, p.b + p.c_0]],
            [[p.c, -p.c], [-p.c, p.c]],
            [1, 0],
            nonlinear=[([1, 0], coulomb(p.sign))],
        ),
        {"y": Sensor((1, 0)), "v": Sensor((0, 1))},
    )


CASES = (
    two_springs_case(),
    triangle_case(),
    both_ends_case(),
    redundant_sensors_case(),
    accelerometer_only_case(),
    parallel_masses_case(),
    single_letters_case(),
)
