"""The catalogue: each axis as declared to symid, beside its equations of motion written by hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

from axes.plant import Plant, Sensor, Values, coulomb, cubic, drag, friction, pendulum, plant, ripple
from symid import (
    GROUND,
    Acceleration,
    Axis,
    Between,
    Body,
    Cogging,
    CoulombFriction,
    Damper,
    Drive,
    Geared,
    Law,
    OffsetForce,
    PendulumWeight,
    Position,
    QuadraticDrag,
    Spring,
    Term,
    Velocity,
    ViscousFriction,
    Weight,
    load_axis,
)
from symid.codegen import GeneratedModel
from symid.codegen.generate import compiled
from symid.symbolic import DerivedModel, derive

LEAD = 0.01
SCREW = LEAD / (2 * math.pi)
GRAVITY = 9.80665
PINION = 0.025
INCLINE = GRAVITY * math.sin(math.radians(25))


@dataclass(frozen=True)
class Case:
    """An axis and all that is known of it without symid.

    Parameters
    ----------
    declared : Axis
        What symid is given.
    values : mapping of str to float
        Physical parameters in the order in which they must be listed.
    build : callable
        Plant at some values.
    sensors : mapping of str to Sensor
        What each sensor reads of the plant's displacements.
    shipped : bool
        Whether the axis is one of models/.
    refused : tuple of tuple of str
        Sets of sensors from which a nonlinear law cannot be seen.
    hidden : mapping of tuple of str to tuple of str
        Parameters that leave no trace in the signals of a set of sensors.
    """

    declared: Axis
    values: Mapping[str, float]
    build: Callable[[Values], Plant]
    sensors: Mapping[str, Sensor]
    shipped: bool = False
    refused: tuple[tuple[str, ...], ...] = ()
    hidden: Mapping[tuple[str, ...], tuple[str, ...]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the axis."""
        return self.declared.name

    @property
    def sensor_sets(self) -> tuple[tuple[str, ...], ...]:
        """Sets of sensors that allow a model."""
        return tuple(chosen for chosen in self.declared.sensor_sets if chosen not in self.refused)

    def plant(self, **changed: float) -> Plant:
        """Plant at the case's values, some of them changed."""
        return self.build(Values({**self.values, **changed}))


def _rigid() -> Case:
    return Case(
        load_axis("rigid_1m"),
        {"M": 362.58, "Fv": 88.6, "Fs": 146.0},
        lambda p: plant([[p.M]], [[p.Fv]], [[0]], [1], nonlinear=[([1], coulomb(p.Fs))], force_size=400),
        {"q": Sensor((1,))},
        shipped=True,
    )


def _direct_2m1s() -> Case:
    # The motor is at x2 = q1 + q2; its force and its friction act back on the structure.
    return Case(
        load_axis("direct_2m1s"),
        {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0},
        lambda p: plant(
            [[p.Ms, 0], [0, p.Mm]],
            [[p.Fvs + p.Fvm, -p.Fvm], [-p.Fvm, p.Fvm]],
            [[p.Ks, 0], [0, 0]],
            [-1, 1],
            nonlinear=[([-1, 1], coulomb(p.Fsm))],
            force_size=400,
        ),
        {"q2": Sensor((-1, 1)), "ddq1": Sensor((1, 0), 2), "ddq2": Sensor((-1, 1), 2)},
        shipped=True,
    )


def _ballscrew_2m1s() -> Case:
    return Case(
        load_axis("ballscrew_2m1s"),
        {"Mm": 250.0, "Fvm": 400.0, "Fsm": 60.0, "Kt": 4e7, "Ft": 9000.0, "Ml": 420.0, "Fvl": 700.0},
        lambda p: plant(
            [[p.Mm, 0], [0, p.Ml]],
            [[p.Fvm + p.Ft, -p.Ft], [-p.Ft, p.Ft + p.Fvl]],
            [[p.Kt, -p.Kt], [-p.Kt, p.Kt]],
            [1, 0],
            nonlinear=[([1, 0], coulomb(p.Fsm))],
            force_size=200,
        ),
        {"qm": Sensor((1, 0)), "ql": Sensor((0, 1))},
        shipped=True,
    )


