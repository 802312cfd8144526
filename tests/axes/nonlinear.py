"""Cases with nonlinear laws."""

from dataclasses import dataclass

from axes.case import Case
from axes.plant import Sensor, coulomb, cubic, drag, plant, ripple
from symid import (
    Acceleration,
    Axis,
    Between,
    Body,
    Cogging,
    CoulombFriction,
    Drive,
    Law,
    Position,
    QuadraticDrag,
    Spring,
    Term,
    Velocity,
    ViscousFriction,
)


def friction_in_the_spring_case() -> Case:
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


def hardening_spring_case() -> Case:
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


def ripple_and_drag_case() -> Case:
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


CASES = (friction_in_the_spring_case(), hardening_spring_case(), ripple_and_drag_case())
