"""Cases of the axes in models/."""

from axes.case import SCREW, Case
from axes.plant import Sensor, coulomb, friction, plant
from symid import (
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    ViscousFriction,
    load_axis,
)


def rigid_case() -> Case:
    return Case(
        load_axis("rigid_1m"),
        {"M": 362.58, "Fv": 88.6, "Fs": 146.0},
        lambda p: plant([[p.M]], [[p.Fv]], [[0]], [1], nonlinear=[([1], coulomb(p.Fs))], force_size=400),
        {"q": Sensor((1,))},
        shipped=True,
    )


def direct_2m1s_case() -> Case:
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


def ballscrew_2m1s_case() -> Case:
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


def direct_3m2s_case() -> Case:
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


def emps_case() -> Case:
    return Case(
        load_axis("emps"),
        {"M": 95.1, "Fv": 203.5, "Fc": 20.39, "OF": -3.16},
        lambda p: plant(
            [[p.M]], [[p.Fv]], [[0]], [1], constant=[-p.OF], nonlinear=[([1], coulomb(p.Fc))], force_size=60
        ),
        {"q": Sensor((1,))},
        shipped=True,
    )


def emps_asymmetric_case() -> Case:
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


def motor_bench_case() -> Case:
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


def geared_ballscrew_3m2s_case() -> Case:
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


CASES = (
    rigid_case(),
    direct_2m1s_case(),
    ballscrew_2m1s_case(),
    direct_3m2s_case(),
    emps_case(),
    emps_asymmetric_case(),
    motor_bench_case(),
    geared_ballscrew_3m2s_case(),
)