def _direct_3m2s() -> Case:
    # Absolute displacements of structure, motor, load; q2 = x2 - x1, ddql is that of x3 - x2.
    return Case(
        load_axis("direct_3m2s"),
        {
            "Ms": 3899.0,
            "Fvs": 39491.7,
            "Ks": 1e9,
            "Mm": 362.58,
            "Fvm": 886.0,
            "Fsm": 146.0,
            "Kl": 5e7,
            "Fl": 9000.0,
            "Ml": 150.0,
        },
        lambda p: plant(
            [[p.Ms, 0, 0], [0, p.Mm, 0], [0, 0, p.Ml]],
            [[p.Fvs + p.Fvm, -p.Fvm, 0], [-p.Fvm, p.Fvm + p.Fl, -p.Fl], [0, -p.Fl, p.Fl]],
            [[p.Ks, 0, 0], [0, p.Kl, -p.Kl], [0, -p.Kl, p.Kl]],
            [-1, 1, 0],
            nonlinear=[([-1, 1, 0], coulomb(p.Fsm))],
            force_size=400,
        ),
        {"q2": Sensor((-1, 1, 0)), "ddq1": Sensor((1, 0, 0), 2), "ddql": Sensor((0, -1, 1), 2)},
        shipped=True,
    )


def _emps() -> Case:
    return Case(
        load_axis("emps"),
        {"M": 95.1, "Fv": 203.5, "Fc": 20.39, "OF": -3.16},
        lambda p: plant(
            [[p.M]], [[p.Fv]], [[0]], [1], constant=[-p.OF], nonlinear=[([1], coulomb(p.Fc))], force_size=60
        ),
        {"q": Sensor((1,))},
        shipped=True,
    )


def _emps_asymmetric() -> Case:
    return Case(
        load_axis("emps_asymmetric"),
        {"M": 95.1, "Fvp": 203.5, "Fcp": 20.39, "Fvn": 190.0, "Fcn": 24.0},
        lambda p: plant(
            [[p.M]],
            [[0]],
            [[0]],
            [1],
            nonlinear=[([1], friction((p.Fvp, p.Fcp), (p.Fvn, p.Fcn)))],
            force_size=60,
        ),
        {"q": Sensor((1,))},
        shipped=True,
    )


def _motor_bench() -> Case:
    return Case(
        load_axis("motor_bench"),
        {"Jm": 2e-3, "Fvm": 4e-3, "Kt": 40.0, "Ft": 0.01, "Pt": -0.7, "Jl": 3e-3, "Fvl": 5e-3},
        lambda p: plant(
            [[p.Jm, 0], [0, p.Jl]],
            [[p.Fvm + p.Ft, -p.Ft], [-p.Ft, p.Ft + p.Fvl]],
            [[p.Kt, -p.Kt], [-p.Kt, p.Kt]],
            [1, 0],
            constant=[p.Pt, -p.Pt],
        ),
        {"qm": Sensor((1, 0)), "ql": Sensor((0, 1))},
        shipped=True,
        hidden={("qm",): ("Pt",)},  # a preload of the coupling only shifts the load
    )


