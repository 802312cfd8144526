"""Cases with gears, weights and pendulums."""

from axes.case import GRAVITY, INCLINE, PINION, SCREW, Case
from axes.plant import Sensor, coulomb, pendulum, plant
from symid import (
    GROUND,
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Damper,
    Drive,
    Geared,
    OffsetForce,
    PendulumWeight,
    Position,
    Spring,
    Velocity,
    ViscousFriction,
    Weight,
)


def rigid_gear_case(name: str, ratio: float) -> Case:
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


def rack_and_pinion_case() -> Case:
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


def vertical_2m1s_case() -> Case:
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


def inclined_case() -> Case:
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


def pendulum_case() -> Case:
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


def flexible_pendulum_case() -> Case:
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


def turning_bench_case() -> Case:
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


CASES = (
    rigid_gear_case("reduction_gear", 0.2),
    rigid_gear_case("reversing_gear", -SCREW),
    rigid_gear_case("overdrive_gear", 2),
    rack_and_pinion_case(),
    vertical_2m1s_case(),
    inclined_case(),
    pendulum_case(),
    flexible_pendulum_case(),
    turning_bench_case(),
)