def _geared_ballscrew_3m2s() -> Case:
    """Motor with screw (turning), nut with table by a spring in the screw, load by a second spring."""
    screw, table, load = Body("screw", inertia="Js"), Body("table", mass="Mt"), Body("load", mass="Ml")
    declared = Axis(
        "geared_ballscrew_3m2s",
        (
            screw,
            ViscousFriction(screw, "Fvs"),
            CoulombFriction(screw, "Fsm"),
            Spring("nut", Between(first=screw, second=table, ratio=SCREW), stiffness="Kn", damping="Fn"),
            table,
            ViscousFriction(table, "Fvt"),
            Spring("mounting", Between(first=table, second=load), stiffness="Kl"),
            load,
        ),
        Drive("T", screw),
        (Position("qs", screw), Position("qt", table), Acceleration("ddl", load)),
    )
    return Case(
        declared,
        {
            "Js": 2e-3,
            "Fvs": 3e-2,
            "Fsm": 0.3,
            "Kn": 3e8,
            "Fn": 4e4,
            "Mt": 300.0,
            "Fvt": 3e3,
            "Kl": 6e7,
            "Ml": 200.0,
        },
        lambda p: plant(
            [[p.Js, 0, 0], [0, p.Mt, 0], [0, 0, p.Ml]],
            [[p.Fvs + SCREW**2 * p.Fn, -SCREW * p.Fn, 0], [-SCREW * p.Fn, p.Fn + p.Fvt, 0], [0, 0, 0]],
            [[SCREW**2 * p.Kn, -SCREW * p.Kn, 0], [-SCREW * p.Kn, p.Kn + p.Kl, -p.Kl], [0, -p.Kl, p.Kl]],
            [1, 0, 0],
            nonlinear=[([1, 0, 0], coulomb(p.Fsm))],
        ),
        {"qs": Sensor((1, 0, 0)), "qt": Sensor((0, 1, 0)), "ddl": Sensor((0, 0, 1), 2)},
    )


def _rigid_gear(name: str, ratio: float) -> Case:
    """Friction on both sides of a rigid gear: the table moves `ratio` times as far as the motor."""
    motor = Body("motor", inertia="Jm")
    table = Body("table", mass="Mt", geared=Geared(to=motor, ratio=ratio))
    declared = Axis(
        name,
        (
            motor,
            ViscousFriction(motor, "Fvm"),
            CoulombFriction(motor, "Fsm"),
            table,
            ViscousFriction(table, "Fvt"),
            CoulombFriction(table, "Fst"),
        ),
        Drive("T", motor),
        (Position("qm", motor), Acceleration("ddt", table)),
    )
    size = max(abs(ratio), 1e-3)
    return Case(
        declared,
        {"Jm": 2e-3, "Fvm": 2e-3, "Fsm": 0.2, "Mt": 1e-3 / size**2, "Fvt": 2e-3 / size**2, "Fst": 0.1 / size},
        lambda p: plant(
            [[p.Jm + ratio**2 * p.Mt]],
            [[p.Fvm + ratio**2 * p.Fvt]],
            [[0]],
            [1],
            nonlinear=[([1], coulomb(p.Fsm)), ([ratio], coulomb(p.Fst))],
        ),
        {"qm": Sensor((1,)), "ddt": Sensor((ratio,), 2)},
    )


def _rack_and_pinion() -> Case:
    """A pinion rolls a carriage, on which a load is held by a spring: q of the carriage is that of the pinion."""
    pinion = Body("pinion", inertia="Jp")
    carriage = Body("carriage", mass="Mc", geared=Geared(to=pinion, ratio=PINION))
    load = Body("load", mass="Ml", on=carriage)
    declared = Axis(
        "rack_and_pinion",
        (
            pinion,
            CoulombFriction(pinion, "Fsp"),
            carriage,
            ViscousFriction(carriage, "Fvc"),
            load,
            Spring("arm", load, stiffness="Ka", damping="Fa"),
        ),
        Drive("T", pinion),
        (Position("qp", pinion), Acceleration("ddload", load, relative_to=GROUND)),
    )
    r = PINION
    # In the angle of the pinion and the absolute displacement of the load.
    return Case(
        declared,
        {"Jp": 0.02, "Fsp": 1.5, "Mc": 40.0, "Fvc": 900.0, "Ml": 25.0, "Ka": 1e6, "Fa": 800.0},
        lambda p: plant(
            [[p.Jp + r**2 * p.Mc, 0], [0, p.Ml]],
            [[r**2 * (p.Fvc + p.Fa), -r * p.Fa], [-r * p.Fa, p.Fa]],
            [[r**2 * p.Ka, -r * p.Ka], [-r * p.Ka, p.Ka]],
            [1, 0],
            nonlinear=[([1, 0], coulomb(p.Fsp))],
            force_size=3,
        ),
        {"qp": Sensor((1, 0)), "ddload": Sensor((0, 1), 2)},
    )


def _vertical_2m1s() -> Case:
    motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    declared = Axis(
        "vertical_2m1s",
        (
            motor,
            Weight(motor),
            ViscousFriction(motor, "Fvm"),
            CoulombFriction(motor, "Fsm"),
            Spring("transmission", Between(first=motor, second=load), stiffness="Kt", damping="Ft"),
            load,
            Weight(load),
        ),
        Drive("F", motor),
        (Position("qm", motor), Position("ql", load)),
    )
    return Case(
        declared,
        {"Mm": 40.0, "Fvm": 120.0, "Fsm": 30.0, "Kt": 2e6, "Ft": 500.0, "Ml": 25.0},
        lambda p: plant(
            [[p.Mm, 0], [0, p.Ml]],
            [[p.Fvm + p.Ft, -p.Ft], [-p.Ft, p.Ft]],
            [[p.Kt, -p.Kt], [-p.Kt, p.Kt]],
            [1, 0],
            constant=[-p.Mm * GRAVITY, -p.Ml * GRAVITY],
            nonlinear=[([1, 0], coulomb(p.Fsm))],
            force_size=500,
        ),
        {"qm": Sensor((1, 0)), "ql": Sensor((0, 1))},
    )


def _inclined() -> Case:
    table = Body("table", mass="M")
    declared = Axis(
        "inclined",
        (
            table,
            Weight(table, INCLINE),
            ViscousFriction(table, "Fv"),
            CoulombFriction(table, "Fs"),
            OffsetForce(table, "OF"),
        ),
        Drive("F", table),
        (Position("q", table), Velocity("dq", table), Acceleration("ddq", table)),
    )
    return Case(
        declared,
        {"M": 60.0, "Fv": 200.0, "Fs": 35.0, "OF": 12.0},
        lambda p: plant(
            [[p.M]],
            [[p.Fv]],
            [[0]],
            [1],
            constant=[-p.M * INCLINE - p.OF],
            nonlinear=[([1], coulomb(p.Fs))],
            force_size=300,
        ),
        {"q": Sensor((1,)), "dq": Sensor((1,), 1), "ddq": Sensor((1,), 2)},
    )


def _pendulum() -> Case:
    arm = Body("arm", inertia="J")
    declared = Axis(
        "pendulum",
        (arm, ViscousFriction(arm, "Fv"), CoulombFriction(arm, "Fs"), PendulumWeight(arm, "ml")),
        Drive("T", arm),
        (Position("q", arm), Velocity("dq", arm)),
    )
    return Case(
        declared,
        {"J": 0.06, "Fv": 0.02, "Fs": 0.1, "ml": 0.3},
        lambda p: plant(
            [[p.J]],
            [[p.Fv]],
            [[0]],
            [1],
            nonlinear=[([1], coulomb(p.Fs)), ([1], pendulum(p.ml, GRAVITY))],
            force_size=0.2,
        ),
        {"q": Sensor((1,)), "dq": Sensor((1,), 1)},
    )


def _flexible_pendulum() -> Case:
    """A motor turns an arm by an elastic reduction of 50: from the arm alone, sin q is differentiated twice."""
    ratio = 1 / 50
    motor, arm = Body("motor", inertia="Jm"), Body("arm", inertia="Ja")
    declared = Axis(
        "flexible_pendulum",
        (
            motor,
            ViscousFriction(motor, "Fvm"),
            Spring("reduction", Between(first=motor, second=arm, ratio=ratio), stiffness="Kr"),
            arm,
            ViscousFriction(arm, "Fva"),
            PendulumWeight(arm, "ml"),
        ),
        Drive("T", motor),
        (Position("qa", arm), Position("qm", motor)),
    )
    return Case(
        declared,
        {"Jm": 1e-4, "Fvm": 2e-4, "Kr": 60.0, "Ja": 0.3, "Fva": 0.5, "ml": 0.8},
        lambda p: plant(
            [[p.Jm, 0], [0, p.Ja]],
            [[p.Fvm, 0], [0, p.Fva]],
            [[ratio**2 * p.Kr, -ratio * p.Kr], [-ratio * p.Kr, p.Kr]],
            [1, 0],
            nonlinear=[([0, 1], pendulum(p.ml, GRAVITY))],
            force_size=0.2,
        ),
        {"qa": Sensor((0, 1)), "qm": Sensor((1, 0))},
    )


def _turning_bench() -> Case:
    first, second = Body("first", inertia="J1"), Body("second", inertia="J2")
    declared = Axis(
        "turning_bench",
        (
            first,
            CoulombFriction(first, "Fs"),
            Spring("coupling", Between(first=first, second=second), stiffness="K"),
            Damper("rubber", Between(first=first, second=second), damping="F"),
            second,
        ),
        Drive("i", first, unit="A"),
        (Velocity("dq1", first), Velocity("dq2", second)),
    )
    return Case(
        declared,
        {"J1": 2e-3, "Fs": 0.1, "K": 40.0, "F": 0.02, "J2": 3e-3},
        lambda p: plant(
            [[p.J1, 0], [0, p.J2]],
            [[p.F, -p.F], [-p.F, p.F]],
            [[p.K, -p.K], [-p.K, p.K]],
            [1, 0],
            nonlinear=[([1, 0], coulomb(p.Fs))],
        ),
        {"dq1": Sensor((1, 0), 1), "dq2": Sensor((0, 1), 1)},
    )


def _two_springs() -> Case:
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


def _triangle() -> Case:
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


def _both_ends() -> Case:
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


def _redundant_sensors() -> Case:
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


def _accelerometer_only() -> Case:
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


def _friction_in_the_spring() -> Case:
    """Coulomb friction between two bodies: seen by a sensor between them, or by one at each."""
    motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    across = Between(first=motor, second=load)
    declared = Axis(
        "friction_in_the_spring",
        (
            motor,
            ViscousFriction(motor, "Fvm"),
            Spring("transmission", across, stiffness="Kt"),
            CoulombFriction(across, "Fst"),
            load,
        ),
        Drive("F", motor),
        (Position("d", load, relative_to=motor), Velocity("dqm", motor), Position("qm", motor)),
    )
    return Case(
        declared,
        {"Mm": 12.0, "Fvm": 90.0, "Kt": 4e5, "Fst": 0.4, "Ml": 30.0},
        lambda p: plant(
            [[p.Mm, 0], [0, p.Ml]],
            [[p.Fvm, 0], [0, 0]],
            [[p.Kt, -p.Kt], [-p.Kt, p.Kt]],
            [1, 0],
            nonlinear=[([-1, 1], coulomb(p.Fst))],
        ),
        {"d": Sensor((-1, 1)), "dqm": Sensor((1, 0), 1), "qm": Sensor((1, 0))},
    )


@dataclass(frozen=True)
class HardeningSpring(Law):
    """k q^3: a smooth law of the user's own, to be differentiated exactly."""

    stiffness: str

    def terms(self) -> tuple[Term, ...]:
        """One cubic term."""
        return (Term(self.stiffness, "q**3", 3),)


def _hardening_spring() -> Case:
    motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    declared = Axis(
        "hardening_spring",
        (
            motor,
            HardeningSpring(motor, "K3"),
            CoulombFriction(motor, "Fs"),
            Spring("transmission", Between(first=motor, second=load), stiffness="Kt", damping="Ft"),
            load,
        ),
        Drive("F", motor),
        (Position("qm", motor), Acceleration("ddl", load)),
    )
    return Case(
        declared,
        {"Mm": 1.0, "K3": 3e5, "Fs": 0.3, "Kt": 300.0, "Ft": 3.0, "Ml": 2.0},
        lambda p: plant(
            [[p.Mm, 0], [0, p.Ml]],
            [[p.Ft, -p.Ft], [-p.Ft, p.Ft]],
            [[p.Kt, -p.Kt], [-p.Kt, p.Kt]],
            [1, 0],
            nonlinear=[([1, 0], cubic(p.K3)), ([1, 0], coulomb(p.Fs))],
            force_size=5,
        ),
        {"qm": Sensor((1, 0)), "ddl": Sensor((0, 1), 2)},
    )


def _ripple_and_drag() -> Case:
    """Laws of effects whose second derivatives stand in the regressor, because the structure is not measured."""
    structure = Body("structure", mass="Ms")
    motor = Body("motor", mass="Mm", on=structure)
    declared = Axis(
        "ripple_and_drag",
        (
            structure,
            Spring("foundation", structure, stiffness="Ks", damping="Fs"),
            motor,
            QuadraticDrag(motor, "c"),
            Cogging(motor, "As", "Ac", pitch=0.5),
        ),
        Drive("F", motor),
        (Position("q2", motor), Acceleration("ddq1", structure)),
    )
    return Case(
        declared,
        {"Ms": 3.0, "Ks": 200.0, "Fs": 4.0, "Mm": 2.0, "c": 5.0, "As": 1.5, "Ac": -0.7},
        lambda p: plant(
            [[p.Ms, 0], [0, p.Mm]],
            [[p.Fs, 0], [0, 0]],
            [[p.Ks, 0], [0, 0]],
            [-1, 1],
            nonlinear=[([-1, 1], drag(p.c)), ([-1, 1], ripple(p.As, p.Ac, 0.5))],
            force_size=5,
        ),
        {"q2": Sensor((-1, 1)), "ddq1": Sensor((1, 0), 2)},
    )


def _parallel_masses() -> Case:
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


def _single_letters() -> Case:
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


@cache
def cases() -> dict[str, Case]:
    """All axes of the catalogue that are not chains, by name."""
    from axes.chains import chain_cases

    made = (
        _rigid(),
        _direct_2m1s(),
        _ballscrew_2m1s(),
        _direct_3m2s(),
        _emps(),
        _emps_asymmetric(),
        _motor_bench(),
        _geared_ballscrew_3m2s(),
        _rigid_gear("reduction_gear", 0.2),
        _rigid_gear("reversing_gear", -SCREW),
        _rigid_gear("overdrive_gear", 2),
        _rack_and_pinion(),
        _vertical_2m1s(),
        _inclined(),
        _pendulum(),
        _flexible_pendulum(),
        _turning_bench(),
        _two_springs(),
        _triangle(),
        _both_ends(),
        _redundant_sensors(),
        _accelerometer_only(),
        _friction_in_the_spring(),
        _hardening_spring(),
        _ripple_and_drag(),
        _parallel_masses(),
        _single_letters(),
        *chain_cases(),
    )
    return {case.name: case for case in made}


def every_set() -> list[tuple[str, tuple[str, ...]]]:
    """Every axis of the catalogue with every of its sets of sensors."""
    return [(name, chosen) for name, case in cases().items() for chosen in case.sensor_sets]


@cache
def derived(name: str, measured: tuple[str, ...]) -> DerivedModel:
    """Derived model of an axis of the catalogue."""
    return derive(cases()[name].declared, measured)


@cache
def generated(name: str, measured: tuple[str, ...]) -> GeneratedModel:
    """Generated module of an axis of the catalogue, compiled in memory."""
    return compiled(derived(name, measured))
